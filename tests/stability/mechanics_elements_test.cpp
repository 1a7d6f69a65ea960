// Hard cases of meshes and constants: the answer is right, bounded, or a clear error.
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "references/static_solver.h"
#include "support/bound.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

const char* MechanicsElementsNameOf(ElementKind kind) {
  return kind == ElementKind::kLinear ? "linear" : "averaged";
}

/// Inner displacements of a block whose surface is moved as by a constant strain, against that
/// strain, as a share of it: the patch test.
double PatchError(mesh::TetraMesh mesh, const ElasticityTable& table, ElementKind kind) {
  FixSurface(mesh);
  Eigen::Matrix3d gradient;
  gradient << 0.03, 0.02, -0.01, 0.01, -0.02, 0.04, -0.02, 0.03, 0.01;
  const Eigen::Matrix3Xd exact = gradient * mesh.nodes_mm;
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, exact.cols());
  const Eigen::Matrix3Xd u = StaticSolver(mesh, table, kind).Displacements(none, exact);
  return (u - exact).norm() / exact.norm();
}

/// The node nearest to a place.
Eigen::Index NodeAt(const mesh::TetraMesh& mesh, const Eigen::Vector3d& x_mm) {
  Eigen::Index at = 0;
  (mesh.nodes_mm.colwise() - x_mm).colwise().norm().minCoeff(&at);
  return at;
}

/// Moves a node of the 10 mm lattice of a box towards the face across one of its tetrahedra, until
/// the flattest tetrahedron there has `share` of the height that it had.
void Flatten(mesh::TetraMesh& mesh, const Eigen::Vector3d& place_mm, double share) {
  const Eigen::Index node = NodeAt(mesh, place_mm);
  mesh.nodes_mm.col(node).x() -= 10.0 * (1.0 - share);
}

TEST(MechanicsStability, SliversKeepThePatchTest) {
  const HardCase hard(
      "Tetrahedra flattened to a ten-millionth of their height still reproduce a constant strain.");
  BoundPlot plot{.title = "Patch test with flattened tetrahedra",
                 .x_label = "height left, as a share",
                 .y_label = "error, as a share of the strain",
                 .log_x = true,
                 .log_y = true};
  for (const ElementKind kind : kBothElements) {
    plot.curves.push_back({.name = MechanicsElementsNameOf(kind)});
    for (const double share : {1e-1, 1e-3, 1e-5, 1e-7}) {
      mesh::TetraMesh box = BoxMesh({5, 5, 5}, {0, 0, 0}, {50, 50, 50});
      Flatten(box, {20, 20, 20}, share);
      Flatten(box, {40, 30, 20}, share);
      const double error = PatchError(box, UniformTable(0.01, 0.49), kind);
      // Round-off grows as elements get flat: their gradients are differences over a small height.
      hard.Expect(Message("error of strain, ", MechanicsElementsNameOf(kind), ", height ", share),
                  error, Below(std::max(1e-10, 1e-15 / share)));
      plot.curves.back().Add(share, error);
    }
  }
  hard.Plot(plot);
}

/// Moves an inner node to the middle of the face across one of its tetrahedra, but for `share` of
/// the way: a sliver, flat although its edges are long.
void MakeSliver(mesh::TetraMesh& mesh, const Eigen::Vector3d& place_mm, double share) {
  const auto node = static_cast<int>(NodeAt(mesh, place_mm));
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const Eigen::Vector4i corners = mesh.tetrahedra.col(t);
    if ((corners.array() != node).all()) continue;
    Eigen::Vector3d middle = -mesh.nodes_mm.col(node);
    for (const int corner : corners) middle += mesh.nodes_mm.col(corner);
    middle /= 3.0;
    mesh.nodes_mm.col(node) = middle + share * (mesh.nodes_mm.col(node) - middle);
    return;
  }
}

TEST(MechanicsStability, FlatTetrahedraWithLongEdgesKeepThePatchTest) {
  const HardCase hard("Slivers, flat although their edges are long, reproduce a constant strain.");
  for (const ElementKind kind : kBothElements) {
    for (const double share : {1e-2, 1e-4, 1e-7}) {
      mesh::TetraMesh box = BoxMesh({5, 5, 5}, {0, 0, 0}, {50, 50, 50});
      MakeSliver(box, {20, 20, 20}, share);
      MakeSliver(box, {40, 30, 20}, share);
      hard.Expect(Message("error of strain, ", MechanicsElementsNameOf(kind), ", height ", share),
                  PatchError(box, UniformTable(0.01, 0.49), kind),
                  Below(std::max(1e-10, 1e-15 / share)));
    }
  }
}

