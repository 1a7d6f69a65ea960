// The same meshes, constants and loads in another program: CalculiX, element C3D4; at large strain
// with *HYPERELASTIC.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iomanip>
#include <sstream>

#include "references/finite_strain.h"
#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"
#include "support/temporary_folder.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

/// One set of elements for each tissue: T1, T2, ...
void WriteMesh(std::ostream& out, const mesh::TetraMesh& mesh, std::initializer_list<int> tissues) {
  out << std::setprecision(13) << "*NODE, NSET=ALL\n";
  for (Eigen::Index i = 0; i < mesh.nodes_mm.cols(); ++i) {
    const Eigen::Vector3d x = mesh.nodes_mm.col(i);
    out << i + 1 << ", " << x.x() << ", " << x.y() << ", " << x.z() << "\n";
  }
  for (const int tissue : tissues) {
    out << "*ELEMENT, TYPE=C3D4, ELSET=T" << tissue << "\n";
    for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
      if (mesh.tissue[static_cast<std::size_t>(t)] != tissue) continue;
      const Eigen::Vector4i n = mesh.tetrahedra.col(t).array() + 1;
      out << t + 1 << ", " << n[0] << ", " << n[1] << ", " << n[2] << ", " << n[3] << "\n";
    }
  }
}

/// The last rows "node ux uy uz" of each node, seven digits each.
Eigen::Matrix3Xd ReadLastDisplacements(const std::filesystem::path& path, Eigen::Index num_nodes) {
  std::ifstream in(path);
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Constant(3, num_nodes, std::nan(""));
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    Eigen::Index node = 0;
    Eigen::Vector3d x;
    if (words >> node >> x[0] >> x[1] >> x[2] && node >= 1 && node <= num_nodes) {
      u.col(node - 1) = x;
    }
  }
  return u;
}

/// What CalculiX makes of box.inp in the folder; NaN where it gives nothing.
Eigen::Matrix3Xd DisplacementsByCalculix(const std::filesystem::path& folder,
                                         Eigen::Index num_nodes) {
  const std::string run = "cd '" + folder.string() + "' && ccx -i box >log.txt 2>&1";
  EXPECT_EQ(std::system(run.c_str()), 0);
  return ReadLastDisplacements(folder / "box.dat", num_nodes);
}

class Calculix : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v ccx >/dev/null 2>&1") != 0) {
      GTEST_SKIP() << "ccx is not installed (Debian: calculix-ccx); nothing to compare with";
    }
  }

  /// Seven printed digits: 2e-7 of the largest displacement.
  void ExpectSame(const Eigen::Matrix3Xd& ours, Eigen::Index num_nodes) {
    const Eigen::Matrix3Xd theirs = DisplacementsByCalculix(folder_.path(), num_nodes);
    const double largest = (ours - theirs).cwiseAbs().maxCoeff() / ours.cwiseAbs().maxCoeff();
    RecordProperty("relative_difference", testing::PrintToString(largest));
    EXPECT_LT(largest, 1e-6);
  }

  TemporaryFolder folder_;
};

/// A block of two tissues, held at the bottom, pushed aside and down at some nodes of the top.
struct Model {
  mesh::TetraMesh mesh = BoxMesh({7, 6, 5}, {-20, 0, 10}, {40, 50, 50}, 0.17);
  ElasticityTable table = UniformTable(0.01, 0.3);
  Eigen::Matrix3Xd load_n;

  Model() {
    Fix(mesh, [](const Eigen::Vector3d& x) { return x.z() == 10.0; });
    for (std::size_t t = 0; t < mesh.tissue.size(); ++t) {
      mesh.tissue[t] = mesh.nodes_mm(0, mesh.tetrahedra(0, static_cast<int>(t))) > 5.0 ? 1 : 2;
    }
    table.tissue[1] = {0.13, 0.49};
    load_n = Eigen::Matrix3Xd::Zero(3, mesh.nodes_mm.cols());
    for (Eigen::Index i = 0; i < load_n.cols(); ++i) {
      const Eigen::Vector3d x = mesh.nodes_mm.col(i);
      if (x.z() == 50.0 && std::abs(x.x()) < 15.0) load_n.col(i) = Eigen::Vector3d(1, 2, -3) * 1e-3;
    }
  }
};

void WriteInput(const std::filesystem::path& path, const Model& model) {
  std::ofstream out(path);
  const mesh::TetraMesh& mesh = model.mesh;
  WriteMesh(out, mesh, {1, 2});
  for (const int tissue : {1, 2}) {
    const ElasticTissue& constants = model.table.tissue[static_cast<std::size_t>(tissue)];
    out << "*MATERIAL, NAME=M" << tissue << "\n*ELASTIC\n"
        << constants.youngs_modulus_mpa << ", " << constants.poissons_ratio
        << "\n*SOLID SECTION, ELSET=T" << tissue << ", MATERIAL=M" << tissue << "\n";
  }
  out << "*BOUNDARY\n";
  for (std::size_t i = 0; i < mesh.fixed_nodes.size(); ++i) {
    if (mesh.fixed_nodes[i]) out << i + 1 << ", 1, 3, 0\n";
  }
  out << "*STEP\n*STATIC\n*CLOAD\n";
  for (Eigen::Index i = 0; i < model.load_n.cols(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double force = model.load_n(axis, i);
      if (force != 0.0) out << i + 1 << ", " << axis + 1 << ", " << force << "\n";
    }
  }
  out << "*NODE PRINT, NSET=ALL\nU\n*END STEP\n";
}

