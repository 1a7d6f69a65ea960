// Which blocks of the world can show something at a moment, found by a graphics card.
#pragma once

#include "acus/imaging/graphics/gl_objects.h"
#include "acus/imaging/volume_rendering/pressed_tissue.h"
#include "acus/imaging/volume_rendering/visible_blocks.h"

namespace acus::graphics {

/// Belongs to one context, and to the thread in which that is current.
class BlocksOnCard {
 public:
  BlocksOnCard();

  /// Once. @pre Something is visible.
  void Load(const volume_rendering::VisibleBlocks& blocks);
  /// For a moment. What VisibleBlocks::Update and Widen find, or a little more.
  /// @param motion, pressed  Null: none.
  void Update(const volume_rendering::VisibleBlocks& blocks,
              const volume_rendering::BlockFrame& frame, const breathing::MotionMap* motion,
              const volume_rendering::PressedTissue* pressed);
  void Bind(unsigned unit) const { distances_[current_].Bind(unit); }

 private:
  void Spread();
  void Widen(const volume_rendering::VisibleBlocks& blocks,
             const volume_rendering::PressedTissue& pressed);

  Program mark_;
  Program spread_;
  Program widen_;
  Buffer rest_, ranges_;
  Texture distances_[2];  ///< Each is written from the other.
  int current_ = 0;
  volume_rendering::BlockFrame frame_;
};

}  // namespace acus::graphics
