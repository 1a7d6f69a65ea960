#include "acus/patient/phantom/planning/image_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/text_table.h"
#include "acus/base/math/angles.h"
#include "acus/data/volume/label_map_content.h"
#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr double kRadiusMm = 60.0;
constexpr double kHalfAngleRad = 30.0 * math::kRadPerDegree;
constexpr double kImageDepthMm = 150.0;
constexpr double kGelMm = 3.0;        ///< Fills air up to this between face and skin.
constexpr double kOfUseMm = 20.0;     ///< Of soft tissue behind the face.
constexpr double kEchoMm = 1.0;       ///< What ends a beam is seen itself.
constexpr double kUnderSkinMm = 5.0;  ///< A needle is not seen nearer to the skin than this.
constexpr double kAroundMm = 3.0;     ///< Of the target.
constexpr int kBeams = 61;
constexpr double kBeamStepMm = 1.0;

struct Beam {
  double reach_mm = 0.0;  ///< From the face.
  std::string end;        ///< What ends it.
};

/// The fan of a probe: polar coordinates about the centre of its curvature.
class Fan {
 public:
  Fan(const PatientField& field, const Vector3d& face, const Vector3d& axis, const Vector3d& across)
      : axis_(axis), across_(across), centre_(face - kRadiusMm * axis) {
    for (int n = 0; n < kBeams; ++n) beams_[static_cast<std::size_t>(n)] = Traced(field, n);
  }

  const std::array<Beam, kBeams>& beams() const { return beams_; }

  bool Sees(const Vector3d& point) const {
    const Vector3d from = point - centre_;
    const double along = from.dot(axis_), aside = from.dot(across_);
    const double angle = std::atan2(aside, along);
    if (std::abs(angle) > kHalfAngleRad) return false;
    const double depth_mm = std::hypot(along, aside) - kRadiusMm;
    const double step = 2.0 * kHalfAngleRad / (kBeams - 1);
    const auto beam = static_cast<std::size_t>(std::lround((angle + kHalfAngleRad) / step));
    return depth_mm >= 0.0 && depth_mm <= beams_[beam].reach_mm + kEchoMm;
  }

 private:
  Beam Traced(const PatientField& field, int n) const {
    const double angle = kHalfAngleRad * (2.0 * n / (kBeams - 1) - 1.0);
    const Vector3d direction = std::cos(angle) * axis_ + std::sin(angle) * across_;
    const Vector3d start = centre_ + kRadiusMm * direction;
    bool is_inside = false;
    for (double depth = 0.0; depth <= kImageDepthMm; depth += kBeamStepMm) {
      const volume::Label label = field.LabelAt(start + depth * direction);
      if (label == 0 && !is_inside && depth <= kGelMm) continue;
      if (label == 0) return {is_inside ? depth : 0.0, is_inside ? "the end of the body" : "air"};
      is_inside = true;
      if (EndsBeam(label)) return {depth, volume::NameOfLabel(label)};
    }
    return {kImageDepthMm, "the depth of the image"};
  }

  static bool EndsBeam(volume::Label label) {
    static const std::array kEnds = {volume::LabelOf("bone"), volume::LabelOf("lung"),
                                     volume::LabelOf("gas")};
    return std::ranges::find(kEnds, label) != kEnds.end();
  }

  Vector3d axis_, across_, centre_;
  std::array<Beam, kBeams> beams_;
};

double ShareOfTarget(const Fan& fan, const InsertionPlan& plan) {
  int seen = fan.Sees(plan.target_ct_mm) ? 1 : 0;
  for (int side = 0; side < 8; ++side) {
    const double angle = 45.0 * side * math::kRadPerDegree;
    const Vector3d off = std::cos(angle) * plan.heading + std::sin(angle) * plan.skin_normal;
    seen += fan.Sees(plan.target_ct_mm + kAroundMm * off) ? 1 : 0;
  }
  return seen / 9.0;
}

double ShareOfNeedle(const Fan& fan, const InsertionPlan& plan) {
  int seen = 0, all = 0;
  for (double depth = kUnderSkinMm; depth <= plan.length_mm(); depth += kBeamStepMm, ++all) {
    seen += fan.Sees(plan.entry_ct_mm + depth * plan.direction) ? 1 : 0;
  }
  return static_cast<double>(seen) / std::max(all, 1);
}

}  // namespace

ImageView ViewOf(const PatientField& field, const InsertionPlan& plan) {
  const Vector3d ahead = plan.entry_ct_mm + kProbeAheadMm * plan.heading;
  const auto face = SkinAlong(field, ahead, plan.skin_normal, 25.0);
  if (!face) return {};
  const Vector3d inwards = -SkinNormal(field, *face);
  const Vector3d axis = (inwards - inwards.dot(plan.lateral()) * plan.lateral()).normalized();
  const Fan fan(field, *face, axis, axis.cross(plan.lateral()));
  ImageView view;
  view.target = ShareOfTarget(fan, plan);
  view.needle = ShareOfNeedle(fan, plan);
  const double target_depth_mm = (plan.target_ct_mm - *face).dot(axis);
  int of_use = 0;
  for (const Beam& beam : fan.beams()) {
    of_use += beam.reach_mm >= kOfUseMm ? 1 : 0;
    if (beam.reach_mm < target_depth_mm) ++view.hidden_by[beam.end];
  }
  view.face = static_cast<double>(of_use) / kBeams;
  return view;
}

std::string ViewText(const ImageView& view) {
  const auto percent = [](double share) { return Message(std::lround(100.0 * share), " %"); };
  const std::string target = view.target >= 0.5  ? "the target, "
                             : view.target > 0.0 ? "a part of the target, "
                                                 : "not the target, ";
  std::string text = Message(target, percent(view.needle), " of the needle; ", percent(view.face),
                             " of the face on soft tissue");
  const auto most =
      std::ranges::max_element(view.hidden_by, {}, [](const auto& h) { return h.second; });
  if (view.target < 0.5 && most != view.hidden_by.end()) {
    text += Message("; ", percent(static_cast<double>(most->second) / kBeams),
                    " of the beams end at ", most->first, " above it");
  }
  return text;
}

}  // namespace acus::phantom
