#include "acus/scene/simulation/needle_line.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/data/transforms/landmarks.h"

namespace acus::simulation {

NeedleLine ReadNeedleLine(const std::filesystem::path& corridor) {
  const transforms::Landmarks points = transforms::ReadLandmarks(corridor);
  const auto find = [&](const char* name) -> Eigen::Vector3d {
    const auto at = std::ranges::find(points.names, name);
    ACUS_REQUIRE(at != points.names.end(), corridor.string(), ": has no point named \"", name,
                 "\"; the points entry and target are needed (CT space, LPS, mm)");
    return points.points_mm.col(at - points.names.begin());
  };
  const Eigen::Vector3d entry_mm = find("entry");
  const Eigen::Vector3d way_mm = find("target") - entry_mm;
  ACUS_REQUIRE(way_mm.norm() > 1.0, corridor.string(), ": entry and target are ", way_mm.norm(),
               " mm apart; they must be more than 1 mm apart");
  return {entry_mm, way_mm};
}

}  // namespace acus::simulation
