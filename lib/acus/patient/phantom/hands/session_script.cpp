#include "acus/patient/phantom/hands/session_script.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/math/rigid.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/hands/hand_motion.h"
#include "acus/patient/phantom/hands/needle_script.h"
#include "acus/patient/phantom/hands/probe_script.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kPeriodNs = 1'000'000;  ///< 1 kHz.

/// Six independent noises: three shifts and three turns.
class Tremor {
 public:
  Tremor(std::uint64_t seed, const std::string& tool, const TremorSettings& s, double shift_mm,
         double turn_rad)
      : shift_{Noise(seed, tool + " x", s, shift_mm), Noise(seed, tool + " y", s, shift_mm),
               Noise(seed, tool + " z", s, shift_mm)},
        turn_{Noise(seed, tool + " about x", s, turn_rad),
              Noise(seed, tool + " about y", s, turn_rad),
              Noise(seed, tool + " about z", s, turn_rad)} {}

  Vector3d Shift(double t) const { return {shift_[0].At(t), shift_[1].At(t), shift_[2].At(t)}; }
  Eigen::Quaterniond Turn(double t, double factor) const {
    // Small angles: the turn's vector is half the quaternion's.
    const Vector3d half = 0.5 * factor * Vector3d(turn_[0].At(t), turn_[1].At(t), turn_[2].At(t));
    return Eigen::Quaterniond(1.0, half.x(), half.y(), half.z()).normalized();
  }

 private:
  static BandNoise Noise(std::uint64_t seed, const std::string& name, const TremorSettings& s,
                         double rms) {
    return BandNoise(seed, "tremor of " + name, s.low_hz, s.high_hz, rms);
  }
  BandNoise shift_[3];
  BandNoise turn_[3];
};

/// The needle as scripted, with tremor; the tissue holds the tip still when it is deep.
class NeedleHand {
 public:
  NeedleHand(const InsertionPlan& plan, const SessionSettings& settings, std::uint64_t seed)
      : plan_(plan),
        script_(plan, settings),
        tremor_(seed, "needle", settings.tremor, settings.tremor.needle_mm,
                settings.tremor.needle_rad),
        tissue_damping_(settings.tremor.tissue_damping),
        base_(math::PoseFromAxes(plan.entry_ct_mm, plan.direction, plan.heading)) {}

  const NeedleScript& script() const { return script_; }

  Eigen::Isometry3d CtFromNeedle(double t) const {
    constexpr double kAxialShare = 0.3;  // A hand trembles less along the needle than across it.
    constexpr double kDampedDepthMm = 10.0;
    const NeedleState state = script_.At(t);
    const double damping =
        1.0 - (1.0 - tissue_damping_) * MinimumJerk(state.depth_mm / kDampedDepthMm);
    Eigen::Isometry3d pose = base_;
    pose.linear() = Eigen::AngleAxisd(state.angle_rad, plan_.bone_axis) * base_.linear();
    Vector3d shift = damping * tremor_.Shift(t);
    shift.z() = kAxialShare * shift.z() + state.depth_mm;
    pose.translate(shift);
    pose.rotate(tremor_.Turn(t, damping));
    return pose;
  }

 private:
  const InsertionPlan& plan_;
  NeedleScript script_;
  Tremor tremor_;
  double tissue_damping_;
  Eigen::Isometry3d base_;
};

class ProbeHand {
 public:
  ProbeHand(const PatientField& field, const InsertionPlan& plan, const SessionSettings& settings,
            std::uint64_t seed)
      : path_(field, plan, settings.probe),
        tremor_(seed, "probe", settings.tremor, settings.tremor.probe_mm,
                settings.tremor.probe_rad),
        along_(seed, "wander along", 0.1, 0.5, settings.tremor.wander_mm),
        across_(seed, "wander across", 0.1, 0.5, 0.5 * settings.tremor.wander_mm) {}

  Eigen::Isometry3d CtFromProbe(double t) const {
    // The face stays on the skin: tremor and wander move it along the skin only.
    const Vector3d shift = tremor_.Shift(t);
    Eigen::Isometry3d pose =
        path_.CtFromProbe(t, shift.x() + along_.At(t), shift.z() + across_.At(t));
    pose.rotate(tremor_.Turn(t, 1.0));
    return pose;
  }

 private:
  ProbePath path_;
  Tremor tremor_;
  BandNoise along_, across_;
};

/// Follows the tip and notes what it enters. A tissue counts when the tip goes deeper than it was
/// since the last redirection or withdrawal, and a return to the tissue just left only 1 mm deeper:
/// tremor at a border is one event.
class EventFinder {
 public:
  EventFinder(const PatientField& field, const Vector3d& entry) : field_(field), entry_(entry) {}

