// How deep the skin of the layered block is pressed in before it gives way, by the linear law and
// by laws that stiffen; and what size of the region and iterations per step cost and bring. Run:
// build/tests/bench_strain [ELEMENT_MM]. Table: docs/models/tissue_finite_strain.md.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "acus/physics/tissue/needle_contact.h"
#include "benchmarks/tissue_block.h"
#include "references/finite_strain.h"

namespace acus::benchmarks {
namespace {

constexpr double kReachMm = 14.0;
constexpr double kDepthMm = 60.0;

using mechanics::HyperelasticLaw;

struct Case {
  const char* name;
  double exponent_share;  ///< Of the presets' exponents b; 0: neo_hookean.
  int nodes;              ///< 0: linear.
  int iterations;
  double speed_mm_per_s;
  HyperelasticLaw of_all{};  ///< Of every tissue, in place of the presets; neo_hookean: none.
};

/// As brain cortex in several modes, and as meat, with fibres across the needle.
const HyperelasticLaw kOgden{.kind = mechanics::LawKind::kOgden, .ogden = {{{1.0, -18.8}}}};
const HyperelasticLaw kFibres{.kind = mechanics::LawKind::kKnowles,
                              .exponent_b = 1028.0,
                              .power_n = 0.80,
                              .fibres = {3.2e-3, 0.0, Eigen::Vector3d::UnitX()}};

struct Block {
  mesh::TetraMesh mesh;
  TissueBlockTables tables;
  mechanics::Compliance compliance;

  explicit Block(double element_mm)
      : mesh(TissueBlock::Mesh(element_mm)), tables([] {
          Provenance provenance;
          TissueBlockTables presets = TissueBlockTables::FromPresets(provenance);
          // The static solver has no shells: the solids are whole.
          presets.elasticity.membranes.clear();
          presets.elasticity.has_beneath.reset();
          return presets;
        }()) {
    const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
    const mechanics::Condensation condensation(
        mesh, free, tables.elasticity, mechanics::ElementKind::kAveragedDilatation,
        mechanics::CorridorNodes(mesh, free, Corridor()), mechanics::kDefaultMemoryMib, {});
    compliance = condensation.Compliance(mechanics::Storage::kFloat);
  }
  static mechanics::Capsule Corridor() { return {{0, 0, 1}, {0, 0, -kDepthMm}, kReachMm}; }

  mechanics::ElasticityTable Elasticity(double exponent_share,
                                        const HyperelasticLaw& of_all = {}) const {
    mechanics::ElasticityTable table = tables.elasticity;
    if (of_all != HyperelasticLaw{}) {
      table.law.fill(of_all);
      return table;
    }
    for (HyperelasticLaw& law : table.law) {
      law.exponent_b *= exponent_share;
      if (law.exponent_b == 0.0) law = {};
    }
    return table;
  }

