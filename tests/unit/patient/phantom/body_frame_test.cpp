#include "acus/patient/phantom/planning/body_frame.h"

#include <gtest/gtest.h>

#include "unit/patient/phantom/window_patient.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

TEST(BodyFrame, HasItsMiddleInTheSpinalCanal) {
  const BodyFrame& frame = WindowPatient::Get().frame;
  for (const double z_mm : {-60.0, 0.0, 60.0, 120.0, 900.0})
    EXPECT_NEAR(frame.MiddleXMm(z_mm), 0.0, 1.5) << "at " << z_mm;
  EXPECT_EQ(frame.Side({40.0, 0.0, 0.0}), 1.0);
  EXPECT_EQ(frame.Side({-40.0, 0.0, 0.0}), -1.0);
}

TEST(BodyFrame, TakesBoneForTheMiddleWhereThereIsNoCanal) {
  volume::LabelMap labels = SyntheticBody();
  EXPECT_NEAR(BodyFrame(labels).MiddleXMm(0.0), 0.0, 2.1);
  labels.geometry.origin_mm.x() += 100.0;
  EXPECT_NEAR(BodyFrame(labels).MiddleXMm(0.0), 100.0, 2.1);
}

TEST(BodyFrame, SeparatesTheTrunkFromShouldersAndNeck) {
  // Lungs of 100 mm to either side below z = 60, narrower ones above it to z = 100.
  volume::LabelMap labels = SyntheticBody();
  const volume::Geometry& g = labels.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.ct_from_index() * Vector3d(i, j, k);
        const double half_mm = p.z() < 0.0 || p.z() > 80.0 ? 0.0 : p.z() < 60.0 ? 100.0 : 40.0;
        if (std::abs(p.x()) < half_mm && std::abs(p.y()) < 40.0)
          labels.At(i, j, k) = volume::LabelOf("lung");
      }
    }
  }
  const BodyFrame frame(labels);
  EXPECT_TRUE(frame.IsTrunk({90.0, 0.0, 30.0}));
  EXPECT_FALSE(frame.IsTrunk({110.0, 0.0, 30.0})) << "an arm";
  EXPECT_FALSE(frame.IsTrunk({90.0, 0.0, 70.0})) << "a shoulder";
  EXPECT_TRUE(frame.IsTrunk({30.0, 0.0, 70.0}));
  EXPECT_TRUE(frame.IsTrunk({90.0, 0.0, -60.0})) << "the belly";
  EXPECT_FALSE(frame.IsTrunk({0.0, 0.0, 95.0})) << "the neck";
  EXPECT_TRUE(frame.HasLungAt(30.0));
  EXPECT_FALSE(frame.HasLungAt(-60.0));
  EXPECT_TRUE(BodyFrame(SyntheticBody()).IsTrunk({900.0, 0.0, 0.0})) << "no lung to go by";
}

}  // namespace
}  // namespace acus::phantom
