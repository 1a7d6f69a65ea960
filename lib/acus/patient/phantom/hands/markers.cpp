#include "acus/patient/phantom/hands/markers.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/random.h"

namespace acus::phantom {

using Eigen::Vector3d;

std::vector<NamedPoint> PlaceMarkers(const PatientField& field, const InsertionPlan& plan,
                                     const MarkerSettings& settings, const RunContext& context) {
  std::vector<NamedPoint> markers;
  for (int i = 0; i < settings.count; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / settings.count;
    const Vector3d out = std::cos(angle) * plan.heading + std::sin(angle) * plan.lateral();
    const double full = settings.radius_mm * (i % 2 == 0 ? 1.0 : 0.8);
    for (double radius = full; radius > 0.25 * full; radius -= 0.05 * full) {
      const auto skin = SkinAlong(field, plan.entry_ct_mm + radius * out, plan.skin_normal, 80.0);
      if (!skin || !field.bounds_ct_mm().contains(*skin)) continue;
      markers.push_back({"M" + std::to_string(i + 1), *skin});
      break;
    }
  }
  if (markers.size() < 3) {
    throw NoAnswerError(Message("only ", markers.size(), " markers find skin within ",
                                settings.radius_mm, " mm of the entry; three are needed"));
  }
  if (markers.size() < static_cast<std::size_t>(settings.count)) {
    context.Warn(Message("only ", markers.size(), " of ", settings.count, " markers find skin"));
  }
  return markers;
}

std::vector<NamedPoint> LocateOnMannequin(const std::vector<NamedPoint>& markers_ct,
                                          const MarkerSettings& settings, std::uint64_t seed) {
  std::vector<NamedPoint> located;
  for (std::size_t i = 0; i < markers_ct.size(); ++i) {
    RandomStream random(seed, "localisation error", i);
    const Vector3d error(random.Normal(), random.Normal(), random.Normal());
    located.push_back({markers_ct[i].name, settings.reference_from_ct * markers_ct[i].position_mm +
                                               settings.fle_mm / std::sqrt(3.0) * error});
  }
  return located;
}

void WritePoints(const std::filesystem::path& path, const std::vector<NamedPoint>& points) {
  std::string text = "name,x_mm,y_mm,z_mm\n";
  for (const NamedPoint& point : points) {
    text += point.name;
    for (const double x : point.position_mm) text += "," + NumberText(x);
    text += "\n";
  }
  WriteTextFile(path, text);
}

}  // namespace acus::phantom
