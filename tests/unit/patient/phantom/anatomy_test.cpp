#include "acus/patient/phantom/anatomy/anatomy.h"

#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

BodySettings Body() {
  BodySettings settings;
  settings.lesion_centre_mm = Vector3d(-88, -50, 115);
  return settings;
}

/// Labels met on the way from `from` to `to`, in order, without repeats of neighbours.
std::vector<std::string> Along(const Anatomy& anatomy, const Vector3d& from, const Vector3d& to) {
  std::vector<std::string> met;
  const int steps = static_cast<int>((to - from).norm() / 0.1);
  for (int i = 0; i <= steps; ++i) {
    const volume::Label label = anatomy.LabelAt(from + (to - from) * i / steps);
    const std::string name(volume::StandardLabels()[label].name);
    if (met.empty() || met.back() != name) met.push_back(name);
  }
  return met;
}

class Seeds : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Anatomy, Seeds, testing::Values(1, 2, 3, 17, 90210));

TEST_P(Seeds, LeaveAMidlineWindowBetweenTheSpinousProcesses) {
  const Anatomy anatomy(Body(), GetParam());
  for (const char* level : {"canal_L2L3", "canal_L3L4", "canal_L4L5"}) {
    const Vector3d canal = anatomy.Landmark(level);
    EXPECT_EQ(anatomy.LabelAt(canal), volume::LabelOf("spinal_canal")) << level;
    // Some straight way in the midline, at most 40 degrees off the horizontal, meets no bone.
    int free_ways = 0;
    std::vector<std::string> met;
    for (int degrees = -40; degrees <= 40; degrees += 2) {
      const double angle = degrees * std::numbers::pi / 180.0;
      const Vector3d outside = canal + 130.0 * Vector3d(0, std::cos(angle), std::sin(angle));
      const auto way = Along(anatomy, outside, canal);
      if (std::ranges::find(way, "bone") != way.end()) continue;
      ++free_ways;
      met = way;
    }
    EXPECT_GE(free_ways, 3) << level;
    EXPECT_LE(free_ways, 25) << level << ": the spine is not a wall with windows any more";
    const std::set<std::string> tissues(met.begin(), met.end());
    for (const char* tissue : {"outside", "skin", "fat", "ligament", "spinal_canal"}) {
      EXPECT_TRUE(tissues.contains(tissue)) << level << ": " << tissue;
    }
  }
}

TEST_P(Seeds, StopANeedleAtEveryLamina) {
  const Anatomy anatomy(Body(), GetParam());
  for (const char* level : {"lamina_L2", "lamina_L3", "lamina_L4", "lamina_L5"}) {
    const Vector3d lamina = anatomy.Landmark(level);
    const auto way = Along(anatomy, lamina + Vector3d(0, 120, 0), lamina - Vector3d(0, 8, 0));
    const auto bone = std::ranges::find(way, "bone");
    ASSERT_NE(bone, way.end()) << level;
    EXPECT_EQ(std::find(way.begin(), bone, "spinal_canal"), bone) << level << ": canal before bone";
    EXPECT_NE(std::find(way.begin(), bone, "muscle"), bone) << level;
  }
}

TEST_P(Seeds, PutEveryOrganWhereItBelongs) {
  const Anatomy anatomy(Body(), GetParam());
  const auto label = [&](const Vector3d& p) {
    return std::string(volume::StandardLabels()[anatomy.LabelAt(p)].name);
  };
  EXPECT_EQ(label(anatomy.Landmark("lesion")), "lesion");
  EXPECT_EQ(label(anatomy.Landmark("liver")), "liver");
  EXPECT_EQ(label(anatomy.Landmark("left_kidney")), "kidney");
  EXPECT_EQ(label(anatomy.Landmark("right_kidney")), "kidney");
  EXPECT_EQ(label(anatomy.Landmark("disc_L3L4")), "disc");
  EXPECT_EQ(label(anatomy.scale() * Vector3d(0, -17, 18)), "bone");
  EXPECT_EQ(label(anatomy.scale() * Vector3d(70, -20, 240)), "lung");
  EXPECT_EQ(label(anatomy.scale() * Vector3d(30, 35, 0)), "muscle");
  EXPECT_EQ(label(Vector3d(0, 0, 400) + Vector3d(300, 0, 0)), "outside");
}

