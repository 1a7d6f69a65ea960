// Rest positions of the tissue that an image shows: the maps of breath, effects and tools, one
// after the other.
#pragma once

#include <optional>

#include "acus/scene/simulation/breathing_scene.h"
#include "acus/scene/simulation/deformed_tissue.h"
#include "acus/scene/simulation/pressed_by_proxies.h"
#include "acus/scene/simulation/pressed_skin.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/snapshot.h"

namespace acus::simulation {

/// Maps tissue to where it was before the effects of the list moved it.
class EffectsRest : public slicing::RestMap {
 public:
  /// @param next  The next map; may be null. All must outlive this.
  EffectsRest(const ListedEffects& effects, const effects::Memory& memory,
              const slicing::RestMap* next)
      : effects_(effects), memory_(memory), next_(next) {}

  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept override;
  double SpacingMm() const noexcept override;

 private:
  const ListedEffects& effects_;
  const effects::Memory& memory_;
  const slicing::RestMap* next_;
};

/// The rest map of one instant at a time. One for each thread.
class MomentRest {
 public:
  /// @param scene  Must outlive this. @param beyond_skin  As for DeformedTissue.
  explicit MomentRest(const Scene& scene, bool beyond_skin = false);

  /// Null if nothing moves the tissue. Valid until the next call, and as long as the snapshot is.
  /// Allocates nothing after the first call.
  const slicing::RestMap* At(const Snapshot& snapshot);

 private:
  const Scene* scene_;
  std::optional<DeformedTissue> deformed_;
  std::optional<EffectsRest> effects_;
  std::optional<BreathingRest> breathing_;
  std::optional<forces::TissueLookup> tissue_;  ///< If the probe presses.
  std::optional<PressedSkin> pressed_;
  std::optional<PressedByProxies> palpated_;
};

}  // namespace acus::simulation
