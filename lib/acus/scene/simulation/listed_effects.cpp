#include "acus/scene/simulation/listed_effects.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::simulation {
namespace {

namespace ports = effects::ports;
using effects::PortRef;

/// What stages of effects are given, besides what other effects write at every sample.
constexpr PortRef kOfTools[] = {ports::kNeedle, ports::kTissue, ports::kForce, ports::kProbeForce,
                                ports::kPlungerForce};
constexpr PortRef kOfImages[] = {
    ports::kBMode,        ports::kCtImage,     ports::kRestMap, ports::kProbe,  ports::kNeedle,
    ports::kNeedlePreset, ports::kProbePreset, ports::kShape,   ports::kBreath, ports::kForce};
constexpr PortRef kOfPatient[] = {ports::kCt, ports::kLabels, ports::kNeedlePreset};

bool Holds(std::span<const PortRef> list, PortRef port) {
  return std::ranges::find(list, port) != list.end();
}

/// An effect's stage of that rate; null if the plan has none.
const PlannedStage* StageOf(const EffectPlan& plan, std::string_view key, bool is_image) {
  for (const PlannedStage& stage : plan.stages()) {
    if (stage.in && stage.owner == key && stage.is_image() == is_image) return &stage;
  }
  return nullptr;
}

/// True if a stage of an effect of the list that runs at every sample before `stage` writes it.
bool IsWrittenBefore(const EffectPlan& plan, const scenario::Scenario& scenario,
                     const PlannedStage& stage, PortRef port) {
  return std::ranges::any_of(scenario.listed, [&](const effects::CalledEffect& called) {
    const PlannedStage* writer = StageOf(plan, called.effect->key(), false);
    return writer != nullptr && writer->number < stage.number && writer->Writes(port);
  });
}

void RequirePorts(const EffectPlan& plan, const scenario::Scenario& scenario,
                  const effects::CalledEffect& called, const PlannedStage& stage) {
  for (const PortRef port : stage.reads) {
    const bool is_file = std::ranges::any_of(
        called.effect->Paths(), [port](const auto& path) { return path.port == port; });
    const bool is_given =
        stage.is_image() ? Holds(kOfImages, port)
                         : Holds(kOfTools, port) || IsWrittenBefore(plan, scenario, stage, port);
    ACUS_REQUIRE(is_file || is_given || Holds(kOfPatient, port), "effects/", called.effect->key(),
                 ": stage '", stage.name, "' reads '", port.name(),
                 stage.is_image() ? "', which images are not given"
                                  : "', which no stage before it writes at every sample");
  }
  ACUS_REQUIRE(!stage.Writes(ports::kAddedForce) || plan.Writes(ports::kForce), "effects/",
               called.effect->key(), ": stage '", stage.name,
               "' adds a force on the needle to that of effects/needle_force, which is not there; "
               "add it, for example --set /effects/needle_force/model=layered");
}

}  // namespace

