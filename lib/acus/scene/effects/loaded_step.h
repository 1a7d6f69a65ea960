// The loaded form of an effect whose only stage runs at every sample.
#pragma once

#include <utility>

#include "acus/scene/effects/effect.h"

namespace acus::effects {

template <typename Stage>
class LoadedStep final : public LoadedEffect {
 public:
  explicit LoadedStep(Stage stage) : stage_(std::move(stage)) {}
  const StepStage* step() const override { return &stage_; }

 private:
  Stage stage_;
};

}  // namespace acus::effects
