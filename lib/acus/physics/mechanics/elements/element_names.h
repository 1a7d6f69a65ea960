// Elements as they are called in files.
#pragma once

#include <string>
#include <string_view>

#include "acus/physics/mechanics/elements/stiffness.h"

namespace acus::mechanics {

/// Such as "linear".
std::string_view ElementName(ElementKind kind);

/// @throws InputError that lists the known names; `what` says where the name stands.
ElementKind ElementNamed(std::string_view name, const std::string& what);

}  // namespace acus::mechanics
