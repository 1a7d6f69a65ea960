// Whether a surface has an inside.
#pragma once

#include <string>

#include "acus/data/mesh/surface.h"

namespace acus::mesh {

/// How the triangles of a closed surface hang together.
enum class Winding {
  kOriented,    ///< All triangles face the same way: inside is where the surface winds around.
  kUnoriented,  ///< Triangles face either way: inside is behind an odd number of crossings.
};

/// @throws InputError naming `label`, the number of open edges and where the first one is, if the
///     surface is not closed; if it has no triangle or a coordinate that is not finite.
Winding CheckClosed(const Surface& surface, const std::string& label);

}  // namespace acus::mesh
