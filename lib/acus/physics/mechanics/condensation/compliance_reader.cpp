// The reading half of compliance_file.h.
#include <algorithm>
#include <bit>
#include <memory>
#include <vector>

#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/mechanics/condensation/compliance_layout.h"
#include "acus/physics/mechanics/condensation/mapped_file.h"

namespace acus::mechanics {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

std::string Remedy(const fs::path& path) {
  const fs::path mesh = path.parent_path() / "mesh.vtu";
  return Message("; make it again: acus-mesh --mesh ", mesh.string(),
                 " --condense --corridor-from X,Y,Z --corridor-to X,Y,Z -o FOLDER");
}

template <std::size_t N>
std::string Text(const char (&field)[N]) {
  return {field, std::find(field, field + N, '\0')};
}

ComplianceHeader ReadHeader(const fs::path& path, const MappedFile& file) {
  const std::string name = path.string();
  ComplianceHeader header;
  const bool is_ours = file.size() >= sizeof header.magic &&
                       std::memcmp(file.data(), kComplianceMagic, sizeof kComplianceMagic) == 0;
  ACUS_REQUIRE(is_ours, name, ": is not a compliance file of acus-mesh", Remedy(path));
  ACUS_REQUIRE(file.size() >= kPageBytes, name, ": is cut off after ", file.size(), " bytes",
               Remedy(path));
  std::memcpy(&header, file.data(), sizeof header);
  ACUS_REQUIRE(header.byte_order != kOtherByteOrder, name,
               ": was written on a machine with the other byte order", Remedy(path));
  ACUS_REQUIRE(header.byte_order == kByteOrder, name, ": its header is damaged", Remedy(path));
  ACUS_REQUIRE(header.version == kComplianceVersion, name, ": has format version ", header.version,
               "; this program reads version ", kComplianceVersion, Remedy(path));
  std::vector<char> page(kPageBytes);
  std::memcpy(page.data(), file.data(), kPageBytes);
  ComplianceHeader unsigned_header = header;
  unsigned_header.header_check = 0;
  std::memcpy(page.data(), &unsigned_header, sizeof unsigned_header);
  const bool is_sound = Checksum(page.data(), kPageBytes) == header.header_check &&
                        header.num_nodes > 0 && header.num_nodes <= kMostNodes &&
                        header.num_visible <= kMostNodes &&
                        (header.value_bytes == 4 || header.value_bytes == 8);
  ACUS_REQUIRE(is_sound, name, ": its header is damaged", Remedy(path));
  return header;
}

void RequireSame(const fs::path& path, const ComplianceHeader& header, const mesh::TetraMesh& mesh,
                 const ComplianceKey& key) {
  const std::string name = path.string();
  const bool is_same_mesh =
      Text(header.mesh_sha256) == key.mesh_sha256 &&
      header.num_mesh_nodes == static_cast<std::uint64_t>(mesh.nodes_mm.cols());
  ACUS_REQUIRE(is_same_mesh, name, ": was made for another mesh, of ", header.num_mesh_nodes,
               " nodes; the mesh in use has ", mesh.nodes_mm.cols(),
               header.num_mesh_nodes == mesh.nodes_mm.cols()
                   ? " but differs in place, connection, tissue or fixed flags"
                   : "",
               Remedy(path));
  ACUS_REQUIRE(Text(header.element) == key.element, name, ": was made with the element \"",
               Text(header.element), "\"; \"", key.element, "\" is required", Remedy(path));
  ACUS_REQUIRE(
      Text(header.elasticity_sha256) == key.elasticity_sha256, name,
      ": was made with other elastic constants for the tissues of this mesh (another table, "
      "or another stiffness_seed)",
      Remedy(path));
}

std::vector<int> ReadNodes(const fs::path& path, const std::byte* at, std::uint64_t count,
                           std::uint64_t num_mesh_nodes) {
  std::vector<int> nodes(count);
  if (count > 0) std::memcpy(nodes.data(), at, count * sizeof(int));
  const bool is_sound =
      nodes.empty() ||
      (std::ranges::adjacent_find(nodes, std::greater_equal<>{}) == nodes.end() &&
       nodes.front() >= 0 && static_cast<std::uint64_t>(nodes.back()) < num_mesh_nodes);
  ACUS_REQUIRE(is_sound, path.string(), ": its list of nodes is damaged", Remedy(path));
  return nodes;
}

void CheckPieces(const fs::path& path, const std::byte* at, std::uint64_t size,
                 const std::byte* checks) {
  for (std::uint64_t done = 0; done < size; done += kPieceBytes, checks += sizeof(std::uint64_t)) {
    std::uint64_t stored = 0;
    std::memcpy(&stored, checks, sizeof stored);
    ACUS_REQUIRE(Checksum(at + done, std::min(kPieceBytes, size - done)) == stored, path.string(),
                 ": its numbers are damaged", Remedy(path));
  }
}

}  // namespace

CondensedTissue OpenCompliance(const fs::path& path, const mesh::TetraMesh& mesh,
                               const ElasticityTable& elasticity, ElementKind element,
                               ComplianceCheck check) {
  ACUS_REQUIRE(fs::exists(path), path.string(),
               ": there is no such file; tissue of 3D finite elements needs it", Remedy(path));
  ACUS_REQUIRE(!fs::is_regular_file(path) || fs::file_size(path) > 0, path.string(), ": is empty",
               Remedy(path));
  const auto file = std::make_shared<const MappedFile>(path);
  const ComplianceHeader header = ReadHeader(path, *file);
  const ComplianceLayout layout(header.num_nodes, header.num_visible, header.value_bytes);
  ACUS_REQUIRE(header.file_bytes == layout.file_bytes, path.string(), ": its header is damaged",
               Remedy(path));
  ACUS_REQUIRE(file->size() == layout.file_bytes, path.string(), ": has ", file->size(),
               " bytes instead of ", layout.file_bytes, ": it was cut off or joined", Remedy(path));
  RequireSame(path, header, mesh, KeyOf(mesh, elasticity, element));
  const std::byte* data = file->data();
  ACUS_REQUIRE(
      Checksum(data + kPageBytes, layout.compliance_at - kPageBytes) == header.tables_check,
      path.string(), ": its tables are damaged", Remedy(path));
  std::vector<int> nodes =
      ReadNodes(path, data + layout.nodes_at, header.num_nodes, header.num_mesh_nodes);
  std::vector<int> visible =
      ReadNodes(path, data + layout.visible_at, header.num_visible, header.num_mesh_nodes);
  const std::byte* checks = data + layout.checks_at;
  if (check != ComplianceCheck::kNothing) {
    CheckPieces(path, data + layout.compliance_at, layout.compliance_bytes, checks);
  }
  if (check == ComplianceCheck::kEverything) {
    CheckPieces(path, data + layout.image_at, layout.image_bytes,
                checks + layout.num_compliance_pieces * sizeof(std::uint64_t));
  }
  const Storage storage = header.value_bytes == 4 ? Storage::kFloat : Storage::kDouble;
  CondensedTissue out;
  out.compliance = Compliance(std::move(nodes), storage, data + layout.compliance_at, file);
  if (!visible.empty()) {
    out.image = ImageBlock(std::move(visible),
                           reinterpret_cast<const float*>(data + layout.image_at), file);
  }
  return out;
}

}  // namespace acus::mechanics
