#include "acus/patient/phantom/planning/approach_window.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/spelling.h"
#include "acus/base/math/angles.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/planning/rib_shadow.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

/// Directions of LPS: left +x, posterior +y, superior +z.
Approach From(double left, double posterior, double superior, const Vector3d& axis,
              double cone_deg) {
  return {Vector3d(left, posterior, superior).normalized(), axis, cone_deg * math::kRadPerDegree};
}

/// Beside the spinous processes, from below, in a sagittal plane: as in the presets of the phantom.
std::vector<Approach> ParamedianApproaches(double side) {
  return {From(0.20 * side, 0.87, -0.45, Vector3d::UnitZ(), 25.0),
          From(-0.20 * side, 0.87, -0.45, Vector3d::UnitZ(), 25.0)};
}

std::vector<Approach> MidlineApproaches(double /*side*/) {
  return {From(0.0, 0.92, -0.38, Vector3d::UnitZ(), 22.0)};
}

/// In plane with a probe across the back.
std::vector<Approach> TransverseApproaches(double side) {
  return {From(0.45 * side, 0.89, 0.0, Vector3d::UnitX(), 25.0),
          From(-0.45 * side, 0.89, 0.0, Vector3d::UnitX(), 25.0)};
}

/// From the front and below, the image plane tilted towards the head.
std::vector<Approach> SubcostalApproaches(double side) {
  return {From(-0.3 * side, -0.75, -0.6, Vector3d::UnitX(), 35.0),
          From(0.3 * side, -0.75, -0.6, Vector3d::UnitX(), 35.0)};
}

std::vector<Approach> IntercostalApproaches(double side) {
  return {From(0.95 * side, -0.3, 0.0, Vector3d::Zero(), 30.0),
          From(0.7 * side, -0.7, 0.0, Vector3d::Zero(), 30.0),
          From(0.95 * side, 0.3, 0.0, Vector3d::Zero(), 30.0)};
}

/// From the side of the back, as nephrostomies are; the image plane along the body.
std::vector<Approach> FlankApproaches(double side) {
  return {From(0.65 * side, 0.72, -0.2, Vector3d::UnitZ(), 35.0),
          From(0.9 * side, 0.3, -0.2, Vector3d::UnitZ(), 30.0)};
}

std::vector<Approach> AnteriorApproaches(double /*side*/) {
  return {From(0.0, -1.0, 0.0, Vector3d::Zero(), 40.0)};
}

std::vector<Approach> ShortestApproaches(double side) {
  std::vector<Approach> all;
  for (const Vector3d& out : {Vector3d(0, -1, 0), Vector3d(side, 0, 0), Vector3d(0, 1, 0),
                              Vector3d(-side, 0, 0), Vector3d(0, 0, 1), Vector3d(0, 0, -1)}) {
    all.push_back({out, Vector3d::Zero(), 55.0 * math::kRadPerDegree});
  }
  return all;
}

/// Distance of the entry from the middle of the patient.
double OffMiddleMm(const BodyFrame& frame, const WindowPlace& place) {
  return std::abs(place.entry_ct_mm.x() - frame.MiddleXMm(place.entry_ct_mm.z()));
}

bool IsParamedian(const PatientField& /*field*/, const BodyFrame& frame, const WindowPlace& place,
                  Vector3d& /*axis*/) {
  const double off_mm = OffMiddleMm(frame, place);
  return off_mm >= 10.0 && off_mm <= 15.0;
}

bool IsMidline(const PatientField& /*field*/, const BodyFrame& frame, const WindowPlace& place,
               Vector3d& /*axis*/) {
  return OffMiddleMm(frame, place) <= 4.0;
}

bool IsTransverse(const PatientField& /*field*/, const BodyFrame& frame, const WindowPlace& place,
                  Vector3d& /*axis*/) {
  const double off_mm = OffMiddleMm(frame, place);
  return off_mm >= 15.0 && off_mm <= 60.0 && std::abs(place.direction.z()) < 0.35;
}

