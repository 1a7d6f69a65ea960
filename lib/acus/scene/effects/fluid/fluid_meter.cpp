#include "acus/scene/effects/fluid/fluid_meter.h"

#include <algorithm>

#include "acus/base/core/counted.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/scene/effects/fluid/fluid_stage.h"

namespace acus::effects {
namespace {

constexpr double kLimitKpa = fluid::FluidEventLimits{}.high_kpa;

double At(std::span<const double> columns, FluidColumn column) {
  return columns[static_cast<std::size_t>(column)];
}

}  // namespace

void FluidMeter::Add(double session_s, std::span<const double> columns) {
  const double kpa = At(columns, FluidColumn::kSyringeKpa);
  largest_kpa_ = std::max(largest_kpa_, kpa);
  injected_ml_ = At(columns, FluidColumn::kInjectedMl);
  returned_ml_ = At(columns, FluidColumn::kReturnedMl);
  if (losses_ == 0.0) before_loss_kpa_ = std::max(before_loss_kpa_, kpa);
  const double losses = At(columns, FluidColumn::kLosses);
  if (losses > 0.0 && losses_ == 0.0) first_loss_s_ = deepest_s_ = session_s;
  losses_ = losses;
  false_losses_ = At(columns, FluidColumn::kFalseLosses);
  dural_punctures_ = At(columns, FluidColumn::kDuralPunctures);
  vessel_entries_ = At(columns, FluidColumn::kVesselEntries);
  aspirated_ml_ = At(columns, FluidColumn::kAspiratedMl);
  into_space_ml_ = std::max(into_space_ml_, At(columns, FluidColumn::kSpaceMl));
  from_space_ml_ = std::max(from_space_ml_, -At(columns, FluidColumn::kSpaceMl));
  stylet_removals_ = At(columns, FluidColumn::kStyletRemovals);
  const double beyond_mm = At(columns, FluidColumn::kBeyondLossMm);
  if (losses_ > 0.0 && beyond_mm > overshoot_mm_) {
    overshoot_mm_ = beyond_mm;
    deepest_s_ = session_s;
  }
}

std::vector<MeasuredValue> FluidMeter::Values() const {
  std::vector<MeasuredValue> values = {
      {"largest injection pressure", "kPa", largest_kpa_},
      {"injected volume", "ml", injected_ml_},
      {"fluid returned at the hub", "ml", returned_ml_},
      {"aspirated volume", "ml", aspirated_ml_},
      {"injected into the space", "ml", into_space_ml_},
      {"drawn from the space", "ml", from_space_ml_},
      {"stylet removals", "", stylet_removals_},
      {"losses of resistance in the epidural space", "", losses_},
      {"losses of resistance elsewhere", "", false_losses_},
      {"dural punctures", "", dural_punctures_},
      {"vessel entries", "", vessel_entries_},
      {"advance after the loss of resistance", "mm", overshoot_mm_},
      {"time from the loss of resistance to the stop", "s", deepest_s_ - first_loss_s_}};
  return values;
}

void FluidMeter::AddLossTo(std::vector<std::string>& findings) const {
  if (losses_ > 0.0) {
    findings.push_back(
        Message("The resistance was lost in the epidural space at ", RoundedText(first_loss_s_, 3),
                " s; the pressure had reached ", RoundedText(before_loss_kpa_, 3),
                " kPa before. The needle advanced ", RoundedText(overshoot_mm_, 3),
                " mm after it, over ", RoundedText(deepest_s_ - first_loss_s_, 3), " s."));
  } else {
    findings.emplace_back("There was no loss of resistance in the epidural space.");
  }
}

std::vector<std::string> FluidMeter::Findings() const {
  std::vector<std::string> findings;
  if (space_.empty()) {
    AddLossTo(findings);
  } else {
    std::string name = space_;
    std::ranges::replace(name, '_', ' ');
    findings.push_back(Message("Space: ", name,
                               ". Injected into it: ", RoundedText(into_space_ml_, 3),
                               " ml; drawn from it: ", RoundedText(from_space_ml_, 3),
                               " ml; returned at the hub: ", RoundedText(returned_ml_, 3), " ml."));
  }
  if (false_losses_ > 0.0) {
    findings.push_back(
        Message(Counted(static_cast<std::int64_t>(false_losses_), "loss# of resistance elsewhere"),
                ": a gap, fat or a cavity."));
  }
  if (dural_punctures_ > 0.0) {
    findings.push_back(Message("The dura was punctured ",
                               Counted(static_cast<std::int64_t>(dural_punctures_), "time"), "."));
  }
  if (vessel_entries_ > 0.0) {
    findings.push_back(Message("The needle's tip was in a vessel ",
                               Counted(static_cast<std::int64_t>(vessel_entries_), "time"), "."));
  }
  if (largest_kpa_ > kLimitKpa) {
    findings.push_back(Message("The injection pressure reached ", RoundedText(largest_kpa_, 3),
                               " kPa; above ", kLimitKpa,
                               " kPa (15 psi) an injection near a nerve is unsafe."));
  }
  return findings;
}

}  // namespace acus::effects
