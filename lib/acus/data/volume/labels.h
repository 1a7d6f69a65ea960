// The standard labels: one number, one name and one colour for every tissue.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "acus/data/volume/volume.h"

namespace acus::volume {

struct StandardLabel {
  Label label;
  std::string_view name;               ///< As in tissue tables and `.seg.nrrd` segment names.
  std::array<std::uint8_t, 3> colour;  ///< sRGB.
};

/// All standard labels, by number from 0 ("outside").
std::span<const StandardLabel> StandardLabels();

std::optional<Label> FindLabel(std::string_view name);

/// The number of a standard label. @throws InputError naming the nearest known one.
Label LabelOf(std::string_view name);

/// The colour of a label; labels beyond the standard ones get grey.
std::array<std::uint8_t, 3> ColourOf(Label label);

}  // namespace acus::volume
