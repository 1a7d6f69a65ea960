#include "acus/patient/phantom/planning/window_plan.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "acus/base/math/angles.h"
#include "acus/base/math/rigid.h"
#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr double kRayStepMm = 1.0;
constexpr double kRingStepRad = 2.5 * math::kRadPerDegree;
constexpr double kMaxUnevenMm = 16.0;   ///< A probe rests on skin that is no more uneven.
constexpr double kMinLean = 0.1;        ///< Of the needle towards the probe: sine of the angle.
constexpr int kMostTried = 12;          ///< Paths to a point after the first free one.
constexpr std::size_t kMostPoints = 8;  ///< Of the target, after the first that can be reached.
constexpr double kLeastGain = 0.1;      ///< Of the image's score over a path that comes first.

/// Unit directions around an axis, in rings from it outwards.
std::vector<Vector3d> Directions(const Approach& approach) {
  const Eigen::Isometry3d cone =
      math::PoseFromAxes(Vector3d::Zero(), approach.direction, Vector3d::UnitX());
  const int rings = static_cast<int>(std::floor(approach.cone_rad / kRingStepRad));
  std::vector<Vector3d> out;
  for (int ring = 0; ring <= rings; ++ring) {
    const double polar = ring * kRingStepRad;
    const int around = std::max(
        1, static_cast<int>(std::ceil(2.0 * std::numbers::pi * std::sin(polar) / kRingStepRad)));
    for (int n = 0; n < around; ++n) {
      const double azimuth = 2.0 * std::numbers::pi * n / around;
      out.push_back(cone.linear() * Vector3d(std::sin(polar) * std::cos(azimuth),
                                             std::sin(polar) * std::sin(azimuth), std::cos(polar)));
    }
  }
  return out;
}

/// What a ray from the target outwards meets first: air, at `reach_mm`, or a reason against it.
struct OutwardRay {
  Vector3d out;
  Vector3d image_axis;
  double reach_mm = 0.0;
};

bool IsAvoided(const PlanSettings& settings, volume::Label label) {
  return std::ranges::find(settings.avoid, label) != settings.avoid.end();
}

std::string TissueName(volume::Label label) {
  const auto standard = volume::StandardLabels();
  return label < standard.size() ? std::string(standard[label].name) : "another tissue";
}

/// The reason against a ray, or nothing; then reach_mm is where it leaves the body.
std::string Walk(const PatientField& field, const Vector3d& from, const PlanSettings& settings,
                 OutwardRay& ray) {
  const Box bounds = field.bounds_ct_mm();
  for (double s = 0.0; s <= settings.max_length_mm + kRayStepMm; s += kRayStepMm) {
    const Vector3d at = from + s * ray.out;
    if (!bounds.contains(at)) return "border";
    const volume::Label label = field.LabelAt(at);
    if (IsAvoided(settings, label)) return TissueName(label);
    if (label != 0) continue;
    ray.reach_mm = s;
    if (s < settings.min_length_mm) return "length";
    return field.IsCut(at) ? "border" : "";
  }
  return "length";
}

class Search {
 public:
  Search(const PatientField& field, const BodyFrame& frame, const ApproachWindow& window,
         const PlanSettings& settings, Refusals& refusals)
      : field_(field), frame_(frame), window_(window), settings_(settings), refusals_(refusals) {}

  struct Seen {
    InsertionPlan plan;
    ImageView view;
  };

  std::optional<Seen> To(const Vector3d& target) const {
    std::vector<OutwardRay> free;
    for (const Approach& approach : window_.approaches(frame_.Side(target))) {
      for (const Vector3d& out : Directions(approach)) {
        OutwardRay ray{.out = out, .image_axis = approach.image_axis};
        const std::string reason = Walk(field_, target, settings_, ray);
        if (reason.empty()) {
          free.push_back(ray);
        } else {
          ++refusals_[reason];
        }
      }
    }
    const bool is_shortest = window_.name == "shortest";
    if (is_shortest) std::ranges::stable_sort(free, {}, &OutwardRay::reach_mm);
    std::optional<Seen> best;
    int tried = 0;
    for (const OutwardRay& ray : free) {
      if (best && ++tried > kMostTried) break;
      InsertionPlan plan;
      const std::string reason = Complete(target, ray, plan);
      if (!reason.empty()) {
        ++refusals_[reason];
        continue;
      }
      const ImageView view = ViewOf(field_, plan);
      if (!best || view.Score() > best->view.Score() + kLeastGain) best = Seen{plan, view};
      if (is_shortest || best->view.IsGood()) break;
    }
    return best;
  }