  tissue::FemNeedleModel Model(const Case& c) const {
    tissue::FemContactSettings settings{.contact_spacing_mm = 2.0};
    if (c.nodes > 0) {
      settings.strain.emplace();
      settings.strain->corridor = {{0, 0, 1}, {0, 0, -kDepthMm}, 8.0};
      settings.strain->max_nodes = c.nodes;
      settings.strain->iterations = c.iterations;
    }
    return {mesh,          compliance,    Elasticity(c.exponent_share, c.of_all),
            tables.forces, tables.needle, settings};
  }
};

void Insert(const Block& block, const Case& c) {
  const tissue::FemNeedleModel model = block.Model(c);
  tissue::FemNeedleState state = model.NewState();
  std::vector<double> step_us, error_mm;
  double punctured_mm = 0.0, time_s = 0.0, largest_n = 0.0;
  for (double depth_mm = -2.0; depth_mm < 58.0; depth_mm += 1e-3 * c.speed_mm_per_s) {
    tissue::ToolSample sample;
    sample.time_s = time_s += 1e-3;
    sample.tip_in_ct_mm = {0.3, -0.7, -depth_mm};
    sample.axis_in_ct = -Eigen::Vector3d::UnitZ();
    const double begin_s = ThreadCpuSeconds();
    const forces::NeedleForce force = model.Step(state, sample);
    step_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
    error_mm.push_back(state.strain.error_mm);
    largest_n = std::max(largest_n, force.force_in_ct_n.norm());
    if (punctured_mm == 0.0 && force.event == forces::NeedleEvent::kPuncture) {
      punctured_mm = depth_mm;
    }
  }
  std::printf("%-22s %5d %4d %6.0f %9.2f %9.1f %9.1f %9.0e %9.0e %8.3f\n", c.name, c.nodes,
              c.iterations, c.speed_mm_per_s, punctured_mm, math::Median(step_us),
              math::Quantile(step_us, 0.999), math::Median(error_mm),
              math::Quantile(error_mm, 0.99), largest_n);
  std::fflush(stdout);
}

/// The whole block at large strain: where the tip is when the skin bears what pierces it.
void WholeBlock(const Block& block, double exponent_share) {
  const tissue::FemNeedleModel model = block.Model({"", 0.0, 0, 1, 0.0});
  tissue::FemNeedleState state = model.NewState();
  tissue::ToolSample sample;
  sample.axis_in_ct = -Eigen::Vector3d::UnitZ();
  for (double depth_mm = -2.0; depth_mm < 2.0; depth_mm += 0.1) {
    sample.time_s += 1e-3;
    sample.tip_in_ct_mm = {0.3, -0.7, -depth_mm};
    model.Step(state, sample);
  }
  const tissue::ContactPlace& place = state.contact.slot_place(0);
  const double limit_n = state.contact.HighN(0);
  mechanics::FiniteStrainSolver solver(block.mesh, block.Elasticity(exponent_share),
                                       mechanics::ElementKind::kAveragedDilatation);
  Eigen::Matrix3Xd u;
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Zero(3, block.mesh.nodes_mm.cols());
    for (int r = 0; r < place.num_rows; ++r) {
      load(2, block.compliance.nodes()[place.row[r]]) = -share * limit_n * place.weight[r];
    }
    u = solver.Solve(load, {}, u).displacement_mm;
  }
  double moved_mm = state.contact.slot_local_mm_per_n(0) * limit_n;
  for (int r = 0; r < place.num_rows; ++r) {
    moved_mm -= place.weight[r] * u(2, block.compliance.nodes()[place.row[r]]);
  }
  std::printf("whole block, static, exponents times %.0f: %.2f mm\n", exponent_share, moved_mm);
  std::fflush(stdout);
}

int Measure(double element_mm) {
  const Block block(element_mm);
  std::printf("%d nodes, %d reachable\n", static_cast<int>(block.mesh.nodes_mm.cols()),
              block.compliance.num_nodes());
  std::printf(
      "law                    nodes iter   mm/s  puncture  median_us  p999_us  error_mm  "
      "p99_mm largest_n\n");
  for (const Case& c : std::vector<Case>{{"linear", 0.0, 0, 3, 20.0},
                                         {"neo_hookean", 0.0, 160, 3, 20.0},
                                         {"presets", 1.0, 160, 3, 20.0},
                                         {"exponents times 4", 4.0, 160, 3, 20.0},
                                         {"presets", 1.0, 160, 3, 200.0},
                                         {"presets", 1.0, 40, 3, 20.0},
                                         {"presets", 1.0, 80, 3, 20.0},
                                         {"presets", 1.0, 240, 3, 20.0},
                                         {"presets", 1.0, 400, 3, 20.0},
                                         {"presets", 1.0, 160, 1, 20.0},
                                         {"presets", 1.0, 160, 2, 20.0},
                                         {"presets", 1.0, 160, 6, 20.0},
                                         {"presets", 1.0, 160, 30, 20.0},
                                         {"ogden, exponent -18.8", 0.0, 160, 3, 20.0, kOgden},
                                         {"knowles with fibres", 0.0, 160, 3, 20.0, kFibres}}) {
    Insert(block, c);
  }
  for (const double share : {0.0, 1.0, 4.0}) WholeBlock(block, share);
  return 0;
}

}  // namespace
}  // namespace acus::benchmarks

int main(int argc, char** argv) {
  return acus::benchmarks::Measure(argc > 1 ? std::atof(argv[1]) : 4.0);
}
