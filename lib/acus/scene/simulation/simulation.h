// The simulation core: replay and live sessions call the same Step.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/stage_timing.h"
#include "acus/scene/simulation/step_state.h"
#include "acus/scene/simulation/tools_at_rest.h"

namespace acus::simulation {

class CoupledStage;

/// The const model. Stages that are not in the scene's plan are not run.
class Simulation {
 public:
  /// @param scene  Must outlive the simulation.
  explicit Simulation(const Scene& scene);

  /// @param session_start_ns  Time of the first reading of any tool.
  State NewState(std::int64_t session_start_ns = 0) const;

  /// Advances to `sample.time_ns`; values that no stage in the plan reads may be missing from it.
  /// Allocates nothing, takes no lock, prints nothing. The force model handles a sample that is not
  /// valid, not finite or not later than the last one: the force stays finite and bounded.
  /// @param times  If given, the cost of each stage is added to it; the results stay the same.
  StepOutput Step(State& state, const Sample& sample, StageTimes* times = nullptr) const noexcept;

  /// The load with which images show the tissue as it is after a step. False, with `out` not
  /// written, if nothing deforms it.
  /// @pre the plan has a deformation stage.
  bool LoadOf(const State& state, const StepOutput& output, tissue::TissueLoad& out) const noexcept;

  /// The needle as the images show it after a step, from the tip to the hub, in CT space. False,
  /// with `out` not written, if it is straight in the hand.
  bool ShapeOf(const State& state, math::Polyline& out) const noexcept;

 private:
  struct Stage {
    std::size_t number = 0;  ///< Number in the plan.
    std::shared_ptr<const CoupledStage> work;
  };

  const Scene& scene_;
  ToolMotion tools_;
  std::vector<Stage> stages_;  ///< The plan's stages, in its order.
  bool runs_contact_ = false;
};

}  // namespace acus::simulation