 private:
  /// The reason against a path that is free of what the settings avoid, or nothing and the plan.
  std::string Complete(const Vector3d& target, const OutwardRay& ray, InsertionPlan& plan) const {
    const auto entry = SkinAlong(field_, target + ray.reach_mm * ray.out, ray.out, 12.0);
    if (!entry) return "length";
    if (!CanEnterAt(field_, *entry)) return "border";
    const double length_mm = (*entry - target).norm();
    if (length_mm < settings_.min_length_mm || length_mm > settings_.max_length_mm) return "length";
    const WindowPlace place{*entry, SkinNormal(field_, *entry), -ray.out};
    Vector3d axis = ray.image_axis;
    if (!window_.accepts(field_, frame_, place, axis)) return "window";
    if (!PathIsFree(field_, *entry, target, settings_)) return "clearance";
    // The needle leans towards the probe.
    if (axis.dot(place.direction) < 0.0) axis = -axis;
    plan = CompletePlan(*entry, place.skin_normal, target, axis);
    if (plan.heading.dot(plan.direction) < kMinLean) return "probe";
    const auto uneven_mm = ProbeUnevennessMm(field_, plan);
    return uneven_mm && *uneven_mm <= kMaxUnevenMm ? "" : "probe";
  }

  const PatientField& field_;
  const BodyFrame& frame_;
  const ApproachWindow& window_;
  const PlanSettings& settings_;
  Refusals& refusals_;
};

/// The settings with the target's own tissues taken from those to be avoided.
PlanSettings Permitting(PlanSettings settings, const SceneTarget& target) {
  std::erase_if(settings.avoid, [&](volume::Label label) {
    return std::ranges::find(target.passable, label) != target.passable.end();
  });
  return settings;
}

/// Heights without lung come first: a lumbar puncture is below the lungs.
std::vector<TargetPoint> InOrder(const SceneTarget& target, const BodyFrame& frame,
                                 const ApproachWindow& window) {
  std::vector<TargetPoint> points = target.points;
  if (window.is_spinal) {
    std::ranges::stable_partition(
        points, [&](const TargetPoint& point) { return !frame.HasLungAt(point.point_ct_mm.z()); });
  }
  return points;
}

std::string ReasonText(const std::string& reason, const PlanSettings& settings) {
  if (reason == "length") {
    return Message("are not ", settings.min_length_mm, " to ", settings.max_length_mm, " mm long");
  }
  if (reason == "border") return "leave the body where the volume's border cuts it";
  if (reason == "probe") return "have no even skin for the probe";
  if (reason == "window") return "enter beside the window";
  if (reason == "clearance") {
    return Message("pass within ", settings.clearance_mm, " mm of what they avoid");
  }
  return "meet " + reason;
}

}  // namespace

std::string RefusalText(const Refusals& refusals, const PlanSettings& settings) {
  std::vector<std::pair<int, std::string>> order;
  int all = 0;
  for (const auto& [reason, count] : refusals) {
    order.emplace_back(count, reason);
    all += count;
  }
  std::ranges::stable_sort(order, std::greater{}, &std::pair<int, std::string>::first);
  std::string text = Message("of ", all, " directions ");
  for (std::size_t n = 0; n < order.size() && n < 4; ++n) {
    const auto percent = std::lround(100.0 * order[n].first / std::max(all, 1));
    if (percent == 0) break;
    text += Message(n == 0 ? "" : ", ", percent, " % ", ReasonText(order[n].second, settings));
  }
  return text;
}

