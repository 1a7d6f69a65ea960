// The shader that casts the rays of an image: the steps of volume_rendering::RayCaster, in the
// language of graphics cards.
#pragma once

#include <string>

namespace acus::graphics {

/// A compute shader of OpenGL 4.5: one invocation a pixel, groups of 8 x 8. What it reads is set by
/// ShaderRays.
std::string RayShaderSource();

}  // namespace acus::graphics
