// The same mesh, constants and loads in another program: CalculiX, element C3D4.
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iomanip>
#include <sstream>

#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"
#include "support/temporary_folder.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

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
  out << std::setprecision(13) << "*NODE, NSET=ALL\n";
  for (Eigen::Index i = 0; i < mesh.nodes_mm.cols(); ++i) {
    const Eigen::Vector3d x = mesh.nodes_mm.col(i);
    out << i + 1 << ", " << x.x() << ", " << x.y() << ", " << x.z() << "\n";
  }
  for (const int tissue : {1, 2}) {
    out << "*ELEMENT, TYPE=C3D4, ELSET=T" << tissue << "\n";
    for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
      if (mesh.tissue[static_cast<std::size_t>(t)] != tissue) continue;
      const Eigen::Vector4i n = mesh.tetrahedra.col(t).array() + 1;
      out << t + 1 << ", " << n[0] << ", " << n[1] << ", " << n[2] << ", " << n[3] << "\n";
    }
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

/// Rows "node ux uy uz", seven digits each.
Eigen::Matrix3Xd ReadDisplacements(const std::filesystem::path& path, Eigen::Index num_nodes) {
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

TEST(MechanicsCalculix, GivesTheSameDisplacementsOnTheSameMesh) {
  if (std::system("command -v ccx >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "ccx is not installed (Debian: calculix-ccx); nothing to compare with";
  }
  const Model model;
  const TemporaryFolder folder;
  WriteInput(folder.path() / "box.inp", model);
  const std::string run = "cd '" + folder.path().string() + "' && ccx -i box >log.txt 2>&1";
  ASSERT_EQ(std::system(run.c_str()), 0);
  const Eigen::Matrix3Xd theirs = ReadDisplacements(folder.path() / "box.dat", model.load_n.cols());
  const Eigen::Matrix3Xd ours =
      StaticSolver(model.mesh, model.table, ElementKind::kLinear).Displacements(model.load_n);
  const double scale_mm = ours.cwiseAbs().maxCoeff();
  EXPECT_GT(scale_mm, 0.1);
  const double largest = (ours - theirs).cwiseAbs().maxCoeff() / scale_mm;
  RecordProperty("relative_difference", testing::PrintToString(largest));
  EXPECT_LT(largest, 1e-6);
}

}  // namespace
}  // namespace acus::mechanics