TEST_P(Seeds, HaveAKidneyEitherSideOfTheMidline) {
  const Anatomy anatomy(Body(), GetParam());
  const Vector3d left = anatomy.Landmark("left_kidney"), right = anatomy.Landmark("right_kidney");
  EXPECT_GT(left.x(), 50.0);
  EXPECT_NEAR(left.x(), -right.x(), 1e-9);
  EXPECT_NEAR(left.y(), right.y(), 1e-9);
  EXPECT_GT(left.z(), right.z()) << "the liver is above the right one";
}

TEST_P(Seeds, KeepTheSkinClosedAndOfItsThickness) {
  const Anatomy anatomy(Body(), GetParam());
  for (double z = -100; z <= 250; z += 50) {
    for (double angle = 0; angle < 6.28; angle += 0.2) {
      const Vector3d outwards(std::sin(angle), std::cos(angle), 0);
      double skin_mm = 0.0;
      bool inside = false;
      for (double r = 190; r > 0; r -= 0.1) {
        const volume::Label label = anatomy.LabelAt(Vector3d(0, -40, z) + r * outwards);
        if (label == volume::LabelOf("skin")) skin_mm += 0.1;
        const bool outside = label == volume::LabelOf("outside");
        ASSERT_FALSE(inside && outside) << "a hole at " << r;
        inside = !outside;
      }
      EXPECT_GE(skin_mm, 1.8) << z << " " << angle;
      EXPECT_LE(skin_mm, 3.2) << z << " " << angle;  // Longer where the ray is oblique.
    }
  }
}

TEST(Anatomy, IsMadeByItsSeed) {
  const Anatomy a(Body(), 1), again(Body(), 1), other(Body(), 2);
  int differing = 0;
  for (double z = -100; z < 250; z += 11) {
    for (double y = -140; y < 80; y += 7) {
      for (double x = -150; x < 150; x += 7) {
        const Vector3d p(x, y, z);
        ASSERT_EQ(a.MaterialAt(p), again.MaterialAt(p));
        differing += a.MaterialAt(p) != other.MaterialAt(p);
      }
    }
  }
  EXPECT_GT(differing, 500);
}

TEST(Anatomy, LookingUpNearbyPartsChangesNothing) {
  const Anatomy anatomy(Body(), 1);
  const Box box(Vector3d(-40, -40, -10), Vector3d(40, 80, 30));
  const Anatomy::Nearby parts = anatomy.PartsIn(box);
  EXPECT_LT(parts.size(), anatomy.parts().size());
  for (double z = -10; z <= 30; z += 5) {
    for (double y = -40; y <= 80; y += 1.7) {
      for (double x = -40; x <= 40; x += 1.7) {
        const Vector3d p(x, y, z);
        ASSERT_EQ(anatomy.MaterialAt(p, parts), anatomy.MaterialAt(p));
      }
    }
  }
}

TEST(Anatomy, NamesTheKnownLandmarksWhenRequestedAnother) {
  const Anatomy anatomy(Body(), 1);
  EXPECT_THROW(anatomy.Landmark("canal_L8L9"), InputError);
}

TEST(Materials, BelongToStandardLabels) {
  ASSERT_EQ(Materials().size(), static_cast<std::size_t>(kNumMaterials));
  for (const MaterialInfo& material : Materials()) {
    EXPECT_TRUE(volume::FindLabel(material.label).has_value()) << material.name;
  }
  EXPECT_EQ(LabelOf(Material::kCorticalBone), volume::LabelOf("bone"));
}

}  // namespace
}  // namespace acus::phantom