TEST(MechanicsStability, SliversHardlyChangeWhatALoadDoes) {
  const HardCase hard("One sliver in a regular mesh must not change what a load does.");
  mesh::TetraMesh box = BoxMesh({6, 6, 6}, {0, 0, 0}, {60, 60, 60});
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  const auto on_top = [](const Eigen::Vector3d& x) { return x.z() == 60.0; };
  const auto push = [](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, -1e-4); };
  for (const ElementKind kind : kBothElements) {
    const ElasticityTable table = UniformTable(0.01, 0.45);
    const Eigen::Matrix3Xd load = TractionLoad(box, on_top, push);
    const double regular =
        load.cwiseProduct(StaticSolver(box, table, kind).Displacements(load)).sum();
    for (const double share : {1e-2, 1e-4, 1e-6}) {
      mesh::TetraMesh flat = box;
      Flatten(flat, {30, 30, 30}, share);
      const Eigen::Matrix3Xd u = StaticSolver(flat, table, kind).Displacements(load);
      EXPECT_TRUE(u.allFinite());
      // A flat element is stiff in one way only: the body gets stiffer, by less than 5 %.
      const double work = load.cwiseProduct(u).sum();
      hard.Expect(
          Message("change of the load's work, ", MechanicsElementsNameOf(kind), ", height ", share),
          std::abs(work / regular - 1.0), Below(0.05));
    }
  }
}

TEST(MechanicsStability, FlatAndInvertedElementsAreRefusedWithTheirPlace) {
  const HardCase hard("Flat and inverted tetrahedra have no answer: an error says where they are.");
  int num_refused = 0;
  for (const double share : {1e-14, 0.0, -0.5}) {
    mesh::TetraMesh box = BoxMesh({5, 5, 5}, {0, 0, 0}, {50, 50, 50});
    Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
    Flatten(box, {20, 20, 20}, share);
    for (const ElementKind kind : kBothElements) {
      EXPECT_THAT(([&] { StaticSolver(box, UniformTable(0.01, 0.45), kind); }),
                  ThrowsMessage<InputError>(
                      AllOf(HasSubstr("tetrahedron "), HasSubstr(") mm"), HasSubstr("flat"))))
          << share;
      num_refused += HasFailure() ? 0 : 1;
    }
  }
  hard.Expect("meshes refused with the place of the element", num_refused, Exactly(6));
}

TEST(MechanicsStability, StiffnessContrastOf1000KeepsTheLoadsBalance) {
  const HardCase hard(
      "Cells of 3 kPa and 3 MPa, mixed: round-off of the stiff ones is large in the soft.");
  mesh::TetraMesh box = BoxMesh({8, 8, 8}, {0, 0, 0}, {40, 40, 40}, 0.17);
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    box.tissue[t] = static_cast<std::uint8_t>(1 + t / 6 % 2);  // Cells of both, mixed.
  }
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(2e-5, 0, -1e-4); });
  for (const ElementKind kind : kBothElements) {
    ElasticityTable table = UniformTable(0.003, 0.49);
    const double soft = load.cwiseProduct(StaticSolver(box, table, kind).Displacements(load)).sum();
    table.tissue[2] = {3.0, 0.49};
    const StaticSolver solver(box, table, kind);
    const Eigen::Matrix3Xd u = solver.Displacements(load);
    const double mixed = load.cwiseProduct(u).sum();
    // Between a block of the soft one and one of the stiff one.
    const std::string of = Message(", ", MechanicsElementsNameOf(kind));
    hard.Expect("work as a share of the soft block's" + of, mixed / soft, Below(1.0));
    hard.Expect("least work as a share of the soft block's" + of, mixed / soft, Above(1e-3));
    const Eigen::Matrix3Xd forces_n = solver.Forces(u);
    double residual_n = 0.0;
    for (const int node : solver.free().mesh_node) {
      residual_n = std::max(residual_n, (forces_n - load).col(node).norm());
    }
    hard.Expect("force left on a free node" + of, residual_n,
                Below(1e-11 * load.colwise().norm().maxCoeff() * 1000.0), "N");
    hard.Expect("sum of all forces, as a share of the load" + of,
                forces_n.rowwise().sum().norm() / load.rowwise().sum().norm(), Below(1e-9));
  }
}

