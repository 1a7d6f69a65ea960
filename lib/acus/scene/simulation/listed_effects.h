// The effects of the list that a scene calls for, as steps and images run them.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/scene/effects/effect_list.h"
#include "acus/scene/simulation/effect_plan.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::simulation {

/// Numbers that effects write down in a step, those of all effects one after the other.
using EffectColumns = std::array<double, effects::kMaxColumns>;

/// One of them.
struct ListedEffect {
  std::string_view key;
  std::string_view title;
  std::size_t step_stage = 0;  ///< Number in the plan, if it has the stage; as the next.
  std::size_t image_stage = 0;
  std::shared_ptr<const effects::LoadedEffect> loaded;
  const effects::StepStage* step = nullptr;  ///< Null: not in the plan.
  bool has_image = false;                    ///< The plan has its stage at every image.
  effects::ImageTiming timing;
  bool moves_tissue = false;
  bool shows_motion = false;  ///< Images show a motion of tissue by it; tools may not feel it.
  bool adds_force = false;
  bool changes_echo = false;
  std::size_t state_at = 0;  ///< Bytes into the memory.
  std::vector<effects::Column> columns;
  std::size_t first_column = 0;

  const std::byte* StateIn(const effects::Memory& memory) const {
    return memory.bytes.data() + state_at;
  }
};

/// Those of a plan, in the order of the list. Const after loading; copies share what is loaded.
class ListedEffects {
 public:
  ListedEffects() = default;

  /// @param data  What the plan has loaded of the patient.
  /// @param needle  Its preset, to load effects by; null if no stage reads it.
  /// @throws InputError if an effect cannot be loaded, reads a port that is not given to its stage,
  ///     or the states or columns of all of them together are too many.
  ListedEffects(const scenario::Scenario& scenario, const EffectPlan& plan,
                const effects::PortValues& data, const forces::NeedleProperties* needle,
                RunContext& context);

  const std::vector<ListedEffect>& all() const { return all_; }
  bool has_steps() const { return has_steps_; }
  /// True if there are images at the moments of the scene's images.
  bool has_images() const;
  /// True if tools feel a motion of tissue; images show it as well.
  bool moves_tissue() const { return moves_tissue_; }
  /// True if images show a motion of tissue.
  bool shows_motion() const { return shows_motion_; }
  const effects::PortValues& data() const { return data_; }

  void Begin(effects::Memory& memory) const;

  /// Runs those steps that come before, or after, the stages of the tools. Real time.
  void Step(bool after_tools, effects::Memory& memory, const effects::StepTime& time,
            effects::PortValues& ports, EffectColumns& columns, Stopwatch& watch) const noexcept;

  /// Where tissue that is now at a place was without these effects: as tools feel it, and as images
  /// show it.
  Eigen::Vector3d RestInCtMm(const effects::Memory& memory,
                             const Eigen::Vector3d& place_in_ct_mm) const noexcept;
  Eigen::Vector3d SeenRestInCtMm(const effects::Memory& memory,
                                 const Eigen::Vector3d& place_in_ct_mm) const noexcept;
  /// True if images show tissue at the same place at both moments. Null: not moved.
  bool IsSameMotion(const effects::Memory* a, const effects::Memory* b) const noexcept;
  double MotionSpacingMm() const noexcept;

  bool adds_force() const { return adds_force_; }
  /// What these effects add to the force on the needle, N, CT space: in the order of the plan, each
  /// no larger than kLargestAddedN; what is not finite counts as zero.
  Eigen::Vector3d AddedForceInCtN(const effects::Memory& memory) const noexcept;

  bool changes_echo() const { return changes_echo_; }
  /// True if an effect changes the echo of any place at this moment.
  bool ChangesEchoNow(const effects::Memory& memory) const noexcept;
  /// Sum over these effects.
  double EchoChangeDb(const effects::Memory& memory,
                      const effects::EchoPlace& place) const noexcept;
  /// True if echoes are the same at both moments. Null: not changed.
  bool IsSameEcho(const effects::Memory* a, const effects::Memory* b) const noexcept;

  static constexpr double kLargestAddedN = 40.0;

 private:
  std::vector<ListedEffect> all_;
  /// Places in all_ of those with a step, as the plan runs them: before and after the tools.
  std::array<std::vector<std::size_t>, 2> steps_;
  effects::PortValues data_;
  bool has_steps_ = false;
  bool moves_tissue_ = false;
  bool shows_motion_ = false;
  bool adds_force_ = false;
  bool changes_echo_ = false;
};

}  // namespace acus::simulation
