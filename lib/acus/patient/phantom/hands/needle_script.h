// The needle's part of a script: where the tip is meant to be at any time.
#pragma once

#include <vector>

#include "acus/patient/phantom/hands/session_script.h"

namespace acus::phantom {

/// Depth of the tip behind the entry point (negative outside) and angle of the needle about the
/// plan's bone axis, relative to the direction of the target.
struct NeedleState {
  double depth_mm;
  double angle_rad;
};

class NeedleScript {
 public:
  NeedleScript(const InsertionPlan& plan, const SessionSettings& settings);

  double duration_s() const { return duration_s_; }
  NeedleState At(double time_s) const;

  /// Times at which a redirection begins and ends, and those at which the target is reached.
  const std::vector<double>& redirect_times_s() const { return redirect_times_s_; }
  const std::vector<double>& redirected_times_s() const { return redirected_times_s_; }
  const std::vector<double>& target_times_s() const { return target_times_s_; }
  /// In order of time.
  const std::vector<session::Command>& commands() const { return commands_; }

 private:
  struct Stroke {
    double start_s, end_s;
    NeedleState from, to;
  };
  void Go(const NeedleState& to, double duration_s);
  void Command(const NeedleMove& move);

  std::vector<Stroke> strokes_;
  NeedleState now_{};
  double duration_s_ = 0.0;
  std::vector<double> redirect_times_s_, redirected_times_s_, target_times_s_;
  std::vector<session::Command> commands_;
};

}  // namespace acus::phantom
