#include "acus/patient/phantom/planning/insertion_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/math/angles.h"
#include "acus/base/math/rigid.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/planning/image_view.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr double kBorderMm = 8.0;  ///< Entry points this near to the volume's border are not used.
constexpr double kProbeAcrossMm = 24.0;  ///< How far it is swept to either side.
constexpr double kShortestMm = 20.0;     ///< A search that finds nothing longer ends here.

bool Avoided(const PlanSettings& settings, volume::Label label) {
  return std::ranges::find(settings.avoid, label) != settings.avoid.end();
}

/// Depth at which a ray from the entry meets bone, if it meets nothing else that is to be avoided.
std::optional<double> BoneDepth(const PatientField& field, const InsertionPlan& plan,
                                const Vector3d& axis, double angle_rad,
                                const PlanSettings& settings) {
  static const volume::Label kBone = volume::LabelOf("bone");
  static const volume::Label kCanal = volume::LabelOf("spinal_canal");
  const Vector3d direction = Eigen::AngleAxisd(angle_rad, axis) * plan.direction;
  for (double depth = 0.0; depth <= plan.length_mm(); depth += 0.05) {
    const volume::Label label = field.LabelAt(plan.entry_ct_mm + depth * direction);
    if (label == kBone) return depth;
    if (label == kCanal || Avoided(settings, label)) return std::nullopt;
  }
  return std::nullopt;
}

/// True if a turn runs squarely into bone: a little more or less meets it too, at a like depth.
std::optional<double> SquareBoneDepth(const PatientField& field, const InsertionPlan& plan,
                                      const Vector3d& axis, double angle,
                                      const PlanSettings& settings) {
  constexpr double kMinDepthMm = 10.0, kLikeMm = 5.0;
  const auto depth = BoneDepth(field, plan, axis, angle, settings);
  if (!depth || *depth < kMinDepthMm) return std::nullopt;
  for (const double more : {-math::kRadPerDegree, math::kRadPerDegree}) {
    const auto near = BoneDepth(field, plan, axis, angle + more, settings);
    if (!near || std::abs(*near - *depth) > kLikeMm) return std::nullopt;
  }
  return depth;
}

/// What speaks against a path, in arbitrary points: fat along it, an end in fat, bone or lung right
/// under the probe, nothing to see there because the volume or the body ends; an end in the liver
/// or a lesion speaks for it, one outside the trunk against it.
double TissueCost(const PatientField& field, const InsertionPlan& plan,
                  const PlanSettings& settings, const BodyFrame* frame) {
  constexpr double kOffTrunk = 100.0;  // More than all else: only if nothing else is free.
  static const volume::Label kFat = volume::LabelOf("fat");
  static const volume::Label kLiver = volume::LabelOf("liver");
  static const volume::Label kLesion = volume::LabelOf("lesion");
  const volume::Label end = field.LabelAt(plan.target_ct_mm);
  const double end_cost = end == kLesion ? -80.0 : end == kLiver ? -60.0 : end == kFat ? 25.0 : 0.0;
  const int steps = static_cast<int>(plan.length_mm());
  int fat = 0;
  for (int i = 0; i < steps; ++i) {
    fat += field.LabelAt(plan.entry_ct_mm + i * plan.direction) == kFat ? 1 : 0;
  }
  int hidden = 0;
  const Vector3d face = plan.entry_ct_mm + kProbeAheadMm * plan.heading;
  for (int depth = 2; depth <= 30; ++depth) {
    hidden += Avoided(settings, field.LabelAt(face - depth * plan.skin_normal)) ? 1 : 0;
  }
  int missing = 0;
  for (const double along : {-20.0, 0.0, 20.0}) {
    for (int depth = 5; depth <= 75; depth += 5) {
      const Vector3d at = face + along * plan.heading - depth * plan.skin_normal;
      missing += field.LabelAt(at) == 0 ? 1 : 0;
    }
  }
  const double off_trunk = frame && !frame->IsTrunk(plan.target_ct_mm) ? kOffTrunk : 0.0;
  return off_trunk + end_cost + 30.0 * fat / std::max(steps, 1) + 1.0 * hidden + 0.5 * missing;
}

/// In the same points, 0 for an image that shows all.
double ImageCost(const ImageView& view) {
  return 10.0 * (4.0 - view.Score());
}

struct Candidate {
  double cost = std::numeric_limits<double>::infinity();
  std::optional<InsertionPlan> plan;
};

