// The writing half of compliance_file.h.
#include <algorithm>
#include <fstream>
#include <vector>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/provenance.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/mechanics/condensation/compliance_layout.h"

namespace acus::mechanics {
namespace {

constexpr int kColumnsAtOnce = 256;  ///< Enough for dense kernels, few enough for little memory.

/// Writes one of the matrices and collects the checksum of each piece of it.
class PieceWriter {
 public:
  PieceWriter(std::ofstream& out, std::vector<std::uint64_t>& checks) : out_(out), checks_(checks) {
    piece_.reserve(kPieceBytes);
  }

  void Add(const void* bytes, std::size_t size) {
    const char* at = static_cast<const char*>(bytes);
    while (size > 0) {
      const std::size_t part = std::min(size, kPieceBytes - piece_.size());
      piece_.insert(piece_.end(), at, at + part);
      at += part;
      size -= part;
      if (piece_.size() == kPieceBytes) Flush();
    }
  }

  void Flush() {
    if (piece_.empty()) return;
    checks_.push_back(Checksum(piece_.data(), piece_.size()));
    out_.write(piece_.data(), static_cast<std::streamsize>(piece_.size()));
    piece_.clear();
  }

 private:
  std::ofstream& out_;
  std::vector<std::uint64_t>& checks_;
  std::vector<char> piece_;
};

template <std::size_t N>
void Fill(char (&field)[N], const std::string& text) {
  ACUS_ASSERT(text.size() <= N);
  std::ranges::copy(text, field);
}

std::string KeyText(const ComplianceKey& key, std::span<const int> nodes,
                    std::span<const int> visible, std::uint32_t value_bytes) {
  std::string text = Message("acus-compliance/", kComplianceVersion, " ", key.mesh_sha256, " ",
                             key.elasticity_sha256, " ", key.element, " ", value_bytes);
  for (const int node : nodes) text += " " + std::to_string(node);
  text += " visible";
  for (const int node : visible) text += " " + std::to_string(node);
  return text;
}

void WriteMatrix(const Condensation& condensation, Storage storage, const RunContext& context,
                 PieceWriter& writer) {
  const int size = 3 * static_cast<int>(condensation.nodes().size());
  std::vector<float> rounded;
  for (int dof = 0; dof < size; ++dof) {
    if (dof % (size / 20 + 1) == 0) {
      context.Checkpoint("writing the compliance", 0.7 + 0.05 * dof / size);
    }
    const std::span<const double> column = condensation.ColumnMmPerN(dof);
    if (storage == Storage::kDouble) {
      writer.Add(column.data(), column.size_bytes());
    } else {
      rounded.assign(column.begin(), column.end());
      writer.Add(rounded.data(), rounded.size() * sizeof(float));
    }
  }
  writer.Flush();
}

/// @returns the CPU time of solving.
double WriteImage(Condensation& condensation, std::span<const int> visible,
                  const RunContext& context, PieceWriter& writer) {
  if (visible.empty()) return 0.0;
  double solve_s = -ThreadCpuSeconds();
  condensation.SetVisible(visible);
  solve_s += ThreadCpuSeconds();
  const int size = 3 * static_cast<int>(condensation.nodes().size());
  std::vector<float> columns(3 * visible.size() * kColumnsAtOnce);
  for (int first = 0; first < size; first += kColumnsAtOnce) {
    context.Checkpoint("solving for the image", 0.75 + 0.25 * first / size);
    const int count = std::min(kColumnsAtOnce, size - first);
    const double begin_s = ThreadCpuSeconds();
    condensation.ImageColumns(first, count, columns.data());
    solve_s += ThreadCpuSeconds() - begin_s;
    writer.Add(columns.data(), 3 * visible.size() * sizeof(float) * count);
  }
  writer.Flush();
  return solve_s;
}

void PadTo(std::ofstream& out, std::uint64_t at) {
  const std::string zeros(at - static_cast<std::uint64_t>(out.tellp()), '\0');
  out.write(zeros.data(), static_cast<std::streamsize>(zeros.size()));
}

/// The first pages: header and tables.
std::vector<char> FirstPages(ComplianceHeader header, const ComplianceLayout& layout,
                             std::span<const int> nodes, std::span<const int> visible,
                             std::span<const std::uint64_t> checks) {
  ACUS_ASSERT(checks.size() == layout.num_compliance_pieces + layout.num_image_pieces);
  std::vector<char> pages(layout.compliance_at, 0);
  std::memcpy(pages.data() + layout.nodes_at, nodes.data(), nodes.size_bytes());
  if (!visible.empty()) {
    std::memcpy(pages.data() + layout.visible_at, visible.data(), visible.size_bytes());
  }
  std::memcpy(pages.data() + layout.checks_at, checks.data(), checks.size_bytes());
  header.tables_check = Checksum(pages.data() + kPageBytes, pages.size() - kPageBytes);
  std::memcpy(pages.data(), &header, sizeof header);
  header.header_check = Checksum(pages.data(), kPageBytes);
  std::memcpy(pages.data(), &header, sizeof header);
  return pages;
}

}  // namespace

ComplianceFileCost WriteCompliance(const std::filesystem::path& path, Condensation& condensation,
                                   const ComplianceKey& key, Eigen::Index num_mesh_nodes,
                                   std::span<const int> visible, Storage storage,
                                   const RunContext& context) {
  const double begin_s = ThreadCpuSeconds();
  const std::span<const int> nodes = condensation.nodes();
  ACUS_ASSERT(std::ranges::is_sorted(visible) && num_mesh_nodes <= kMostNodes);
  ComplianceHeader header{};
  std::ranges::copy(kComplianceMagic, header.magic);
  header.byte_order = kByteOrder;
  header.version = kComplianceVersion;
  header.num_nodes = static_cast<std::uint32_t>(nodes.size());
  header.num_visible = static_cast<std::uint32_t>(visible.size());
  header.num_mesh_nodes = static_cast<std::uint32_t>(num_mesh_nodes);
  header.value_bytes = storage == Storage::kFloat ? 4 : 8;
  const ComplianceLayout layout(nodes.size(), visible.size(), header.value_bytes);
  header.file_bytes = layout.file_bytes;
  Fill(header.element, key.element);
  Fill(header.mesh_sha256, key.mesh_sha256);
  Fill(header.elasticity_sha256, key.elasticity_sha256);
  ComplianceFileCost cost;
  cost.key = Sha256OfText(KeyText(key, nodes, visible, header.value_bytes));
  Fill(header.key, cost.key);

  AtomicFile file(path);
  std::ofstream out(file.path(), std::ios::binary);
  PadTo(out, layout.compliance_at);
  std::vector<std::uint64_t> checks;
  PieceWriter writer(out, checks);
  WriteMatrix(condensation, storage, context, writer);
  PadTo(out, layout.image_at);
  cost.image_s = WriteImage(condensation, visible, context, writer);
  const std::vector<char> pages = FirstPages(header, layout, nodes, visible, checks);
  out.seekp(0);
  out.write(pages.data(), static_cast<std::streamsize>(pages.size()));
  out.close();
  ACUS_REQUIRE(out, path.string(), ": cannot be written; it needs ",
               layout.file_bytes / (1024 * 1024) + 1, " MiB, is the disk full?");
  file.Commit();
  cost.compliance_mib = static_cast<double>(layout.compliance_bytes) / (1024.0 * 1024.0);
  cost.image_mib = static_cast<double>(layout.image_bytes) / (1024.0 * 1024.0);
  cost.write_s = ThreadCpuSeconds() - begin_s - cost.image_s;
  return cost;
}

}  // namespace acus::mechanics