TEST_F(Calculix, GivesTheSameDisplacementsOnTheSameMesh) {
  const Model model;
  WriteInput(folder_.path() / "box.inp", model);
  const Eigen::Matrix3Xd ours =
      StaticSolver(model.mesh, model.table, ElementKind::kLinear).Displacements(model.load_n);
  EXPECT_GT(ours.cwiseAbs().maxCoeff(), 0.1);
  ExpectSame(ours, model.load_n.cols());
}

constexpr double kTopMm = 30.0;
constexpr int kTissue = 4;

/// A block of one tissue, pressed in and sheared by a stamp on a part of its top.
struct StampedBlock {
  mesh::TetraMesh mesh = BoxMesh({5, 5, 5}, {0, 0, 0}, {30, 30, kTopMm}, 0.15);
  ElasticityTable table = UniformTable(0.01, 0.45);
  Eigen::Matrix3Xd held_mm;

  explicit StampedBlock(const HyperelasticLaw& law) {
    mesh.tissue.assign(mesh.tissue.size(), kTissue);
    table.law.fill(law);
    held_mm = Eigen::Matrix3Xd::Zero(3, mesh.nodes_mm.cols());
    const auto under_stamp = [](const Eigen::Vector3d& x) {
      return x.z() == kTopMm && (x.head<2>().array() - 15.0).abs().maxCoeff() < 7.0;
    };
    Fix(mesh, [&](const Eigen::Vector3d& x) { return x.z() == 0.0 || under_stamp(x); });
    for (Eigen::Index i = 0; i < held_mm.cols(); ++i) {
      if (under_stamp(mesh.nodes_mm.col(i))) held_mm.col(i) = Eigen::Vector3d(3.0, 0.0, -7.0);
    }
  }
};

void WriteHyperelasticInput(const std::filesystem::path& path, const StampedBlock& block) {
  std::ofstream out(path);
  const mesh::TetraMesh& mesh = block.mesh;
  WriteMesh(out, mesh, {kTissue});
  const ElasticTissue& tissue = block.table.tissue[kTissue];
  const HyperelasticLaw& law = block.table.law[kTissue];
  const double c10 = 0.5 * tissue.ShearModulusMpa();
  const double d1 = 2.0 / tissue.BulkModulusMpa();  // Its energy of volume is (J - 1)^2 / D1.
  out << "*MATERIAL, NAME=M\n*HYPERELASTIC, ";
  if (law.kind == LawKind::kOgden) {
    out << "OGDEN, N=2\n";
    for (const OgdenTerm& term : law.ogden) {
      out << term.share * tissue.ShearModulusMpa() << ", " << term.exponent << ", ";
    }
    out << d1 << ", 1e12\n";
  } else if (law.kind == LawKind::kYeoh) {
    out << "YEOH\n";
    // The coefficients of (J - 1)^4 and (J - 1)^6 are next to nothing.
    out << c10 << ", " << law.c2_mpa << ", " << law.c3_mpa << ", " << d1 << ", 1e12, 1e12\n";
  } else {
    out << "NEO HOOKE\n" << c10 << ", " << d1 << "\n";
  }
  out << "*SOLID SECTION, ELSET=T" << kTissue
      << ", MATERIAL=M\n*STEP, NLGEOM, INC=100\n*STATIC\n0.1, "
         "1.\n*BOUNDARY\n";
  for (std::size_t i = 0; i < mesh.fixed_nodes.size(); ++i) {
    if (!mesh.fixed_nodes[i]) continue;
    for (int axis = 0; axis < 3; ++axis) {
      out << i + 1 << ", " << axis + 1 << ", " << axis + 1 << ", "
          << block.held_mm(axis, static_cast<Eigen::Index>(i)) << "\n";
    }
  }
  out << "*NODE PRINT, NSET=ALL, FREQUENCY=1000\nU\n*END STEP\n";
}

TEST_F(Calculix, GivesTheSameDisplacementsUnderAStamp) {
  for (const HyperelasticLaw& law :
       {HyperelasticLaw{}, HyperelasticLaw{LawKind::kYeoh, 2e-3, 1e-3, 0.0},
        HyperelasticLaw{.kind = LawKind::kOgden, .ogden = {{{0.8, -6.0}, {0.2, 7.0}}}}}) {
    SCOPED_TRACE(LawName(law.kind));
    const StampedBlock block(law);
    WriteHyperelasticInput(folder_.path() / "box.inp", block);
    FiniteStrainSolver solver(block.mesh, block.table, ElementKind::kLinear);
    Eigen::Matrix3Xd ours;
    const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, block.held_mm.cols());
    for (const double share : {0.25, 0.5, 0.75, 1.0}) {
      ours = solver.Solve(none, share * block.held_mm, ours).displacement_mm;
    }
    ExpectSame(ours, block.held_mm.cols());
  }
}

}  // namespace
}  // namespace acus::mechanics
