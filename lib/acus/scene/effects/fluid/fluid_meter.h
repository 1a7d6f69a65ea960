// What an injection is judged by.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

class FluidMeter final : public EffectMeter {
 public:
  /// @param space  As in the fluid table; empty: the epidural space, found by its resistance.
  explicit FluidMeter(std::string space = "") : space_(std::move(space)) {}
  void Add(double session_s, std::span<const double> columns) override;
  std::vector<MeasuredValue> Values() const override;
  std::vector<std::string> Findings() const override;

 private:
  void AddLossTo(std::vector<std::string>& findings) const;

  std::string space_;
  double largest_kpa_ = 0.0;
  double injected_ml_ = 0.0;
  double returned_ml_ = 0.0;
  double losses_ = 0.0;
  double false_losses_ = 0.0;
  double dural_punctures_ = 0.0;
  double vessel_entries_ = 0.0;
  double aspirated_ml_ = 0.0;
  double into_space_ml_ = 0.0;  ///< The most at any time.
  double from_space_ml_ = 0.0;  ///< The most at any time.
  double stylet_removals_ = 0.0;
  double before_loss_kpa_ = 0.0;  ///< Highest pressure before the first loss.
  double first_loss_s_ = 0.0;     ///< Time of the first loss in the epidural space.
  double overshoot_mm_ = 0.0;     ///< Largest advance after it.
  double deepest_s_ = 0.0;        ///< When that was reached.
};

}  // namespace acus::effects
