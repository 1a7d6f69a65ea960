// Time, memory and file size of condensation against nodes and reachable nodes.
// Run: build/tests/bench_condensation [CELLS REACHABLE IMAGE_RADIUS_MM]; without arguments the
// table of docs/models/tissue_condensation.md, one child process for each row, so that peaks are
// its own.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "acus/base/core/cpu_time.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "acus/physics/mechanics/elements/element_names.h"
#include "support/box_mesh.h"

namespace acus::mechanics {
namespace {

/// The nodes nearest to a needle's way that goes straight down to the middle of the box.
std::vector<int> Nearest(const mesh::TetraMesh& mesh, const FreeNodes& free, double side_mm,
                         std::size_t count) {
  const auto distance = [&](int node) {
    Eigen::Vector3d x = mesh.nodes_mm.col(node) - Eigen::Vector3d::Constant(0.5 * side_mm);
    x.z() = std::min(x.z(), 0.0);
    return x.norm();
  };
  std::vector<int> nodes = free.mesh_node;
  std::ranges::stable_sort(nodes, {}, distance);
  nodes.resize(std::min(count, nodes.size()));
  std::ranges::sort(nodes);
  return nodes;
}

void Measure(int cells, std::size_t num_reachable, double image_radius_mm,
             const std::string& element_name) {
  const ElementKind element = ElementNamed(element_name, "element");
  const double side_mm = 4.0 * cells;
  mesh::TetraMesh mesh =
      testing_support::BoxMesh(Eigen::Vector3i::Constant(cells), Eigen::Vector3d::Zero(),
                               Eigen::Vector3d::Constant(side_mm), 0.15);
  testing_support::Fix(mesh, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  ElasticityTable table;
  table.tissue[4] = {0.005, 0.45};
  table.named.set(4);
  const RunContext context;
  const double begin_s = ThreadCpuSeconds();
  const FreeNodes free = FindFreeNodes(mesh);
  const std::vector<int> reachable = Nearest(mesh, free, side_mm, num_reachable);
  const Eigen::Vector3d middle = Eigen::Vector3d::Constant(0.5 * side_mm);
  const std::vector<int> visible =
      image_radius_mm > 0.0
          ? Joined(reachable,
                   NodesInside(mesh, free,
                               {middle, middle + Eigen::Vector3d(0, 0, side_mm), image_radius_mm}))
          : std::vector<int>{};
  Condensation condensation(mesh, free, table, element, reachable, kDefaultMemoryMib, context);
  const auto path =
      std::filesystem::temp_directory_path() / ("acus_bench_" + std::to_string(cells) + ".acc");
  const ComplianceFileCost file =
      WriteCompliance(path, condensation, KeyOf(mesh, table, element), mesh.nodes_mm.cols(),
                      visible, Storage::kDouble, context);
  const double total_s = ThreadCpuSeconds() - begin_s;
  const double open_s = -ThreadCpuSeconds();
  OpenCompliance(path, mesh, table, element);
  const double opened_s = open_s + ThreadCpuSeconds();
  std::filesystem::remove(path);
  std::printf(
      "| %s | %td | %td | %zu | %zu | %.1f | %.1f | %.1f | %.1f | %.0f | %.0f | %.0f | %.0f | %.2f "
      "|\n",
      element_name.c_str(), mesh.nodes_mm.cols(), mesh.tetrahedra.cols(), reachable.size(),
      visible.size(), total_s - file.image_s, condensation.cost().assemble_s,
      condensation.cost().factor_s, file.image_s, condensation.cost().factor_mib, PeakMemoryMib(),
      file.compliance_mib, file.image_mib, opened_s);
  std::fflush(stdout);
}

}  // namespace
}  // namespace acus::mechanics

int main(int argc, char** argv) {
  if (argc > 3) {
    acus::mechanics::Measure(std::atoi(argv[1]), static_cast<std::size_t>(std::atoi(argv[2])),
                             std::atof(argv[3]), argc > 4 ? argv[4] : "averaged_dilatation");
    return 0;
  }
  std::puts(
      "| element | nodes | tetrahedra | reachable | visible | condense, s | of it assemble | "
      "factor "
      "and invert | image block, s | factor, MiB | peak, MiB | compliance, MiB | image, MiB | "
      "open, s |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
  std::fflush(stdout);
  for (const char* row :
       {"21 300 0", "30 1000 0", "38 300 0", "38 1000 0", "38 1000 24", "38 5000 0", "48 1000 0"}) {
    if (std::system((std::string(argv[0]) + " " + row).c_str()) != 0) return 1;
  }
  return 0;
}