/// Tries paths from one entry point, tilted towards four sides, and keeps the best.
void TryEntry(const PatientField& field, const PlanSettings& settings, const BodyFrame* frame,
              const Vector3d& entry, Candidate& best) {
  const Vector3d normal = SkinNormal(field, entry);
  const Eigen::Isometry3d tangent = math::PoseFromAxes(entry, normal, Vector3d::UnitZ());
  for (int side = 0; side < 4; ++side) {
    const double turn = 90.0 * side * math::kRadPerDegree;
    const Vector3d heading = tangent.linear() * Vector3d(std::cos(turn), std::sin(turn), 0.0);
    // The same for all paths of a side, and expensive: found when the first of them needs it.
    std::optional<std::optional<double>> uneven;
    for (const double tilt_deg : {20.0, 30.0, 40.0}) {
      const double tilt = tilt_deg * math::kRadPerDegree;
      const Vector3d direction = std::sin(tilt) * heading - std::cos(tilt) * normal;
      for (double length = settings.min_length_mm; length <= settings.max_length_mm;
           length += 10.0) {
        const InsertionPlan plan =
            CompletePlan(entry, normal, entry + length * direction, Vector3d::Zero());
        const double cost =
            TissueCost(field, plan, settings, frame) + 0.2 * std::abs(tilt_deg - 30.0);
        if (cost >= best.cost || !PathIsFree(field, entry, plan.target_ct_mm, settings)) continue;
        if (!uneven) uneven = ProbeUnevennessMm(field, plan);
        if (!*uneven || cost + 1.5 * **uneven >= best.cost) continue;
        const double seen_cost = cost + 1.5 * **uneven + ImageCost(ViewOf(field, plan));
        if (seen_cost < best.cost) best = {seen_cost, plan};
      }
    }
  }
}

/// The best of the paths from all around the body; `best` without a plan if there is none. Returns
/// how many points of the skin were tried.
int SearchAround(const PatientField& field, const PlanSettings& settings, const BodyFrame* frame,
                 Candidate& best, const RunContext& context) {
  const Box box = field.body_ct_mm();
  const Vector3d middle = box.center();
  const double reach = 0.5 * box.diagonal().norm() + 1.0;
  constexpr int kHeights = 9, kAzimuths = 24;
  int entries = 0;
  for (int height = 0; height < kHeights; ++height) {
    context.Checkpoint("path", static_cast<double>(height) / kHeights);
    const double z = box.min().z() + box.sizes().z() * (0.2 + 0.6 * height / (kHeights - 1));
    for (int azimuth = 0; azimuth < kAzimuths; ++azimuth) {
      const double angle = 2.0 * std::numbers::pi * azimuth / kAzimuths;
      const Vector3d out(std::sin(angle), -std::cos(angle), 0.0);
      const Vector3d outside = Vector3d(middle.x(), middle.y(), z) + reach * out;
      const auto entry = SkinAlong(field, outside, out, reach);
      if (!entry || !CanEnterAt(field, *entry)) continue;
      TryEntry(field, settings, frame, *entry, best);
      ++entries;
    }
  }
  return entries;
}

}  // namespace

bool CanEnterAt(const PatientField& field, const Vector3d& p) {
  const Box box = field.bounds_ct_mm();
  return !field.IsCut(p) && ((p - box.min()).array() > kBorderMm).all() &&
         ((box.max() - p).array() > kBorderMm).all();
}

InsertionPlan CompletePlan(const Vector3d& entry, const Vector3d& normal, const Vector3d& target,
                           const Vector3d& axis) {
  InsertionPlan plan;
  plan.entry_ct_mm = entry;
  plan.target_ct_mm = target;
  plan.direction = (target - entry).normalized();
  Vector3d along = axis.norm() > 0.0 ? axis : Vector3d(plan.direction + normal);
  // An axis along the needle spans no plane: then the head's direction does, or any.
  for (const Vector3d& other : {Vector3d(Vector3d::UnitZ()), normal.unitOrthogonal().eval()}) {
    if (plan.direction.cross(along).norm() > 0.05) break;
    along = other;
  }
  const Vector3d lateral = along.cross(plan.direction).normalized();
  plan.skin_normal = (normal - normal.dot(lateral) * lateral).normalized();
  plan.heading = plan.skin_normal.cross(-lateral).normalized();
  if (plan.heading.dot(along) < 0.0) plan.heading = -plan.heading;
  return plan;
}

void FindBone(const PatientField& field, const PlanSettings& settings, InsertionPlan& plan) {
  for (const Vector3d& axis : {plan.lateral(), plan.heading}) {
    for (int degrees = 2; degrees <= 30; ++degrees) {
      for (const double side : {1.0, -1.0}) {
        const double angle = side * degrees * math::kRadPerDegree;
        const auto depth = SquareBoneDepth(field, plan, axis, angle, settings);
        if (!depth) continue;
        plan.bone_angle_rad = angle;
        plan.bone_axis = axis;
        plan.bone_depth_mm = *depth;
        return;
      }
    }
  }
}

std::optional<double> ProbeUnevennessMm(const PatientField& field, const InsertionPlan& plan) {
  double worst = 0.0;
  for (const double ahead : {kProbeAheadMm - 20.0, kProbeAheadMm, kProbeAheadMm + 20.0}) {
    const Vector3d start = plan.entry_ct_mm + ahead * plan.heading;
    const auto skin = SkinAlong(field, start, plan.skin_normal, 25.0);
    if (!skin || !field.bounds_ct_mm().contains(*skin) || field.IsCut(*skin)) return std::nullopt;
    worst = std::max(worst, std::abs((*skin - start).dot(plan.skin_normal)));
  }
  for (const double across : {-kProbeAcrossMm, kProbeAcrossMm}) {
    const Vector3d start =
        plan.entry_ct_mm + kProbeAheadMm * plan.heading + across * plan.lateral();
    const auto skin = SkinAlong(field, start, plan.skin_normal, 50.0);
    if (!skin || field.IsCut(*skin)) return std::nullopt;
  }
  return worst;
}

