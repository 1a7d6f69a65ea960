// Volumes of the tissues in the mesh: interfaces are moved until they are right.
#pragma once

#include <vector>

#include "acus/patient/meshing/material_field.h"
#include "acus/patient/meshing/tetra_editor.h"

namespace acus::meshing {

/// Moves the field's interfaces so that the materials come nearer to their volumes.
/// @param target_mm3  By material; that of 0, outside, is not read.
/// @return  the largest relative error before.
double ShiftInterfaces(const TetraEditor& editor, const std::vector<double>& target_mm3,
                       MaterialField& field);

}  // namespace acus::meshing
