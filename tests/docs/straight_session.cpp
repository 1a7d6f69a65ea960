// Writes a session of one straight insertion, for figures:
//   straight_session CORRIDOR.csv SESSION_FOLDER
// From 5 mm above the point "entry" to the point "target" at 5 mm/s, 1 kHz, in CT space.
#include <iostream>

#include "core/error.h"
#include "core/run_context.h"
#include "math/rigid.h"
#include "registration/landmarks.h"
#include "session/session_io.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: straight_session CORRIDOR.csv SESSION_FOLDER\n";
    return 2;
  }
  try {
    const acus::registration::Landmarks points = acus::registration::ReadLandmarks(argv[1]);
    Eigen::Vector3d entry_mm, target_mm;
    for (std::size_t i = 0; i < points.names.size(); ++i) {
      const Eigen::Vector3d point_mm = points.points_mm.col(static_cast<Eigen::Index>(i));
      if (points.names[i] == "entry") entry_mm = point_mm;
      if (points.names[i] == "target") target_mm = point_mm;
    }
    const Eigen::Vector3d way_mm = target_mm - entry_mm;
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
