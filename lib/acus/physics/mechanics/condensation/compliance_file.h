// A compliance on disk: compliance.acc, beside the mesh that it was made for.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/mechanics/condensation/compliance_key.h"
#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/mechanics/condensation/image_block.h"

namespace acus::mechanics {

struct ComplianceFileCost {
  double image_s = 0.0;  ///< Solving for the visible nodes. CPU time.
  double write_s = 0.0;
  double compliance_mib = 0.0;
  double image_mib = 0.0;
  std::string key;  ///< SHA-256 of all that the file depends on, as hex.
};

/// Writes the file, whole or not at all. Format: docs/reference/formats_mechanics.md.
/// @param condensation  Its visible nodes are set here.
/// @param key  Of the mesh, table and element that `condensation` was made with.
/// @param visible  Mesh nodes that are free, ascending, for the image block; may be empty: none.
/// @throws InputError if it cannot be written.
ComplianceFileCost WriteCompliance(const std::filesystem::path& path, Condensation& condensation,
                                   const ComplianceKey& key, Eigen::Index num_mesh_nodes,
                                   std::span<const int> visible, Storage storage,
                                   const RunContext& context);

/// What of a file's numbers is held against its checksums. Header and tables always are.
enum class ComplianceCheck {
  kNothing,     ///< Opens at once, whatever the size; pages are read when first used.
  kCompliance,  ///< Reads the compliance, so that it is in memory before the first step.
  kEverything,  ///< The image block, too.
};

/// A mapped file; the numbers stay as long as a copy of either part does.
struct CondensedTissue {
  Compliance compliance;
  ImageBlock image;  ///< Holds nothing if the file has none.
};

/// Opens a file that was made for this mesh, table and element.
/// @throws InputError if it is missing, no such file, cut off, damaged, from another version or
///     byte order, or if it was made for another mesh, other elastic constants or another element:
///     the message says which, and the command that makes it again.
CondensedTissue OpenCompliance(const std::filesystem::path& path, const mesh::TetraMesh& mesh,
                               const ElasticityTable& elasticity, ElementKind element,
                               ComplianceCheck check = ComplianceCheck::kCompliance);

}  // namespace acus::mechanics
