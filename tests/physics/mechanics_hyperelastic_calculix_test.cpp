// The same mesh, laws and loads at large strain in another program: CalculiX, element C3D4 with
// *HYPERELASTIC.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iomanip>
#include <sstream>

#include "references/finite_strain.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"
#include "support/temporary_folder.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

constexpr double kTopMm = 30.0;

/// A block of one tissue, pressed in and sheared by a stamp on a part of its top.
struct StampedBlock {
  mesh::TetraMesh mesh = BoxMesh({5, 5, 5}, {0, 0, 0}, {30, 30, kTopMm}, 0.15);
  ElasticityTable table = UniformTable(0.01, 0.45);
  Eigen::Matrix3Xd held_mm;

  explicit StampedBlock(const HyperelasticLaw& law) {
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
  out << std::setprecision(13) << "*NODE, NSET=ALL\n";
  for (Eigen::Index i = 0; i < mesh.nodes_mm.cols(); ++i) {
    const Eigen::Vector3d x = mesh.nodes_mm.col(i);
    out << i + 1 << ", " << x.x() << ", " << x.y() << ", " << x.z() << "\n";
  }
  out << "*ELEMENT, TYPE=C3D4, ELSET=T\n";
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const Eigen::Vector4i n = mesh.tetrahedra.col(t).array() + 1;
    out << t + 1 << ", " << n[0] << ", " << n[1] << ", " << n[2] << ", " << n[3] << "\n";
  }
  const ElasticTissue& tissue = block.table.tissue[4];
  const HyperelasticLaw& law = block.table.law[4];
  const double c10 = 0.5 * tissue.ShearModulusMpa();
  const double d1 = 2.0 / tissue.BulkModulusMpa();  // Its energy of volume is (J - 1)^2 / D1.
  out << "*MATERIAL, NAME=M\n*HYPERELASTIC, " << (law.kind == LawKind::kYeoh ? "YEOH" : "NEO HOOKE")
      << "\n";
  if (law.kind == LawKind::kYeoh) {
    // The coefficients of (J - 1)^4 and (J - 1)^6 are next to nothing.
    out << c10 << ", " << law.c2_mpa << ", " << law.c3_mpa << ", " << d1 << ", 1e12, 1e12\n";
  } else {
    out << c10 << ", " << d1 << "\n";
  }
  out << "*SOLID SECTION, ELSET=T, MATERIAL=M\n*STEP, NLGEOM, INC=100\n*STATIC\n0.1, "
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

TEST(HyperelasticCalculix, GivesTheSameDisplacementsUnderAStamp) {
  if (std::system("command -v ccx >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "ccx is not installed (Debian: calculix-ccx); nothing to compare with";
  }
  for (const HyperelasticLaw& law :
       {HyperelasticLaw{}, HyperelasticLaw{LawKind::kYeoh, 2e-3, 1e-3, 0.0}}) {
    const StampedBlock block(law);
    const TemporaryFolder folder;
    WriteHyperelasticInput(folder.path() / "box.inp", block);
    const std::string run = "cd '" + folder.path().string() + "' && ccx -i box >log.txt 2>&1";
    ASSERT_EQ(std::system(run.c_str()), 0) << LawName(law.kind);
    const Eigen::Matrix3Xd theirs =
        ReadLastDisplacements(folder.path() / "box.dat", block.held_mm.cols());
    FiniteStrainSolver solver(block.mesh, block.table, ElementKind::kLinear);
    Eigen::Matrix3Xd ours;
    const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, block.held_mm.cols());
    for (const double share : {0.25, 0.5, 0.75, 1.0}) {
      ours = solver.Solve(none, share * block.held_mm, ours).displacement_mm;
    }
    const double largest = (ours - theirs).cwiseAbs().maxCoeff() / ours.cwiseAbs().maxCoeff();
    RecordProperty("relative_difference", testing::PrintToString(largest));
    EXPECT_LT(largest, 1e-6) << LawName(law.kind);
  }
}

}  // namespace
}  // namespace acus::mechanics
