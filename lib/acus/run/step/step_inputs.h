// What a step reads of a session: decided here for replays, live sessions, the images that follow
// them, sweeps and simulated trials, so that all step on the same samples.
#pragma once

#include <cstdint>
#include <vector>

#include "acus/data/session/session.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/step_state.h"

namespace acus::step {

/// Breath as a sample of a session gives it.
breathing::Breath BreathOf(const session::BreathSample& sample) noexcept;

/// Which tools there are.
struct Tools {
  bool needle = false;
  bool probe = false;
};

/// The force of the thumb on the plunger, by the orders of a session: that of the last one.
class PlungerForce {
 public:
  /// @param commands  In order of time; must outlive this.
  explicit PlungerForce(const std::vector<session::Command>& commands) : commands_(commands) {}

  /// N; an order acts on the step of its time. @param time_ns  Never goes back.
  double At(std::int64_t time_ns) noexcept;

 private:
  const std::vector<session::Command>& commands_;
  std::size_t next_ = 0;
  double force_n_ = 0.0;
};

/// Const after construction; SampleAt is real time.
class StepInputs {
 public:
  /// @param there  Tools of the session.
  StepInputs(const simulation::Scene& scene, const Tools& there);

  /// True if there is anything to step: a stage at every sample that reads a tool, or one of the
  /// list of effects. Breath alone needs no steps: images compute it for their moment.
  bool steps() const noexcept { return steps_; }
  bool reads_needle() const noexcept { return reads_.needle; }
  bool reads_probe() const noexcept { return reads_.probe; }

  /// The sample of a step, reference frame. Tools that no stage of a step reads are not seen, so
  /// that their jitter cannot change a result.
  simulation::Sample SampleAt(std::int64_t time_ns, const session::PoseSample& needle,
                              const session::PoseSample& probe, const breathing::Breath& breath,
                              double plunger_n) const noexcept;

 private:
  Tools reads_;
  bool steps_ = false;
};

}  // namespace acus::step