bool PathIsFree(const PatientField& field, const Vector3d& entry, const Vector3d& target,
                const PlanSettings& settings) {
  const Eigen::Isometry3d path = math::PoseFromAxes(entry, target - entry, Vector3d::UnitX());
  const double length = (target - entry).norm();
  const double skin_mm = 3.0;  // At the skin itself, points around the path are in air.
  for (double depth = 0.0; depth <= length; depth += 0.5) {
    const Vector3d at = path * Vector3d(0, 0, depth);
    const volume::Label label = field.LabelAt(at);
    if (Avoided(settings, label) || (label == 0 && depth > skin_mm)) return false;
    if (depth < settings.clearance_mm) continue;
    for (int side = 0; side < 8; ++side) {
      const double angle = side * 45.0 * math::kRadPerDegree;
      const Vector3d around(settings.clearance_mm * std::cos(angle),
                            settings.clearance_mm * std::sin(angle), depth);
      if (Avoided(settings, field.LabelAt(path * around))) return false;
    }
  }
  return true;
}

InsertionPlan PlanToTarget(const PatientField& field, const Vector3d& target,
                           const PlanSettings& settings, const RunContext& context) {
  ACUS_REQUIRE(field.bounds_ct_mm().contains(target), "the target (", target.transpose(),
               ") mm lies outside the volume; move the target or enlarge the grid");
  ACUS_REQUIRE(field.SkinDistanceMm(target) < 0.0, "the target (", target.transpose(),
               ") mm lies outside the body");
  const Eigen::Isometry3d cone = math::PoseFromAxes(target, settings.approach, Vector3d::UnitX());
  constexpr double kStepRad = 2.0 * math::kRadPerDegree;
  const int rings = static_cast<int>(std::floor(settings.cone_rad / kStepRad));
  for (int ring = 0; ring <= rings; ++ring) {
    context.Checkpoint("path", static_cast<double>(ring) / (rings + 1));
    const double polar = ring * kStepRad;
    const int around =
        ring == 0
            ? 1
            : static_cast<int>(std::ceil(2.0 * std::numbers::pi * std::sin(polar) / kStepRad));
    for (int n = 0; n < around; ++n) {
      const double azimuth = 2.0 * std::numbers::pi * n / around;
      const Vector3d out =
          cone.linear() * Vector3d(std::sin(polar) * std::cos(azimuth),
                                   std::sin(polar) * std::sin(azimuth), std::cos(polar));
      const auto entry =
          SkinAlong(field, target + settings.max_length_mm * out, out, settings.max_length_mm);
      if (!entry || !CanEnterAt(field, *entry)) continue;
      const double length = (*entry - target).norm();
      if (length < settings.min_length_mm || length > settings.max_length_mm) continue;
      if (!PathIsFree(field, *entry, target, settings)) continue;
      InsertionPlan plan =
          CompletePlan(*entry, SkinNormal(field, *entry), target, settings.image_axis);
      if (!ProbeUnevennessMm(field, plan)) continue;
      FindBone(field, settings, plan);
      return plan;
    }
  }
  throw NoAnswerError(Message("no free straight path of ", settings.min_length_mm, " to ",
                              settings.max_length_mm, " mm leads from the skin to (",
                              target.transpose(),
                              ") mm; widen `cone_deg`, turn `approach` or lower `clearance_mm`"));
}

InsertionPlan PlanAnywhere(const PatientField& field, const PlanSettings& settings,
                           const RunContext& context, const BodyFrame* frame) {
  Candidate best;
  const int entries = SearchAround(field, settings, frame, best, context);
  if (entries == 0) {
    throw NoAnswerError(Message("no skin lies more than ", kBorderMm,
                                " mm inside the volume: the body fills it or is too small"));
  }
  const double shortest_mm = std::min(settings.min_length_mm, kShortestMm);
  if (!best.plan && shortest_mm < settings.min_length_mm) {
    PlanSettings shorter = settings;
    shorter.min_length_mm = shortest_mm;
    shorter.max_length_mm = settings.min_length_mm;
    SearchAround(field, shorter, frame, best, context);
    if (best.plan) {
      context.Warn(Message("no free path of ", settings.min_length_mm, " mm or more leads into ",
                           "this body; one of ", best.plan->length_mm(), " mm is taken"));
    }
  }
  if (!best.plan) {
    throw NoAnswerError(
        Message("no straight path of ", shortest_mm, " to ", settings.max_length_mm,
                " mm from the skin is free of bone, lung and gas in this label map, with room for "
                "the probe beside it; a volume that shows more of the skin may have one"));
  }
  FindBone(field, settings, *best.plan);
  return *best.plan;
}

}  // namespace acus::phantom
