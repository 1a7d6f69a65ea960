// Rays of the volume view on a graphics card.
#pragma once

#include <memory>

#include "acus/imaging/graphics/gl_context.h"
#include "acus/imaging/volume_rendering/ray_device.h"

namespace acus::graphics {

/// Casts rays by a shader, in a separate thread with its own OpenGL context: whoever calls needs
/// neither, and disturbs none. The image of volume_rendering::RayCaster except for the card's
/// arithmetic: texels are interpolated with its weights, and breath is inverted at every sample.
/// @throws InputError if there is no driver of that kind, or it does not compile the shader.
std::unique_ptr<volume_rendering::RayDevice> MakeShaderRays(DriverKind kind);

}  // namespace acus::graphics
