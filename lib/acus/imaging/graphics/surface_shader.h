// The shaders that draw surfaces and tools: what volume_rendering::TriangleBands does, in the
// language of graphics cards.
#pragma once

#include <string>

namespace acus::graphics {

/// A vertex shader: tissue is moved by breath and by tools, tools stay where they are.
std::string SurfaceVertexSource();
/// Fragment shaders. Opaque surfaces go into two images, colour and distance, by the depth test;
/// translucent ones that are before these into a list for each ray.
std::string OpaqueFragmentSource();
std::string TranslucentFragmentSource();

/// Vertices and fragments of the map of shadows: how near the lamp the tools are.
std::string ShadowVertexSource();
std::string ShadowFragmentSource();

}  // namespace acus::graphics
