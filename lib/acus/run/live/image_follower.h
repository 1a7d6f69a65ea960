// Repeats the steps of a live session, with snapshots for images between them.
#pragma once

#include <cstdint>
#include <optional>

#include "acus/run/live/live_snapshot.h"
#include "acus/run/live/step_feed.h"
#include "acus/run/step/step_inputs.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::live {

/// Snapshots lie on the time grid of acus-replay, or on an integer refinement of it: from the first
/// step on, at the scene's image rate. Their images have the same bits as those of a replay of the
/// recording at the same time.
class ImageFollower {
 public:
  /// @param scene  Must outlive this. @param has_needle, has_probe  Tools of the session.
  /// @param least_rate_hz  Lower bound of the rate of snapshots.
  ImageFollower(const simulation::Scene& scene, bool has_needle, bool has_probe,
                double least_rate_hz);

  /// @pre later than the step before.
  void Step(const StepInput& input);
  /// The newest snapshot that the steps have passed; nothing if it was taken. A snapshot that is
  /// replaced before it is taken is counted, see passed_over().
  const LiveSnapshot* TakeMoment();

  double rate_hz() const { return rate_hz_; }
  std::int64_t steps() const { return state_.steps; }
  std::int64_t passed_over() const { return passed_over_; }

 private:
  void ShowMoment(std::int64_t time_ns, const StepInput& next);
  std::int64_t MomentNs(std::int64_t number) const;

  const simulation::Scene& scene_;
  simulation::Simulation simulation_;
  simulation::State state_;
  simulation::StepOutput output_;
  step::StepInputs inputs_;
  bool has_probe_;
  double rate_hz_;
  std::optional<StepInput> last_;
  std::int64_t first_ns_ = 0;
  std::int64_t next_moment_ = 0;
  LiveSnapshot moment_;
  bool is_waiting_ = false;  ///< moment_ has not been taken.
  std::int64_t passed_over_ = 0;
};

}  // namespace acus::live