  void StartAttempt() { fresh_ = true; }

  void Follow(double time_s, const Eigen::Isometry3d& ct_from_needle) {
    const Vector3d tip = ct_from_needle.translation();
    const double depth = (tip - entry_).dot(ct_from_needle.linear().col(2));
    const volume::Label label = field_.LabelAt(tip);
    if (fresh_) {
      before_ = last_ = label;
      deepest_mm_ = depth;
      fresh_ = false;
    }
    if (inside_ && label == 0 && field_.SkinDistanceMm(tip) > kBorderMm) {
      inside_ = false;
      fresh_ = true;
      events.push_back({time_s, "withdrawn", "outside", depth});
      return;
    }
    if (depth <= deepest_mm_) return;
    deepest_mm_ = depth;
    const bool returns = label == before_ && depth < entered_at_mm_ + kBorderMm;
    if (label == 0 || label == last_ || last_ == kBone || returns) return;
    const char* kind = !inside_ ? "contact" : label == kBone ? "bone_touch" : "puncture";
    events.push_back({time_s, kind, std::string(volume::StandardLabels()[label].name), depth});
    before_ = last_;
    last_ = label;
    entered_at_mm_ = depth;
    inside_ = true;
  }

  std::vector<NeedleEvent> events;

 private:
  static constexpr double kBorderMm = 1.0;
  const volume::Label kBone = volume::LabelOf("bone");  // Where the needle ends.
  const PatientField& field_;
  Vector3d entry_;
  double deepest_mm_ = 0.0;
  double entered_at_mm_ = 0.0;
  volume::Label last_ = 0;    ///< Tissue that the tip is in.
  volume::Label before_ = 0;  ///< Tissue that it came from.
  bool inside_ = false;
  bool fresh_ = true;
};

void RequirePlayable(const InsertionPlan& plan, const SessionSettings& settings) {
  ACUS_REQUIRE(!settings.needle.empty(), "/session/needle: at least one move is needed");
  ACUS_REQUIRE(settings.tremor.low_hz < settings.tremor.high_hz,
               "/session/tremor: low_hz must be below high_hz, not ", settings.tremor.low_hz,
               " and ", settings.tremor.high_hz);
  for (const NeedleMove& move : settings.needle) {
    ACUS_REQUIRE(move.to != NeedleMove::To::kDepth || move.depth_mm <= plan.length_mm() + 30.0,
                 "/session/needle: depth_mm ", move.depth_mm,
                 " goes more than 30 mm past the target at ", plan.length_mm(), " mm");
  }
}

}  // namespace

ScriptedSession PlayScript(const PatientField& field, const InsertionPlan& plan,
                           const SessionSettings& settings,
                           const Eigen::Isometry3d& reference_from_ct, const RunContext& context) {
  RequirePlayable(plan, settings);
  const NeedleHand needle(plan, settings, context.seed);
  const ProbeHand probe(field, plan, settings, context.seed);
  ScriptedSession out;
  out.session.name = settings.name;
  out.session.commands = needle.script().commands();
  EventFinder finder(field, plan.entry_ct_mm);
  const auto& redirected = needle.script().redirected_times_s();
  std::size_t attempt = 0;
  const auto count =
      static_cast<std::int64_t>(std::ceil(needle.script().duration_s() * 1000.0)) + 1;
  ACUS_REQUIRE(count >= 2, "/session/needle: the moves take no time; give `hold_s` or a distance");
  for (std::int64_t i = 0; i < count; ++i) {
    if (i % 1000 == 0)
      context.Checkpoint("session", static_cast<double>(i) / static_cast<double>(count));
    const double t = 1e-3 * static_cast<double>(i);
    if (attempt < redirected.size() && redirected[attempt] <= t) {
      ++attempt;
      finder.StartAttempt();
    }
    const Eigen::Isometry3d ct_from_needle = needle.CtFromNeedle(t);
    finder.Follow(t, ct_from_needle);
    out.session.needle.push_back({i * kPeriodNs, reference_from_ct * ct_from_needle, true});
    out.session.probe.push_back({i * kPeriodNs, reference_from_ct * probe.CtFromProbe(t), true});
  }
  out.events = std::move(finder.events);
  for (const double t : needle.script().redirect_times_s())
    out.events.push_back({t, "redirect", "", needle.script().At(t).depth_mm});
  for (const double t : needle.script().target_times_s()) {
    out.events.push_back({t, "target_reached", "", needle.script().At(t).depth_mm});
  }
  std::ranges::stable_sort(out.events, {}, &NeedleEvent::time_s);
  return out;
}

}  // namespace acus::phantom