ListedEffects::ListedEffects(const scenario::Scenario& scenario, const EffectPlan& plan,
                             const effects::PortValues& data,
                             const forces::NeedleProperties* needle, RunContext& context)
    : data_(data) {
  effects::PortValues loading = data;
  if (needle != nullptr) loading.Set(ports::kNeedlePreset, needle);
  std::size_t bytes = 0;
  std::size_t columns = 0;
  for (const effects::CalledEffect& called : scenario.listed) {
    const PlannedStage* step = StageOf(plan, called.effect->key(), false);
    const PlannedStage* image = StageOf(plan, called.effect->key(), true);
    if (step == nullptr && image == nullptr) continue;
    if (step != nullptr) RequirePorts(plan, scenario, called, *step);
    if (image != nullptr) RequirePorts(plan, scenario, called, *image);
    ListedEffect effect;
    effect.key = called.effect->key();
    effect.title = called.effect->title();
    if (image != nullptr) effect.image_stage = image->number;
    effect.loaded = called.effect->Load(called.settings, loading, context);
    effect.has_image = image != nullptr;
    effect.timing = called.timing();
    if (step != nullptr) {
      effect.step_stage = step->number;
      effect.step = effect.loaded->step();
      ACUS_ASSERT(effect.step != nullptr);
      effect.moves_tissue = step->Writes(ports::kTissueMotion);
      effect.shows_motion = effect.moves_tissue || step->Writes(ports::kSwelling);
      effect.adds_force = step->Writes(ports::kAddedForce);
      effect.changes_echo = step->Writes(ports::kEcho);
      effect.columns = called.effect->Columns();
      effect.first_column = columns;
      columns += effect.columns.size();
      const std::size_t aligned = effects::Memory::kAlignment;
      effect.state_at = (bytes + aligned - 1) / aligned * aligned;
      bytes = effect.state_at + effect.step->state_bytes();
      has_steps_ = true;
      moves_tissue_ = moves_tissue_ || effect.moves_tissue;
      shows_motion_ = shows_motion_ || effect.shows_motion;
      adds_force_ = adds_force_ || effect.adds_force;
      changes_echo_ = changes_echo_ || effect.changes_echo;
    }
    all_.push_back(std::move(effect));
  }
  const std::size_t first_of_tools = plan.WriterOf(ports::kNeedle).number;
  for (const PlannedStage& stage : plan.stages()) {
    for (std::size_t n = 0; n < all_.size(); ++n) {
      if (all_[n].step == nullptr || all_[n].step_stage != stage.number) continue;
      steps_[stage.number > first_of_tools ? 1 : 0].push_back(n);
    }
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
    watch.EndOf(effect.step_stage,
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

Eigen::Vector3d ListedEffects::SeenRestInCtMm(
    const effects::Memory& memory, const Eigen::Vector3d& place_in_ct_mm) const noexcept {
  Eigen::Vector3d rest_mm = place_in_ct_mm;
  for (const ListedEffect& effect : all_) {
    if (effect.shows_motion) {
      rest_mm = effect.step->RestIn(effect.StateIn(memory), rest_mm);
    }
  }
  return rest_mm;
}

bool ListedEffects::IsSameMotion(const effects::Memory* a,
                                 const effects::Memory* b) const noexcept {
  if (!shows_motion_) return true;
  if (a == nullptr || b == nullptr) return a == b;
  return std::ranges::all_of(all_, [a, b](const ListedEffect& effect) {
    return !effect.shows_motion ||
           effect.step->IsSameMotionIn(effect.StateIn(*a), effect.StateIn(*b));
  });
}

Eigen::Vector3d ListedEffects::AddedForceInCtN(const effects::Memory& memory) const noexcept {
  Eigen::Vector3d sum_n = Eigen::Vector3d::Zero();
  for (const auto& order : steps_) {
    for (const std::size_t n : order) {
      if (!all_[n].adds_force) continue;
      const Eigen::Vector3d force_n = all_[n].step->ForceIn(all_[n].StateIn(memory));
      const double size_n = force_n.norm();
      if (!std::isfinite(size_n)) continue;
      sum_n +=
          size_n > kLargestAddedN ? Eigen::Vector3d(force_n * (kLargestAddedN / size_n)) : force_n;
    }
  }
  return sum_n;
}

bool ListedEffects::ChangesEchoNow(const effects::Memory& memory) const noexcept {
  return std::ranges::any_of(all_, [&memory](const ListedEffect& effect) {
    return effect.changes_echo && effect.step->ChangesEchoIn(effect.StateIn(memory));
  });
}

double ListedEffects::EchoChangeDb(const effects::Memory& memory,
                                   const effects::EchoPlace& place) const noexcept {
  double change_db = 0.0;
  for (const ListedEffect& effect : all_) {
    if (effect.changes_echo)
      change_db += effect.step->EchoChangeDbIn(effect.StateIn(memory), place);
  }
  return change_db;
}

bool ListedEffects::IsSameEcho(const effects::Memory* a, const effects::Memory* b) const noexcept {
  if (!changes_echo_) return true;
  if (a == nullptr || b == nullptr) return a == b;
  return std::ranges::all_of(all_, [a, b](const ListedEffect& effect) {
    return !effect.changes_echo ||
           effect.step->IsSameEchoIn(effect.StateIn(*a), effect.StateIn(*b));
  });
}

double ListedEffects::MotionSpacingMm() const noexcept {
  double spacing_mm = 1e3;
  for (const ListedEffect& effect : all_) {
    if (effect.shows_motion) {
      spacing_mm = std::min(spacing_mm, effect.step->MotionSpacingMm());
    }
  }
  return spacing_mm;
}

}  // namespace acus::simulation
