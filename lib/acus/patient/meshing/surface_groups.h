// Which tissues of a label map get a surface of their own in the mesh.
#pragma once

#include <array>
#include <string>

#include "acus/data/volume/volume.h"
#include "acus/patient/meshing/label_mesher.h"
#include "acus/patient/meshing/material_field.h"

namespace acus::meshing {

/// Volume of each label.
using LabelVolumes = std::array<double, 256>;

/// The name that the map gives to a label, or "label 7".
std::string NameOf(const volume::LabelMap& labels, int label);

LabelVolumes VolumesMm3(const volume::LabelMap& labels);

/// Volume of all labels except 0.
double BodyMm3(const LabelVolumes& volumes);

/// True if every tissue that occurs gets a surface.
bool AllConform(const LabelMeshSettings& settings);

/// Materials, which surfaces separate: 0 outside, 1 all tissues that need no surface of their own,
/// then the conforming ones. Where all conform, the largest is 1: its surface is what the others
/// leave.
struct SurfaceGroups {
  MaterialOfLabel material_of_label{};
  int num_materials = 2;
};

/// @param map_mm3  Of `labels`.
/// @throws InputError if there are more than 62 conforming tissues.
SurfaceGroups GroupsOf(const volume::LabelMap& labels, const LabelVolumes& map_mm3,
                       const LabelMeshSettings& settings);

}  // namespace acus::meshing
