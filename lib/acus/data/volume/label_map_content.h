// What a label map holds: names and numbers of voxels.
#pragma once

#include <array>
#include <string>

#include "acus/data/volume/volume.h"

namespace acus::volume {

/// The standard name of a label, or "label_N".
std::string NameOfLabel(Label label);

/// The name that a map gives a label; without one, as above.
std::string NameOfLabel(const LabelMap& labels, Label label);

/// Voxels of each label.
std::array<std::size_t, 256> CountsByLabel(const LabelMap& labels);

}  // namespace acus::volume
