// The shaders that find which blocks of the world can show something: what
// volume_rendering::VisibleBlocks does, in the language of graphics cards.
#pragma once

#include <string>

namespace acus::graphics {

/// A compute shader: one invocation a visible block at rest, groups of 64. Marks the blocks that
/// its content can be in with 0.
std::string MarkBlocksSource();
/// A compute shader: one invocation a block, groups of 4 x 4 x 4. Distances along one axis after
/// the other give that in the sense of the largest coordinate.
std::string SpreadDistancesSource();
/// A compute shader: the same invocations. Within a box, what is near becomes 0.
std::string WidenBlocksSource();

}  // namespace acus::graphics
