// How a sample becomes steps of a model: the search behind ForceModel::StepAlong.
#pragma once

#include <algorithm>
#include <cmath>

#include "acus/physics/forces/path/needle_track.h"
#include "acus/physics/forces/path/swept_step.h"

namespace acus::forces {

/// The straight way of the tip from the last valid sample to this one, in the frame of the tissue
/// at rest: places, times and axes by share.
struct SweptWay {
  NeedleInput to;
  double from_s = 0.0;
  Eigen::Vector3d from_mm;
  Eigen::Vector3d from_axis;  ///< Unit length.
  double length_mm = 0.0;

  Eigen::Vector3d At(double share) const noexcept {
    return from_mm + share * (to.tip_in_ct_mm - from_mm);
  }
  /// @pre share < 1; the last sample of a way is `to` itself.
  NeedleInput Sample(double share, volume::Label label) const noexcept {
    NeedleInput input = to;
    input.time_s = from_s + share * (to.time_s - from_s);
    input.tip_in_ct_mm = At(share);
    const Eigen::Vector3d to_axis = to.axis_in_ct.normalized();
    const Eigen::Vector3d axis = from_axis + share * (to_axis - from_axis);
    // An axis that turns right round has no direction in between.
    input.axis_in_ct = axis.norm() > 0.1 ? axis : to_axis;
    input.tissue_at_tip = label;
    return input;
  }
};

/// The steps of one sample. `Place` is what a model distinguishes along the path: its At(mm,
/// before) gives an integer that changes where there is something to meet (`before`: at the place
/// before), its LabelAt(mm) the label of a sample there. Allocates nothing.
template <class Model, class State, class Place>
class Sweep {
 public:
  /// @param step_mm  between looks at the tissue, > 0.
  Sweep(const Model& model, State& state, const Place& place, double step_mm,
        PassedEvents& events) noexcept
      : model_(model), state_(state), place_(place), step_mm_(step_mm), events_(events) {}

  NeedleForce Along(const SweptWay& way) noexcept {
    const double looks = std::ceil(way.length_mm / step_mm_);
    const int num =
        static_cast<int>(std::clamp(looks, 1.0, static_cast<double>(Place::kMostLooks)));
    double before = 0.0;
    int kind = place_.At(way.from_mm, 0);
    for (int i = 1; i <= num; ++i) {
      const double share = static_cast<double>(i) / num;
      const int here = place_.At(way.At(share), kind);
      if (here != kind && left_ > 0) Cross(way, kind, before, share);
      kind = here;
      before = share;
    }
    if (at_ > 0.0) StepThrough(way, 1.0);
    StepTo(way, 1.0);
    force_.event = event_;
    return force_;
  }

  /// One step, whatever it meets.
  NeedleForce Once(const NeedleInput& input) noexcept {
    force_ = state_.held;
    Accept(model_.Step(state_, input));
    return force_;
  }

 private:
  NeedleInput SampleAt(const SweptWay& way, double share) const noexcept {
    return share < 1.0 ? way.Sample(share, place_.LabelAt(way.At(share))) : way.to;
  }

  /// To both sides of the place between two looks where what was `kind` ends.
  void Cross(const SweptWay& way, int kind, double low, double high) noexcept {
    while ((high - low) * way.length_mm > 0.5 * SweepLimits::kResolvedMm) {
      const double middle = 0.5 * (low + high);
      if (!(middle > low && middle < high)) break;
      (place_.At(way.At(middle), kind) == kind ? low : high) = middle;
    }
    StepThrough(way, low);
    if (high < 1.0) StepTo(way, high);
  }

  /// Through one tissue. If it is cut already its inside decides, away from both of its ends.
  void StepThrough(const SweptWay& way, double share) noexcept {
    const double from = at_;
    const int parts = (share - from) * way.length_mm < SweepLimits::kThinMm ? 4 : 2;
    for (int part = 1; part < parts; ++part) StepTo(way, from + part * (share - from) / parts);
    StepTo(way, share);
  }

  /// Up to a share of the step, with a stop at each event.
  void StepTo(const SweptWay& way, double share) noexcept {
    if (share <= at_) return;
    if (at_ == 0.0) force_ = state_.held;
    while (at_ < share) {
      const NeedleInput input = SampleAt(way, share);
      const bool last = share >= 1.0;
      // Samples too close for the clock.
      if (!last && !(input.time_s > state_.time_s && input.time_s < way.to.time_s)) return;
      const bool resolved = (share - at_) * way.length_mm <= SweepLimits::kResolvedMm;
      if (resolved || left_ <= 0) {
        --left_;
        Accept(model_.Step(state_, input));
        at_ = share;
        return;
      }
      const State saved = state_;
      const NeedleForce force = model_.Step(state_, input);
      --left_;
      if (force.event == NeedleEvent::kNone) {
        Accept(force);
        at_ = share;
        return;
      }
      const double found = FirstEvent(way, saved, share);
      state_ = saved;
      Accept(model_.Step(state_, SampleAt(way, found)));
      at_ = found;
    }
  }

  /// The least share up to which one step from `saved` meets something; `high` does.
  double FirstEvent(const SweptWay& way, const State& saved, double high) noexcept {
    double low = at_;
    while ((high - low) * way.length_mm > SweepLimits::kResolvedMm && left_ > 0) {
      const double middle = 0.5 * (low + high);
      const NeedleInput input = SampleAt(way, middle);
      if (!(input.time_s > saved.time_s && input.time_s < way.to.time_s)) break;
      state_ = saved;
      --left_;
      (model_.Step(state_, input).event == NeedleEvent::kNone ? low : high) = middle;
    }
    return high;
  }

  void Accept(const NeedleForce& force) noexcept {
    if (force.event != NeedleEvent::kNone) {
      const bool leaves = force.event == NeedleEvent::kWithdrawal;
      events_.Add({.event = force.event,
                   .tissue = state_.tissue_at_tip,
                   .depth_mm = leaves ? state_.path.DepthMm(state_.tip_in_ct_mm) : force.depth_mm,
                   .force_axial_n = force.AxialN(),
                   .force_before_n = force_.AxialN()});
      event_ = FirstOf(event_, force.event);
    }
    force_ = force;
  }

  const Model& model_;
  State& state_;
  const Place& place_;
  double step_mm_;
  PassedEvents& events_;
  double at_ = 0.0;  ///< Share of the step that is done.
  int left_ = SweepLimits::kMostModelSteps;
  NeedleForce force_;
  NeedleEvent event_ = NeedleEvent::kNone;
};

/// True if the way from the last sample to `input` is known well enough to be searched: the force
/// of the last one is still held, and the tip has moved by more than nothing and less than a jump.
bool IsSwept(const NeedleTrack& track, const ForceSettings& settings, const NeedleInput& input,
             const Eigen::Vector3d& from_axis, SweptWay& out) noexcept;

}  // namespace acus::forces