TEST(MechanicsStability, ContrastOf1000KeepsThePatchTestLayerByLayer) {
  const HardCase hard("A layer of 3 MPa on one of 3 kPa: each has its own constant strain.");
  mesh::TetraMesh box = BoxMesh({4, 4, 8}, {0, 0, 0}, {20, 20, 40});
  ElasticityTable table = UniformTable(0.003, 0.49);
  table.tissue[2] = {3.0, 0.49};
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    const mesh::Corners c = mesh::CornersOf(box, static_cast<int>(t));
    box.tissue[t] = (c[0] + c[1] + c[2] + c[3]).z() < 80.0 ? 1 : 2;
  }
  FixSurface(box);
  const Eigen::Matrix3Xd exact = AtNodes(box, [](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(0, 0, std::min(x.z(), 20.0) + std::max(x.z() - 20.0, 0.0) / 1000.0);
  });
  for (const ElementKind kind : kBothElements) {
    const Eigen::Matrix3Xd u = StaticSolver(box, table, kind)
                                   .Displacements(Eigen::Matrix3Xd::Zero(3, exact.cols()), exact);
    hard.Expect(Message("error of displacement, ", MechanicsElementsNameOf(kind)),
                (u - exact).norm() / exact.norm(), Below(1e-10));
  }
}

TEST(MechanicsStability, PoissonsRatioUpToTheLimitStaysBoundedAndSolvable) {
  const HardCase hard("Tissue hardly changes its volume: near nu = 0.5 elements lock or blow up.");
  BoundPlot plot{.title = "Work of one load as tissue gets incompressible",
                 .x_label = "0.5 - nu",
                 .y_label = "work [N mm]",
                 .log_x = true};
  plot.curves = {{.name = "averaged dilatation"}, {.name = "linear: locks"}};
  mesh::TetraMesh box = BoxMesh({8, 8, 8}, {0, 0, 0}, {40, 40, 40}, 0.17);
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d& x) { return Eigen::Vector3d(0, 0, x.x() < 20.0 ? -1e-4 : 0.0); });
  double before = 1e300;
  for (const double nu : {0.0, 0.3, 0.45, 0.49, 0.499, 0.4999}) {
    const Eigen::Matrix3Xd u =
        StaticSolver(box, UniformTable(0.01, nu), ElementKind::kAveragedDilatation)
            .Displacements(load);
    const double work = load.cwiseProduct(u).sum();
    if (nu > 0.0) {
      hard.Expect(Message("work against that at the nu before, nu ", nu), work / before,
                  Below(1.1));
    }
    // No locking: the block still gives way.
    hard.Expect(Message("work of the load, nu ", nu), work, Above(0.5 * 1e-4 * 800.0 * 0.1),
                "N mm");
    before = work;
    const StaticSolver linear(box, UniformTable(0.01, nu), ElementKind::kLinear);
    plot.curves[0].Add(0.5 - nu, work);
    plot.curves[1].Add(0.5 - nu, load.cwiseProduct(linear.Displacements(load)).sum());
  }
  hard.Plot(plot);
}

TEST(MechanicsStability, OneTetrahedronThickLayersDoNotLock) {
  const HardCase hard(
      "Skin one tetrahedron thick: its elements have no neighbours to average with.");
  // Skin of one layer of elements on fat: the patches of each are within it.
  mesh::TetraMesh box = BoxMesh({12, 12, 6}, {0, 0, 0}, {60, 60, 30}, 0.12);
  for (Eigen::Index i = 0; i < box.nodes_mm.cols(); ++i) {
    double& z = box.nodes_mm(2, i);
    if (std::abs(z - 25.0) < 1.0) z = 25.0;
  }
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  ElasticityTable table = UniformTable(0.01, 0.499);
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 30.0; },
      [](const Eigen::Vector3d& x) {
        return Eigen::Vector3d(0, 0,
                               (x.head<2>().array() - 30.0).abs().maxCoeff() < 10 ? -1e-3 : 0);
      });
  const auto work = [&](ElementKind kind) {
    return load.cwiseProduct(StaticSolver(box, table, kind).Displacements(load)).sum();
  };
  const double whole = work(ElementKind::kAveragedDilatation);
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    const mesh::Corners c = mesh::CornersOf(box, static_cast<int>(t));
    box.tissue[t] = (c[0] + c[1] + c[2] + c[3]).z() > 100.0 ? 1 : 2;
  }
  // The same constants under two names: only the patches differ.
  hard.Expect("change of work by a name for the skin",
              std::abs(work(ElementKind::kAveragedDilatation) / whole - 1.0), AtMost(0.05));
  hard.Expect("work with linear elements, which do lock", work(ElementKind::kLinear) / whole,
              Below(0.75));
}

