// What a mesh of a label map must keep to: angles, volumes.
#pragma once

#include <string>

#include "acus/patient/meshing/label_mesher.h"

namespace acus::meshing {

/// What the mesh misses, in words; empty if it is good.
std::string Shortfall(const LabelMesh& mesh, const LabelMeshSettings& settings);

/// Takes the tissues whose volume is missed by more than `factor` limits from the conforming ones;
/// with "all" not the largest, which has what the others leave.
/// @return  their names.
std::string GiveUpThinTissues(const LabelMesh& mesh, double factor, LabelMeshSettings& settings);

}  // namespace acus::meshing
