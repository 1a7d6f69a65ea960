// What a compliance depends on, as hashes: whether a stored one still holds.
#pragma once

#include <string>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/stiffness.h"

namespace acus::mechanics {

struct ComplianceKey {
  std::string mesh_sha256;        ///< Of nodes, tetrahedra, tissues and fixed flags, as hex.
  std::string elasticity_sha256;  ///< Of the constants of those tissues that can be deformed.
  std::string element;            ///< As ElementName.
};

/// Goes by content: file names, and rows of the table that the mesh has no use for, do not count.
/// @throws InputError if the mesh has no tissue ids, or the table no row for a tissue that can be
///     deformed.
ComplianceKey KeyOf(const mesh::TetraMesh& mesh, const ElasticityTable& elasticity,
                    ElementKind element);

}  // namespace acus::mechanics
