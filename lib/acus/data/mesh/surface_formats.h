// Reading STL, OBJ and PLY text and bytes. Private to surface_io.cpp and its tests.
#pragma once

#include <string>
#include <string_view>

#include "acus/data/mesh/surface.h"

namespace acus::mesh {

/// Each takes a whole file's bytes; `label` stands for its name in messages.
/// @throws InputError if the content is broken. Memory is bounded by the size of `bytes`.
Surface ParseStl(std::string_view bytes, const std::string& label);
Surface ParseObj(std::string_view bytes, const std::string& label);
Surface ParsePly(std::string_view bytes, const std::string& label);

std::string FormatStl(const Surface& surface);
std::string FormatObj(const Surface& surface);
std::string FormatPly(const Surface& surface);

}  // namespace acus::mesh
