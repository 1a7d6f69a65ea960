// Makes a mesh follow the interfaces of a material field.
#pragma once

#include "acus/patient/meshing/material_field.h"
#include "acus/patient/meshing/tetra_editor.h"

namespace acus::meshing {

/// Isosurface stuffing (Labelle & Shewchuk 2007) for any number of materials: nodes close to an
/// interface move onto it, edges that still cross one are divided there, and every tetrahedron gets
/// the material that its nodes share, or that fills most of it. Interfaces are then made of whole
/// faces, shared by the tetrahedra of both sides. Shapes suffer where a node could not be moved:
/// see improve.h.
/// @pre at most 64 materials.
void CutAtInterfaces(TetraEditor& editor, const MaterialField& field);

}  // namespace acus::meshing
