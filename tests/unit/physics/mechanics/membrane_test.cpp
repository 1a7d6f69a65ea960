#include "acus/physics/mechanics/elements/membrane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "support/box_mesh.h"

namespace acus::mechanics {
namespace {

using Eigen::Vector3d;

constexpr volume::Label kTissue = 4;

Membrane Sheet() {
  Membrane out;
  out.tissue = kTissue;
  out.against.set(0);
  out.youngs_modulus_mpa = 0.13;
  out.poissons_ratio = 0.3;
  out.thickness_mm = 2.0;
  return out;
}

/// A box whose nodes are moved in all directions, along faces only on faces.
mesh::TetraMesh CrookedBox() {
  mesh::TetraMesh box = testing_support::BoxMesh({6, 6, 3}, {0, 0, 0}, {30, 30, 12}, 0.15);
  RandomStream random(3, "crooked");
  for (Eigen::Index n = 0; n < box.nodes_mm.cols(); ++n) {
    Vector3d x = box.nodes_mm.col(n);
    const bool is_top = x.z() > 12.0 - 1e-9;
    const bool is_inner =
        (x.head<2>().array() > 1e-9).all() && (x.head<2>().array() < 30 - 1e-9).all();
    if (is_top && is_inner) {
      box.nodes_mm.col(n).head<2>() +=
          Eigen::Vector2d(random.Uniform() - 0.5, random.Uniform() - 0.5);
    }
  }
  return box;
}

Eigen::VectorXd Moved(const mesh::TetraMesh& mesh, const auto& displacement) {
  Eigen::VectorXd u(3 * mesh.nodes_mm.cols());
  for (Eigen::Index n = 0; n < mesh.nodes_mm.cols(); ++n) {
    u.segment<3>(3 * n) = displacement(Vector3d(mesh.nodes_mm.col(n)));
  }
  return u;
}

Eigen::VectorXd Forces(const Eigen::SparseMatrix<double>& lower, const Eigen::VectorXd& u) {
  return lower.selfadjointView<Eigen::Lower>() * u;
}

TEST(Membrane, RigidMotionsNeedNoForce) {
  const mesh::TetraMesh box = CrookedBox();
  const Membrane sheet = Sheet();
  const auto k = MembraneStiffness(box, {&sheet, 1});
  const Vector3d turn(0.3, -0.2, 0.5), shift(1, 2, 3);
  const auto u = Moved(box, [&](const Vector3d& x) -> Vector3d { return turn.cross(x) + shift; });
  EXPECT_LT(Forces(k, u).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(Membrane, StretchIsPlaneStress) {
  Membrane sheet = Sheet();
  mesh::TetraMesh box = CrookedBox();
  const auto k = MembraneStiffness(box, {&sheet, 1});
  const double xx = 0.02, yy = -0.01, xy = 0.004;
  // Of the two faces along z the others' strains are theirs: only x and y move, with x and y.
  const auto u = Moved(box, [&](const Vector3d& x) {
    return Vector3d(xx * x.x() + xy * x.y(), xy * x.x() + yy * x.y(), 0.0);
  });
  const auto energy = [&](double a, double b, double shear) {
    return 0.5 * sheet.StretchingStiffnessNPerMm() *
           (a * a + b * b + 2 * 0.3 * a * b + 2 * (1 - 0.3) * shear * shear);
  };
  const double expected =
      2 * 900.0 * energy(xx, yy, xy) + 2 * 360.0 * energy(xx, 0, 0) + 2 * 360.0 * energy(yy, 0, 0);
  // The sides shear along y = const by xy as well; there it bends nothing and w is along a normal.
  EXPECT_NEAR(0.5 * u.dot(Forces(k, u)), expected, 0.02 * expected);
}

TEST(Membrane, ConstantCurvatureHasItsEnergy) {
  // The middle of a crooked sheet: faces whose patches do not reach the rim.
  Membrane sheet = Sheet();
  const mesh::TetraMesh box = CrookedBox();
  const double xx = 0.02, xy = 0.005;
  const auto u = Moved(box, [&](const Vector3d& x) {
    return Vector3d(0, 0,
                    x.z() > 12.0 - 1e-9 ? 0.5 * xx * x.x() * x.x() + xy * x.x() * x.y() : 0.0);
  });
  // Energies of faces with three neighbours: all of the box's top less what has a rim.
  double area_mm2 = 0.0;
  for (const MembraneFace& face : FacesOf(sheet, box)) {
    const Vector3d a = box.nodes_mm.col(face.corner[0]);
    const Vector3d b = box.nodes_mm.col(face.corner[1]);
    const Vector3d c = box.nodes_mm.col(face.corner[2]);
    const bool is_top = std::min({a.z(), b.z(), c.z()}) > 12.0 - 1e-9;
    const bool is_inner = std::ranges::none_of(face.opposite, [](int n) { return n < 0; });
    if (is_top && is_inner) area_mm2 += 0.5 * (b - a).cross(c - a).norm();
  }
  EXPECT_GT(area_mm2, 600.0);
  const auto energy = [&](double thickness_mm) {
    sheet.thickness_mm = thickness_mm;
    return 0.5 * u.dot(Forces(MembraneStiffness(box, {&sheet, 1}), u));
  };
  // Bending goes with t^3, stretching of the sides (w there is along them) with t.
  const double bending = (energy(2.0) - 2.0 * energy(1.0)) / 6.0 * 8.0;
  sheet.thickness_mm = 2.0;
  const double density = 0.5 * sheet.BendingStiffnessNmm() * (xx * xx + 2 * (1 - 0.3) * xy * xy);
  EXPECT_GT(bending, area_mm2 * density * (1 - 1e-9));
  EXPECT_LT(bending, 900.0 * density * 1.1);  // The rim's faces see part of it.
}

TEST(Membrane, LiesBetweenTheTissuesOfItsList) {
  mesh::TetraMesh box = testing_support::BoxMesh({4, 4, 4}, {0, 0, 0}, {4, 4, 4});
  for (Eigen::Index t = 0; t < box.tetrahedra.cols(); ++t) {
    double z = 0.0;
    for (const int n : box.tetrahedra.col(t)) z += 0.25 * box.nodes_mm(2, n);
    if (z > 3.0) box.tissue[static_cast<std::size_t>(t)] = 5;
  }
  Membrane sheet = Sheet();
  EXPECT_EQ(FacesOf(sheet, box).size(), 2u * (16 + 4 * 12));  // Bottom and lower sides.
  sheet.against.reset();
  sheet.against.set(5);
  const auto between = FacesOf(sheet, box);
  EXPECT_EQ(between.size(), 32u);
  for (const MembraneFace& face : between) {
    for (const int n : face.corner) EXPECT_NEAR(box.nodes_mm(2, n), 3.0, 1e-12);
  }
}

TEST(MembraneCompliance, IsAPlateOnTheGroundUnderAPoint) {
  const Membrane plate = Sheet();
  const double shear = 0.002, nu = 0.5;
  const double length_mm = std::cbrt(plate.BendingStiffnessNmm() * (1 - nu) / shear);
  EXPECT_NEAR(MembraneComplianceMmPerN(plate, shear, nu, 0.0),
              length_mm * length_mm / (3.0 * std::sqrt(3.0) * plate.BendingStiffnessNmm()), 1e-6);
}

/// Mean of 1/r over a kernel of radius 1 twice, by `side` x `side` squares; within a square the
/// mean of 1/r is 2.973 over its side.
double MeanInverseDistance(int side) {
  const double h = 2.0 / side;
  std::vector<Vector3d> cell;  // x, y, weight.
  double sum = 0.0, mean = 0.0;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double x = -1.0 + (i + 0.5) * h, y = -1.0 + (j + 0.5) * h;
      const double inside = std::max(0.0, 1.0 - (x * x + y * y));
      if (inside > 0.0) cell.emplace_back(x, y, inside * inside);
      sum += inside * inside;
    }
  }
  for (const Vector3d& a : cell) {
    for (const Vector3d& b : cell) {
      const double r = (a - b).head<2>().norm();
      mean += a.z() * b.z() / (sum * sum) * (r > 0.0 ? 1.0 / r : 2.973 / h);
    }
  }
  return mean;
}

TEST(MembraneCompliance, IsThatOfTheGroundWithoutAMembrane) {
  Membrane none = Sheet();
  none.youngs_modulus_mpa = 0.0;
  const double shear = 0.002, nu = 0.45, radius_mm = 7.4;
  // Boussinesq: a point moves another at distance r by (1 - nu) / (2 pi G r). The error of the
  // squares is linear in their side.
  const double mean_per_mm = (2.0 * MeanInverseDistance(64) - MeanInverseDistance(32)) / radius_mm;
  EXPECT_NEAR(MembraneComplianceMmPerN(none, shear, nu, radius_mm) /
                  ((1 - nu) / (2 * std::numbers::pi * shear) * mean_per_mm),
              1.0, 0.002);
}

TEST(MembraneCompliance, TensionAndThicknessStiffen) {
  Membrane sheet = Sheet();
  const double bent = MembraneComplianceMmPerN(sheet, 0.001, 0.49, 5.0);
  sheet.tension_n_per_mm = 0.05;
  const double stretched = MembraneComplianceMmPerN(sheet, 0.001, 0.49, 5.0);
  sheet.thickness_mm = 4.0;
  EXPECT_LT(stretched, bent);
  EXPECT_LT(MembraneComplianceMmPerN(sheet, 0.001, 0.49, 5.0), stretched);
}

TEST(ElasticityTable, ReadsMembranes) {
  const auto table =
      ElasticityTableFromJson(nlohmann::json::parse(R"({"format": "acus-elasticity/1", "tissues": [
        {"tissue": "liver", "source": "test", "youngs_modulus_kpa": 5,
         "membrane": {"source": "test", "not_against": ["vessel"], "youngs_modulus_kpa": 900,
                      "thickness_mm": 0.1}},
        {"tissue": "skin", "source": "test", "youngs_modulus_kpa": 130,
         "membrane": {"source": "test", "against": ["outside"], "youngs_modulus_kpa": 130,
                      "thickness_mm": 2, "tension_n_per_m": 10, "solid_youngs_modulus_kpa": 3}}
      ]})"),
                              "test.json");
  const volume::Label skin = volume::LabelOf("skin"), liver = volume::LabelOf("liver");
  ASSERT_NE(table.MembraneOf(skin, 0), nullptr);
  EXPECT_DOUBLE_EQ(table.MembraneOf(skin, 0)->tension_n_per_mm, 0.01);
  EXPECT_EQ(table.MembraneOf(skin, liver), nullptr);
  EXPECT_NE(table.MembraneOf(liver, 0), nullptr);
  EXPECT_EQ(table.MembraneOf(liver, volume::LabelOf("vessel")), nullptr);
  EXPECT_DOUBLE_EQ(table.At(skin).youngs_modulus_mpa, 0.13);
  EXPECT_DOUBLE_EQ(table.SolidAt(skin).youngs_modulus_mpa, 0.003);
  EXPECT_DOUBLE_EQ(table.SolidAt(liver).youngs_modulus_mpa, 0.005);
}

TEST(ElasticityTable, NamesTheMembraneWithAnUnknownTissue) {
  try {
    ElasticityTableFromJson(nlohmann::json::parse(R"({"format": "acus-elasticity/1", "tissues": [
          {"tissue": "liver", "source": "test", "youngs_modulus_kpa": 5,
           "membrane": {"source": "test", "against": ["bark"], "youngs_modulus_kpa": 900,
                        "thickness_mm": 0.1}}]})"),
                            "test.json");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/tissues/0/membrane"), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("bark"), std::string::npos);
  }
}

}  // namespace
}  // namespace acus::mechanics