TEST(MechanicsStability, SpreadLoadsConvergeWherePointLoadsDoNot) {
  const HardCase hard("Under a force on a point tissue gives way the more the finer the mesh is.");
  const auto depression_mm = [](int cells, bool is_spread) {
    mesh::TetraMesh box = BoxMesh({cells, cells, cells / 2}, {-40, -40, -40}, {40, 40, 0});
    Fix(box, [](const Eigen::Vector3d& x) { return x.z() == -40.0; });
    Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Zero(3, box.nodes_mm.cols());
    if (is_spread) {
      load = TractionLoad(
          box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; },
          [](const Eigen::Vector3d& x) {
            return Eigen::Vector3d(0, 0, x.cwiseAbs().maxCoeff() < 10.0 ? -1.0 / 400.0 : 0.0);
          },
          8);
    } else {
      load(2, NodeAt(box, {0, 0, 0})) = -1.0;
    }
    const StaticSolver solver(box, UniformTable(0.01, 0.49), ElementKind::kAveragedDilatation);
    return load.cwiseProduct(solver.Displacements(load)).sum();
  };
  const double spread[] = {depression_mm(8, true), depression_mm(16, true),
                           depression_mm(24, true)};
  hard.Expect("spread load: change from 16 to 24 cells, of that from 8 to 16",
              std::abs(spread[2] - spread[1]) / std::abs(spread[1] - spread[0]), Below(0.5));
  hard.Expect("spread load: change from 16 to 24 cells", std::abs(spread[2] / spread[1] - 1.0),
              Below(0.05));
  // Under a point load it grows with the number of elements along an edge.
  const double point[] = {depression_mm(8, false), depression_mm(16, false),
                          depression_mm(24, false)};
  hard.Expect("point load: growth from 16 to 24 cells", point[2] / point[1], Above(1.3));
  hard.Plot(
      {.title = "Work of 1 N, spread over 20 mm and on one node",
       .x_label = "cells along an edge",
       .y_label = "work [N mm]",
       .curves = {{.name = "spread", .x = {8, 16, 24}, .y = {spread[0], spread[1], spread[2]}},
                  {.name = "point", .x = {8, 16, 24}, .y = {point[0], point[1], point[2]}}}});
}

TEST(MechanicsStability, IslandsAreExcludedOrRefused) {
  const HardCase hard("A crumb of the segmentation hangs on nothing: the matrix is singular.");
  mesh::TetraMesh box = BoxMesh({6, 6, 6}, {0, 0, 0}, {60, 60, 60});
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  const mesh::TetraMesh crumb = BoxMesh({1, 1, 1}, {100, 100, 100}, {105, 105, 105});
  const auto with = [&](const mesh::TetraMesh& other) {
    mesh::TetraMesh both = box;
    const auto n = box.nodes_mm.cols();
    both.nodes_mm.conservativeResize(3, n + other.nodes_mm.cols());
    both.nodes_mm.rightCols(other.nodes_mm.cols()) = other.nodes_mm;
    const auto m = box.tetrahedra.cols();
    both.tetrahedra.conservativeResize(4, m + other.tetrahedra.cols());
    both.tetrahedra.rightCols(other.tetrahedra.cols()) =
        other.tetrahedra.array() + static_cast<int>(n);
    both.tissue.resize(static_cast<std::size_t>(both.tetrahedra.cols()), 4);
    both.fixed_nodes.resize(static_cast<std::size_t>(both.nodes_mm.cols()), 0);
    return both;
  };
  const Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Constant(3, box.nodes_mm.cols(), 1e-4);
  Eigen::Matrix3Xd load_both = Eigen::Matrix3Xd::Constant(3, box.nodes_mm.cols() + 8, 1e-4);
  for (const ElementKind kind : kBothElements) {
    const ElasticityTable table = UniformTable(0.01, 0.45);
    const Eigen::Matrix3Xd alone = StaticSolver(box, table, kind).Displacements(load);
    const StaticSolver solver(with(crumb), table, kind);
    ASSERT_EQ(solver.free().loose.size(), 1u);
    const Eigen::Matrix3Xd u = solver.Displacements(load_both);
    hard.Expect(Message("change of the rest by a crumb, ", MechanicsElementsNameOf(kind)),
                (u.leftCols(alone.cols()) - alone).norm() / alone.norm(), Below(1e-12));
    EXPECT_TRUE(u.rightCols(8).isZero(0.0));
    EXPECT_THAT(
        ([&] {
          StaticSolver(with(BoxMesh({2, 2, 2}, {100, 100, 100}, {140, 140, 140})), table, kind);
        }),
        ThrowsMessage<InputError>(HasSubstr("(120, 120, 120) mm")));
  }
}

}  // namespace
}  // namespace acus::mechanics