namespace {

std::string OtherWindows(const PatientField& field, const BodyFrame& frame,
                         const SceneTarget& target, const std::vector<const ApproachWindow*>& tried,
                         const PlanSettings& settings, const RunContext& context) {
  std::string free;
  for (const ApproachWindow& window : ApproachWindows()) {
    if (std::ranges::find(tried, &window) != tried.end()) continue;
    if (!PlanThroughWindows(field, frame, target, {&window}, settings, context, nullptr)) continue;
    free += (free.empty() ? "" : ", ") + std::string(window.name);
  }
  return free;
}

std::string RequestedStructure(const SceneRequest& request, const volume::LabelMap& labels) {
  if (!request.target.empty()) return request.target;
  const std::string structure(WindowNamed(request.window).structure);
  ACUS_REQUIRE(!structure.empty(), "--window ", request.window,
               " needs --target: a point x,y,z in mm, or one of ", TargetList(labels));
  const std::vector<std::string> names = TargetNames(labels);
  ACUS_REQUIRE(std::ranges::find(names, structure) != names.end(), "--window ", request.window,
               " leads to ", structure, ", which the label map lacks; give --target: a point ",
               "x,y,z in mm, or one of ", TargetList(labels));
  return structure;
}

SceneTarget RequestedTarget(const volume::LabelMap& labels, const PatientField& field,
                            const BodyFrame& frame, const SceneRequest& request,
                            const std::string& structure, const RunContext& context) {
  if (NamesSpinalLevel(structure)) {
    return FindLevelTarget(labels, frame, structure, ReadSpinalLevel(structure, request.vertebrae),
                           context.num_threads);
  }
  SceneTarget target = FindSceneTarget(labels, field, frame, structure, context.num_threads);
  if (structure == "spinal_canal") {
    PutLumbarFirst(labels, frame, request.Levels(), context.num_threads, target);
  }
  return target;
}

std::string OrganOf(const SceneTarget& target) {
  return target.passable.size() > 1 ? TissueName(target.passable.back()) : std::string();
}

}  // namespace

std::optional<WindowPlan> PlanThroughWindows(const PatientField& field, const BodyFrame& frame,
                                             const SceneTarget& target,
                                             const std::vector<const ApproachWindow*>& windows,
                                             const PlanSettings& settings,
                                             const RunContext& context, Refusals* refusals) {
  const PlanSettings permitting = Permitting(settings, target);
  Refusals unused;
  std::optional<WindowPlan> best;
  for (const ApproachWindow* window : windows) {
    if (best && (best->view.IsGood() || window->name == "shortest")) break;
    const Search search(field, frame, *window, permitting, refusals ? *refusals : unused);
    const std::vector<TargetPoint> points = InOrder(target, frame, *window);
    std::size_t later = 0;
    for (std::size_t n = 0; n < points.size() && !(best && best->view.IsGood()); ++n) {
      if (best && ++later > kMostPoints) break;
      context.Checkpoint("path", static_cast<double>(n) / static_cast<double>(points.size()));
      const auto found = search.To(points[n].point_ct_mm);
      if (!found || (best && found->view.Score() <= best->view.Score() + kLeastGain)) continue;
      best = WindowPlan{found->plan, window, points[n], found->view};
      if (window->name == "shortest") break;
    }
  }
  if (best && best->window->is_spinal) FindBone(field, permitting, best->insertion);
  return best;
}

WindowPlan PlanAsRequested(const volume::LabelMap& labels, const PatientField& field,
                           const BodyFrame& frame, const SceneRequest& request,
                           const PlanSettings& settings, const RunContext& context) {
  const std::string structure = RequestedStructure(request, labels);
  const SceneTarget target = RequestedTarget(labels, field, frame, request, structure, context);
  const auto windows = request.window.empty() ? UsualWindows(target.structure, OrganOf(target))
                                              : std::vector{&WindowNamed(request.window)};
  Refusals refusals;
  auto plan = PlanThroughWindows(field, frame, target, windows, settings, context, &refusals);
  if (plan) return *plan;
  std::string tried;
  for (const ApproachWindow* window : windows)
    tried += (tried.empty() ? "" : ", ") + std::string(window->name);
  const std::string free = OtherWindows(field, frame, target, windows, settings, context);
  throw NoAnswerError(Message(
      "no free path leads to ", target.name, " through the window ", tried, ": ",
      RefusalText(refusals, Permitting(settings, target)),
      free.empty() ? "; no other window is free either: give another --target, or a --config with "
                     "another `max_length_mm`, `clearance_mm` or `avoid`"
                   : "; free: --window " + free));
}

}  // namespace acus::phantom
