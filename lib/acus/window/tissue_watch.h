// Tissue under the tools of a live session, for the views in three dimensions.
#pragma once

#include <memory>

#include "acus/imaging/volume_rendering/pressed_tissue.h"
#include "acus/run/live/live_snapshot.h"
#include "acus/scene/simulation/scene.h"

namespace acus::window {

/// Computes the deformation in a thread of lower priority (nice value + 5): for the newest
/// snapshot, one after the other. No caller waits for it.
class TissueWatch {
 public:
  /// Starts no thread if images show no tissue that the scene's tools press.
  /// @param scene  Must outlive this.
  explicit TissueWatch(const simulation::Scene& scene);
  ~TissueWatch();
  TissueWatch(const TissueWatch&) = delete;
  TissueWatch& operator=(const TissueWatch&) = delete;

  /// Takes a copy, unless tissue and tools have not moved since the last request.
  void Ask(const live::LiveSnapshot& snapshot);
  /// Result of the newest completed snapshot; null if nothing is pressed.
  std::shared_ptr<const volume_rendering::PressedTissue> Newest() const;
  /// Waits until no snapshot is waiting or in work.
  void Wait();

 private:
  struct Content;
  std::unique_ptr<Content> content_;  ///< Null: nothing is pressed.
};

}  // namespace acus::window
