#include "acus/scene/simulation/listed_effects.h"

#include <algorithm>

#include "acus/base/core/error.h"

namespace acus::simulation {
namespace {

namespace ports = effects::ports;
using effects::PortRef;

/// What stages of effects are given, besides what other effects write at every sample.
constexpr PortRef kOfTools[] = {ports::kNeedle, ports::kTissue, ports::kForce, ports::kProbeForce};
constexpr PortRef kOfImages[] = {
    ports::kBMode,        ports::kCtImage,     ports::kRestMap, ports::kProbe,  ports::kNeedle,
    ports::kNeedlePreset, ports::kProbePreset, ports::kShape,   ports::kBreath, ports::kForce};
constexpr PortRef kOfPatient[] = {ports::kCt, ports::kLabels};

bool Holds(std::span<const PortRef> list, PortRef port) {
  return std::ranges::find(list, port) != list.end();
}

bool IsListed(const PlannedStage& stage) {
  return static_cast<int>(stage.id) >= kNumStages;
}

/// True if a stage of an effect that runs at every sample before `stage` writes it.
bool IsWrittenBefore(const EffectPlan& plan, const PlannedStage& stage, PortRef port) {
  for (const PlannedStage& writer : plan.stages()) {
    if (writer.id == stage.id) return false;
    if (writer.in && writer.rate == "step" && IsListed(writer) && Holds(writer.writes, port)) {
      return true;
    }
  }
  return false;
}

void RequirePorts(const EffectPlan& plan, const effects::CalledEffect& called, StageId id) {
  const PlannedStage& stage = plan.Of(id);
  const bool is_image = stage.rate == "image";
  for (const PortRef port : stage.reads) {
    const bool is_file = std::ranges::any_of(
        called.effect->Paths(), [port](const auto& path) { return path.port == port; });
    const bool is_given = is_image ? Holds(kOfImages, port)
                                   : Holds(kOfTools, port) || IsWrittenBefore(plan, stage, port);
    ACUS_REQUIRE(is_file || is_given || Holds(kOfPatient, port), "effects/", called.effect->key(),
                 ": stage '", stage.name, "' reads '", port.name(),
                 is_image ? "', which images are not given"
                          : "', which no stage before it writes at every sample");
  }
}

}  // namespace

ListedEffects::ListedEffects(const scenario::Scenario& scenario, const EffectPlan& plan,
                             const effects::PortValues& data, RunContext& context)
    : data_(data) {
  std::size_t bytes = 0;
  std::size_t columns = 0;
  for (std::size_t n = 0; n < scenario.listed.size(); ++n) {
    const effects::CalledEffect& called = scenario.listed[n];
    const bool steps = plan.Has(simulation::StepStageOf(n));
    const bool has_image = plan.Has(simulation::ImageStageOf(n));
    if (!steps && !has_image) continue;
    if (steps) RequirePorts(plan, called, simulation::StepStageOf(n));
    if (has_image) RequirePorts(plan, called, simulation::ImageStageOf(n));
    ListedEffect effect;
    effect.key = called.effect->key();
    effect.title = called.effect->title();
    effect.step_id = simulation::StepStageOf(n);
    effect.image_id = simulation::ImageStageOf(n);
    effect.loaded = called.effect->Load(called.settings, data, context);
    effect.has_image = has_image;
    effect.timing = called.timing();
    if (steps) {
      effect.step = effect.loaded->step();
      ACUS_ASSERT(effect.step != nullptr);
      effect.moves_tissue = called.MovesTissue();
      effect.columns = called.effect->Columns();
      effect.first_column = columns;
      columns += effect.columns.size();
      const std::size_t aligned = effects::Memory::kAlignment;
      effect.state_at = (bytes + aligned - 1) / aligned * aligned;
      bytes = effect.state_at + effect.step->state_bytes();
      has_steps_ = true;
      moves_tissue_ = moves_tissue_ || effect.moves_tissue;
    }
    all_.push_back(std::move(effect));
  }
  bool after_tools = false;
  for (const PlannedStage& stage : plan.stages()) {
    after_tools = after_tools || stage.id == StageId::kNeedlePose;
    const auto found = std::ranges::find(all_, stage.id, &ListedEffect::step_id);
    if (!stage.in || found == all_.end()) continue;
    steps_[after_tools ? 1 : 0].push_back(static_cast<std::size_t>(found - all_.begin()));
  }
  ACUS_REQUIRE(bytes <= effects::Memory::kBytes, scenario.file.string(),
               ": the states of its effects take ", bytes, " bytes; ", effects::Memory::kBytes,
               " are allowed. Call for fewer effects");
  ACUS_REQUIRE(columns <= effects::kMaxColumns, scenario.file.string(), ": its effects log ",
               columns, " numbers a step; ", effects::kMaxColumns,
               " are allowed. Call for fewer effects");
}

bool ListedEffects::has_images() const {
  return std::ranges::any_of(all_, [](const ListedEffect& effect) {
    return effect.has_image && !effect.timing.has_own_moments;
  });
}

void ListedEffects::Begin(effects::Memory& memory) const {
  for (const ListedEffect& effect : all_) {
    if (effect.step != nullptr) effect.step->BeginIn(memory.bytes.data() + effect.state_at);
  }
}

void ListedEffects::Step(bool after_tools, effects::Memory& memory, const effects::StepTime& time,
                         effects::PortValues& ports, EffectColumns& columns,
                         Stopwatch& watch) const noexcept {
  for (const std::size_t n : steps_[after_tools ? 1 : 0]) {
    const ListedEffect& effect = all_[n];
    const auto activity =
        effect.step->StepIn(memory.bytes.data() + effect.state_at, time, ports,
                            std::span(columns).subspan(effect.first_column, effect.columns.size()));
    watch.EndOf(effect.step_id,
                activity == effects::Activity::kActive ? Sleep::kAwake : Sleep::kEffectIdle);
  }
}

Eigen::Vector3d ListedEffects::RestInCtMm(const effects::Memory& memory,
                                          const Eigen::Vector3d& place_in_ct_mm) const noexcept {
  Eigen::Vector3d rest_mm = place_in_ct_mm;
  for (const ListedEffect& effect : all_) {
    if (effect.moves_tissue) rest_mm = effect.step->RestIn(effect.StateIn(memory), rest_mm);
  }
  return rest_mm;
}

bool ListedEffects::IsSameMotion(const effects::Memory* a,
                                 const effects::Memory* b) const noexcept {
  if (!moves_tissue_) return true;
  if (a == nullptr || b == nullptr) return a == b;
  return std::ranges::all_of(all_, [a, b](const ListedEffect& effect) {
    return !effect.moves_tissue ||
           effect.step->IsSameMotionIn(effect.StateIn(*a), effect.StateIn(*b));
  });
}

double ListedEffects::MotionSpacingMm() const noexcept {
  double spacing_mm = 1e3;
  for (const ListedEffect& effect : all_) {
    if (effect.moves_tissue) spacing_mm = std::min(spacing_mm, effect.step->MotionSpacingMm());
  }
  return spacing_mm;
}

}  // namespace acus::simulation
