#include "acus/imaging/ultrasound/columns/fibre_field.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus::ultrasound {
namespace {

constexpr volume::Label kTendon = 17;

template <typename Inside>
volume::LabelMap Labels(const Eigen::Array3d& spacing_mm, const Inside& inside) {
  volume::Geometry geometry;
  geometry.size = {60, 60, 60};
  geometry.spacing_mm = spacing_mm;
  volume::LabelMap labels(geometry);
  for (int k = 0; k < 60; ++k) {
    for (int j = 0; j < 60; ++j) {
      for (int i = 0; i < 60; ++i) {
        const Eigen::Vector3d at_mm = (Eigen::Array3d(i, j, k) * spacing_mm).matrix();
        if (inside(at_mm)) labels.At(i, j, k) = kTendon;
      }
    }
  }
  return labels;
}

std::bitset<256> Fibrous() {
  std::bitset<256> fibrous;
  fibrous.set(kTendon);
  return fibrous;
}

double AngleDeg(const Eigen::Vector3f& a, const Eigen::Vector3d& b) {
  return std::acos(std::min(1.0, std::abs(a.cast<double>().dot(b.normalized())))) * 180.0 / M_PI;
}

TEST(FibreField, RunsAlongACylinderInAnyDirection) {
  const Eigen::Vector3d centre_mm(30, 30, 30);
  for (const Eigen::Vector3d& way :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(2, -1, 3)}) {
    const Eigen::Vector3d axis = way.normalized();
    const auto labels = Labels({1.0, 1.0, 1.0}, [&](const Eigen::Vector3d& p) {
      const Eigen::Vector3d d = p - centre_mm;
      return (d - d.dot(axis) * axis).norm() < 5.0;
    });
    const FibreField field(labels, Fibrous());
    EXPECT_LT(AngleDeg(field.MainDirection(kTendon), axis), 3.0);
    EXPECT_LT(AngleDeg(field.At(kTendon, {30, 30, 30}), axis), 5.0);
  }
}

TEST(FibreField, FollowsARingAndKnowsAnisotropicVoxels) {
  // A ring of radius 20 mm around (30, 30) in the plane z = 30 mm; its fibres run around it.
  const auto labels = Labels({1.0, 1.0, 1.5}, [](const Eigen::Vector3d& p) {
    return std::hypot(std::hypot(p.x() - 30.0, p.y() - 30.0) - 20.0, p.z() - 45.0) < 4.0;
  });
  const FibreField field(labels, Fibrous(), 4.0);
  for (const double deg : {0.0, 40.0, 90.0, 200.0, 310.0}) {
    const double a = deg * M_PI / 180.0;
    const Eigen::Vector3f index(static_cast<float>(30 + 20 * std::cos(a)),
                                static_cast<float>(30 + 20 * std::sin(a)), 30.0F);
    EXPECT_LT(AngleDeg(field.At(kTendon, index), {-std::sin(a), std::cos(a), 0.0}), 12.0) << deg;
  }
}

TEST(FibreField, KnowsOnlyFibrousLabels) {
  const auto labels =
      Labels({1.0, 1.0, 1.0}, [](const Eigen::Vector3d& p) { return p.norm() < 20.0; });
  const FibreField none(labels, {});
  EXPECT_EQ(none.At(kTendon, {3, 3, 3}), Eigen::Vector3f::Zero());
  EXPECT_EQ(none.MainDirection(kTendon), Eigen::Vector3f::Zero());
  const FibreField field(labels, Fibrous());
  EXPECT_EQ(field.At(3, {3, 3, 3}), Eigen::Vector3f::Zero());
  // Far outside, the nearest block answers.
  EXPECT_NEAR(field.At(kTendon, {1e6F, -1e6F, 0}).norm(), 1.0, 1e-5);
}

}  // namespace
}  // namespace acus::ultrasound