/// On the front, with no rib or other bone between the entry and the belly below it.
bool IsSubcostal(const PatientField& field, const BodyFrame& /*frame*/, const WindowPlace& place,
                 Vector3d& /*axis*/) {
  if (place.skin_normal.y() > -0.35 || place.direction.z() < 0.2) return false;
  static const volume::Label kBone = volume::LabelOf("bone");
  static const volume::Label kCartilage = volume::LabelOf("cartilage");
  for (double below = 0.0; below <= 45.0; below += 3.0) {
    for (double across = -12.0; across <= 12.0; across += 4.0) {
      for (double depth = 0.0; depth <= 45.0; depth += 3.0) {
        const Vector3d at =
            place.entry_ct_mm + Vector3d(across, 0.0, -below) - depth * place.skin_normal;
        const volume::Label label = field.LabelAt(at);
        if (label == kBone || label == kCartilage) return false;
      }
    }
  }
  return true;
}

bool IsIntercostal(const PatientField& field, const BodyFrame& /*frame*/, const WindowPlace& place,
                   Vector3d& image_axis) {
  const RibShadow shadow(field, place.entry_ct_mm, place.skin_normal);
  if (!shadow.IsBetweenRibs()) return false;
  image_axis = shadow.rib_direction();
  return true;
}

bool IsFlank(const PatientField& /*field*/, const BodyFrame& frame, const WindowPlace& place,
             Vector3d& /*axis*/) {
  return place.direction.y() < -0.05 && OffMiddleMm(frame, place) > 45.0;
}

bool IsAnterior(const PatientField& /*field*/, const BodyFrame& /*frame*/, const WindowPlace& place,
                Vector3d& /*axis*/) {
  return place.skin_normal.y() < -0.5;
}

bool IsAny(const PatientField& /*field*/, const BodyFrame& /*frame*/, const WindowPlace& /*place*/,
           Vector3d& /*axis*/) {
  return true;
}

}  // namespace

std::span<const ApproachWindow> ApproachWindows() {
  static const std::array<ApproachWindow, 8> kWindows = {{
      {"paramedian", "10 to 15 mm beside the midline of the back, sagittal oblique image",
       "spinal_canal", true, ParamedianApproaches, IsParamedian},
      {"midline", "between two spinous processes, median image", "spinal_canal", true,
       MidlineApproaches, IsMidline},
      {"transverse", "from the side, in a transverse image of the back", "spinal_canal", true,
       TransverseApproaches, IsTransverse},
      {"intercostal", "between two ribs, image parallel to them", "liver", false,
       IntercostalApproaches, IsIntercostal},
      {"subcostal", "from the front, below the ribs, image tilted to the head", "liver", false,
       SubcostalApproaches, IsSubcostal},
      {"flank", "from the side of the back, image along the body", "kidney", false, FlankApproaches,
       IsFlank},
      {"anterior", "from the front", "", false, AnteriorApproaches, IsAnterior},
      {"shortest", "the shortest free path from any side", "", false, ShortestApproaches, IsAny},
  }};
  return kWindows;
}

std::vector<std::string> WindowNames() {
  std::vector<std::string> names;
  for (const ApproachWindow& window : ApproachWindows()) names.emplace_back(window.name);
  return names;
}

const ApproachWindow& WindowNamed(const std::string& name) {
  for (const ApproachWindow& window : ApproachWindows()) {
    if (window.name == name) return window;
  }
  const auto nearest = NearestSpelling(name, WindowNames());
  throw InputError(Message("no window is named '", name, "'",
                           nearest ? Message("; did you mean '", *nearest, "'?") : std::string()));
}

std::vector<const ApproachWindow*> UsualWindows(const std::string& structure,
                                                const std::string& organ) {
  static const std::map<std::string, std::vector<std::string>, std::less<>> kUsual = {
      {"spinal_canal", {"paramedian", "midline", "transverse"}},
      {"ligament", {"paramedian", "midline", "transverse"}},
      {"liver", {"intercostal", "subcostal"}},
      {"gallbladder", {"intercostal", "subcostal"}},
      {"kidney", {"flank"}}};
  auto usual = kUsual.find(structure);
  if (usual == kUsual.end()) usual = kUsual.find(organ);
  std::vector<const ApproachWindow*> windows;
  if (usual != kUsual.end()) {
    for (const std::string& name : usual->second) windows.push_back(&WindowNamed(name));
  }
  windows.push_back(&WindowNamed("shortest"));
  return windows;
}

}  // namespace acus::phantom
