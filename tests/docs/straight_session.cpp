// Writes a session of one straight insertion, for figures:
//   straight_session CORRIDOR.csv SESSION_FOLDER
// From 5 mm above the point "entry" to the point "target" at 5 mm/s, 1 kHz, in CT space.
#include <algorithm>
#include <iostream>

#include "acus/base/core/error.h"
#include "acus/base/core/run_context.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/session_io.h"
#include "acus/data/transforms/landmarks.h"

namespace {

Eigen::Vector3d PointOf(const acus::transforms::Landmarks& points, const std::string& name) {
  const auto found = std::ranges::find(points.names, name);
  ACUS_REQUIRE(found != points.names.end(), points.source, ": has no point ", name);
  return points.points_mm.col(found - points.names.begin());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: straight_session CORRIDOR.csv SESSION_FOLDER\n";
    return 2;
  }
  try {
    const acus::transforms::Landmarks points = acus::transforms::ReadLandmarks(argv[1]);
    const Eigen::Vector3d entry_mm = PointOf(points, "entry");
    const Eigen::Vector3d way_mm = PointOf(points, "target") - entry_mm;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), way_mm).toRotationMatrix();
    acus::session::Session session;
    session.name = "straight insertion";
    for (int ms = 0; 0.005 * ms - 5.0 <= way_mm.norm(); ++ms) {
      pose.translation() = entry_mm + (0.005 * ms - 5.0) * way_mm.normalized();
      session.needle.push_back({ms * std::int64_t{1'000'000}, pose, true});
    }
    acus::session::WriteSession(argv[2], session, acus::RunContext());
  } catch (const std::exception& error) {
    std::cerr << "straight_session: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
