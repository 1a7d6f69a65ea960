#include "acus/physics/mechanics/condensation/compliance_key.h"

#include <bitset>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/provenance.h"
#include "acus/data/mesh/packed_mesh.h"
#include "acus/physics/mechanics/elements/element_names.h"

namespace acus::mechanics {
namespace {

std::string HashOf(const mesh::TetraMesh& mesh) {
  core::ByteWriter out(mesh::kPackedOrder);
  out.Array(mesh::ValuesOf(mesh.nodes_mm));
  out.Array(mesh::ValuesOf(mesh.tetrahedra));
  out.Array(std::span<const std::uint8_t>(mesh.tissue));
  out.Array(std::span<const std::uint8_t>(mesh.fixed_nodes));
  return Sha256OfText(out.AsString());
}

std::string HashOf(const ElasticityTable& table, const mesh::TetraMesh& mesh) {
  std::bitset<256> is_used;
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    bool is_held = true;
    for (const int node : mesh.tetrahedra.col(t)) {
      is_held &= mesh.fixed_nodes[static_cast<std::size_t>(node)] != 0;
    }
    if (!is_held) is_used.set(mesh.tissue[static_cast<std::size_t>(t)]);
  }
  std::vector<double> rows;
  for (int label = 0; label < 256; ++label) {
    if (!is_used[static_cast<std::size_t>(label)]) continue;
    const ElasticTissue& tissue = table.SolidAt(static_cast<volume::Label>(label));
    rows.insert(rows.end(),
                {static_cast<double>(label), tissue.youngs_modulus_mpa, tissue.poissons_ratio});
  }
  for (const Membrane& membrane : table.membranes) {
    if (!is_used[membrane.tissue]) continue;
    rows.insert(rows.end(),
                {static_cast<double>(membrane.tissue), membrane.youngs_modulus_mpa,
                 membrane.poissons_ratio, membrane.thickness_mm, membrane.tension_n_per_mm});
    for (std::size_t beyond = 0; beyond < 256; ++beyond) {
      rows.push_back(membrane.against.test(beyond) ? 1.0 : 0.0);
    }
  }
  core::ByteWriter out(mesh::kPackedOrder);
  out.Array(std::span<const double>(rows));
  return Sha256OfText(out.AsString());
}

}  // namespace

ComplianceKey KeyOf(const mesh::TetraMesh& mesh, const ElasticityTable& elasticity,
                    ElementKind element) {
  ACUS_REQUIRE(mesh.tissue.size() == static_cast<std::size_t>(mesh.tetrahedra.cols()),
               "the mesh has no tissue ids (cell data \"tissue\"), so that its stiffness is not "
               "known; mesh the label map with acus-mesh");
  ACUS_ASSERT(mesh.fixed_nodes.size() == static_cast<std::size_t>(mesh.nodes_mm.cols()));
  return {HashOf(mesh), HashOf(elasticity, mesh), std::string(ElementName(element))};
}

}  // namespace acus::mechanics
