// Tissue under the tools of a live session, for the views in three dimensions.
#pragma once

#include <memory>

#include "acus/imaging/volume_rendering/pressed_tissue.h"
#include "acus/run/live/live_snapshot.h"
#include "acus/scene/simulation/scene.h"

namespace acus::window {

/// Computes it beside the session, in a thread of lower priority (5 more of nice): for the newest
/// moment, one after the other. Nobody waits for it.
class TissueWatch {
 public:
  /// Starts no thread if the scene's tools press nothing that images show.
  /// @param scene  Must outlive this.
  explicit TissueWatch(const simulation::Scene& scene);
  ~TissueWatch();
  TissueWatch(const TissueWatch&) = delete;
  TissueWatch& operator=(const TissueWatch&) = delete;

  /// Takes a copy, unless tissue and tools are where they were when it was last asked.
  void Ask(const live::LiveSnapshot& snapshot);
  /// Of the newest moment that is done; null if nothing is pressed.
  std::shared_ptr<const volume_rendering::PressedTissue> Newest() const;
  /// Until no moment waits or is under way.
  void Wait();

 private:
  struct Content;
  std::unique_ptr<Content> content_;  ///< Null: nothing is pressed.
};

}  // namespace acus::window
