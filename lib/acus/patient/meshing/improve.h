// Raises the smallest dihedral angles of a mesh by local changes.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/patient/meshing/material_field.h"
#include "acus/patient/meshing/tetra_editor.h"

namespace acus::meshing {

struct ImproveSettings {
  double goal_deg = 15.0;  ///< Tetrahedra at or above this are left alone.
  int max_passes = 18;
  double drift_share = 0.12;  ///< An interface may move by this share of the local edge length.
};

/// Works through the tetrahedra below the goal, worst first: removes edges and swaps faces
/// (Freitag & Ollivier-Gooch 1997), moves nodes to where the smallest angle around them is largest,
/// those on interfaces along them, collapses edges, and gives flat tetrahedra on an interface to
/// the other side. Each change is kept only if it raises the smallest angle of all that it touches,
/// so that no angle ever falls, and nothing turns inside out. Where all that is not enough, the
/// later passes let nodes leave their interface a little. Deterministic.
///
/// @param field  Interface nodes stay on its interfaces; null: they do not move.
/// @returns the smallest dihedral angle, deg.
double Improve(TetraEditor& editor, const MaterialField* field, const ImproveSettings& settings,
               const RunContext& context);

/// Moves interface nodes back to their interface as far as angles stay above `floor_deg`.
void ReturnToInterfaces(TetraEditor& editor, const MaterialField& field, double floor_deg);

}  // namespace acus::meshing
