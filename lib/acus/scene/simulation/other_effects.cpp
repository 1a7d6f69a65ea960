#include "acus/scene/simulation/other_effects.h"

#include <algorithm>

#include "acus/base/core/error.h"

namespace acus::simulation {
namespace {

namespace ports = effects::ports;
using effects::PortRef;

/// What the stages of effects can be given, besides what other effects write.
constexpr PortRef kOfTools[] = {ports::kNeedle, ports::kTissue, ports::kForce, ports::kProbeForce};
constexpr PortRef kOfImages[] = {ports::kBMode, ports::kCtImage, ports::kRestMap, ports::kProbe};
constexpr PortRef kOfPatient[] = {ports::kCt, ports::kLabels};

bool Holds(std::span<const PortRef> list, PortRef port) {
  return std::ranges::find(list, port) != list.end();
}

void RequirePorts(const scenario::Scenario& scenario, const effects::CalledEffect& called,
                  const effects::StageDeclaration& stage, std::span<const PortRef> offered) {
  for (const PortRef port : stage.reads) {
    const bool is_file = std::ranges::any_of(
        called.effect->Paths(), [port](const auto& path) { return path.port == port; });
    const bool is_written = std::ranges::any_of(scenario.others, [port](const auto& other) {
      const auto step = other.step();
      return step && Holds(step->writes, port);
    });
    ACUS_REQUIRE(is_file || is_written || Holds(offered, port) || Holds(kOfPatient, port),
                 "effects/", called.effect->key(), ": stage '", stage.name, "' reads '",
                 port.name(), "', which it cannot be given");
  }
}

}  // namespace

OtherEffects::OtherEffects(const scenario::Scenario& scenario, const EffectPlan& plan,
                           const effects::PortValues& data, RunContext& context)
    : data_(data) {
  std::size_t bytes = 0;
  std::size_t columns = 0;
  for (std::size_t n = 0; n < scenario.others.size(); ++n) {
    const effects::CalledEffect& called = scenario.others[n];
    const bool steps = plan.Has(simulation::StepStageOf(n));
    const bool has_image = plan.Has(simulation::ImageStageOf(n));
    if (!steps && !has_image) continue;
    if (steps) RequirePorts(scenario, called, *called.step(), kOfTools);
    if (has_image) RequirePorts(scenario, called, *called.image(), kOfImages);
    OtherEffect other;
    other.key = called.effect->key();
    other.title = called.effect->title();
    other.step_id = simulation::StepStageOf(n);
    other.image_id = simulation::ImageStageOf(n);
    other.loaded = called.effect->Load(called.settings, data, context);
    other.has_image = has_image;
    if (steps) {
      other.step = other.loaded->step();
      ACUS_ASSERT(other.step != nullptr);
      other.moves_tissue = called.MovesTissue();
      other.after_tools = std::ranges::any_of(called.step()->reads,
                                              [](PortRef port) { return Holds(kOfTools, port); });
      other.columns = called.effect->Columns();
      other.first_column = columns;
      columns += other.columns.size();
      const std::size_t aligned = effects::Memory::kAlignment;
      other.state_at = (bytes + aligned - 1) / aligned * aligned;
      bytes = other.state_at + other.step->state_bytes();
      has_steps_ = true;
      moves_tissue_ = moves_tissue_ || other.moves_tissue;
    }
    all_.push_back(std::move(other));
  }
  ACUS_REQUIRE(bytes <= effects::Memory::kBytes, scenario.file.string(),
               ": the states of its effects take ", bytes, " bytes; ", effects::Memory::kBytes,
               " are allowed. Call for fewer effects");
  ACUS_REQUIRE(columns <= effects::kMaxColumns, scenario.file.string(), ": its effects log ",
               columns, " numbers a step; ", effects::kMaxColumns,
               " are allowed. Call for fewer effects");
}

bool OtherEffects::has_images() const {
  return std::ranges::any_of(all_, &OtherEffect::has_image);
}

void OtherEffects::Begin(effects::Memory& memory) const {
  for (const OtherEffect& other : all_) {
    if (other.step != nullptr) other.step->BeginIn(memory.bytes.data() + other.state_at);
  }
}

void OtherEffects::Step(bool after_tools, effects::Memory& memory, const effects::StepTime& time,
                        effects::PortValues& ports, EffectColumns& columns,
                        Stopwatch& watch) const noexcept {
  for (const OtherEffect& other : all_) {
    if (other.step == nullptr || other.after_tools != after_tools) continue;
    const auto activity =
        other.step->StepIn(memory.bytes.data() + other.state_at, time, ports,
                           std::span(columns).subspan(other.first_column, other.columns.size()));
    watch.EndOf(other.step_id,
                activity == effects::Activity::kActive ? Sleep::kAwake : Sleep::kEffectIdle);
  }
}

Eigen::Vector3d OtherEffects::RestInCtMm(const effects::Memory& memory,
                                         const Eigen::Vector3d& place_in_ct_mm) const noexcept {
  Eigen::Vector3d rest_mm = place_in_ct_mm;
  for (const OtherEffect& other : all_) {
    if (other.moves_tissue) rest_mm = other.step->RestIn(other.StateIn(memory), rest_mm);
  }
  return rest_mm;
}

bool OtherEffects::IsSameMotion(const effects::Memory* a, const effects::Memory* b) const noexcept {
  if (!moves_tissue_) return true;
  if (a == nullptr || b == nullptr) return a == b;
  return std::ranges::all_of(all_, [a, b](const OtherEffect& other) {
    return !other.moves_tissue || other.step->IsSameMotionIn(other.StateIn(*a), other.StateIn(*b));
  });
}

double OtherEffects::MotionSpacingMm() const noexcept {
  double spacing_mm = 1e3;
  for (const OtherEffect& other : all_) {
    if (other.moves_tissue) spacing_mm = std::min(spacing_mm, other.step->MotionSpacingMm());
  }
  return spacing_mm;
}

}  // namespace acus::simulation
