// The shaders that cast the rays of an image: the steps of volume_rendering::RayCaster, in the
// language of graphics cards.
#pragma once

#include <string>

namespace acus::graphics {

/// A compute shader of OpenGL 4.5: one invocation a pixel, groups of 8 x 8. Mixes the volume with
/// the surfaces that were drawn before, and lays it over the background: four bytes a pixel.
std::string RayShaderSource();

/// A compute shader: four such pixels an invocation, groups of 64, to three bytes of colour and one
/// of coverage, each in a buffer of its own.
std::string SplitShaderSource();

}  // namespace acus::graphics
