#include "acus/physics/forces/path/guidance.h"

#include <gmock/gmock.h>

#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;
using testing_support::Abdomen;
using testing_support::DrivenAlamilla;
using testing_support::DrivenLayered;
using testing_support::DrivenVidal;
using testing_support::LayeredBodyField;
using testing_support::ShippedTable;
using testing_support::Trocar18G;

/// In by 30 mm, 3 mm aside there, turned by 0.1 rad, 5 mm further, and out: what was felt.
template <typename Driven>
std::vector<NeedleForce> Felt(Driven driven) {
  std::vector<NeedleForce> felt;
  double time_s = 0.0;
  Vector3d place_mm(0, 0, -2);
  const auto move = [&](const Vector3d& to) {
    const Vector3d from = place_mm;
    for (int i = 1; i <= 800; ++i) {
      place_mm = from + (to - from) * i / 800.0;
      felt.push_back(driven.Step(time_s += 0.001, place_mm));
    }
  };
  move({0, 0, 28});
  move({3, 0, 28});
  driven.axis = Vector3d(std::sin(0.1), 0, std::cos(0.1));
  move({3.5, 0, 33});
  move({0, 0, -5});
  return felt;
}

bool SameBits(const std::vector<NeedleForce>& a, const std::vector<NeedleForce>& b) {
  return std::ranges::equal(a, b, [](const NeedleForce& x, const NeedleForce& y) {
    return x.force_in_ct_n == y.force_in_ct_n && x.torque_in_ct_n_mm == y.torque_in_ct_n_mm &&
           x.depth_mm == y.depth_mm && x.event == y.event && x.lateral_n == y.lateral_n;
  });
}

class GuidanceTest : public testing::Test {
 protected:
  const LayeredBodyField body = Abdomen();
  const ForceTable table = ShippedTable("default.json");
  std::vector<NeedleForce> Layered(GuidanceKind kind) const {
    const NeedleForceModel model(table, Trocar18G(), kind);
    return Felt(DrivenLayered{model, body});
  }
  std::vector<NeedleForce> Alamilla(GuidanceKind kind) const {
    const AlamillaModel model(table, Trocar18G(), kind);
    return Felt(DrivenAlamilla{model, body});
  }
  std::vector<NeedleForce> Vidal(GuidanceKind kind) const {
    const VidalModel model(table, Trocar18G(), body, kind);
    return Felt(DrivenVidal{model, body});
  }
};

TEST_F(GuidanceTest, OwnIsThatOfThePaper) {
  using enum GuidanceKind;
  EXPECT_TRUE(SameBits(Alamilla(kOwn), Alamilla(kVirtualFixture)));
  EXPECT_TRUE(SameBits(Vidal(kOwn), Vidal(kVidal)));
  EXPECT_FALSE(SameBits(Vidal(kOwn), Vidal(kVirtualFixture)));
  EXPECT_FALSE(SameBits(Alamilla(kOwn), Alamilla(kVidal)));
  EXPECT_FALSE(SameBits(Layered(kOwn), Layered(kNone)));
}

TEST_F(GuidanceTest, NoneIsNoForceAcrossThePath) {
  for (const auto& felt : {Layered(GuidanceKind::kNone), Alamilla(GuidanceKind::kNone)}) {
    for (const NeedleForce& force : felt) {
      ASSERT_EQ(force.lateral_n, 0.0);
      ASSERT_EQ(force.torque_in_ct_n_mm.norm(), 0.0);
      ASSERT_NEAR(force.force_in_ct_n.norm(), std::abs(force.AxialN()), 1e-12);
    }
  }
}

// 3 mm off the line at 28 mm: the same guidance pulls alike whatever acts along the needle. Eq. 8
// with K3 = 0.2 N/mm, the clamp long passed; the fixture with 0.2 N/mm. Both at rest.
TEST_F(GuidanceTest, TheSameGuidancePullsAlikeInEveryModel) {
  for (const auto& felt :
       {Layered(GuidanceKind::kVidal), Alamilla(GuidanceKind::kVidal),
        Layered(GuidanceKind::kVirtualFixture), Alamilla(GuidanceKind::kVirtualFixture)}) {
    const NeedleForce& aside = felt[1599];
    EXPECT_NEAR(aside.force_in_ct_n.x(), -0.6, 0.02);
    EXPECT_NEAR(aside.depth_mm, 28.0, 0.1);
  }
  EXPECT_GT(Layered(GuidanceKind::kVirtualFixture)[2399].torque_in_ct_n_mm.norm(), 1.0);
  EXPECT_EQ(Layered(GuidanceKind::kVidal)[2399].torque_in_ct_n_mm.norm(), 0.0);
}

// Force along the needle and events stay what the model makes of them: the path is the same until
// the needle leaves it.
TEST_F(GuidanceTest, TheForceAlongTheNeedleIsTheModelsOwn) {
  const auto own = Layered(GuidanceKind::kOwn);
  for (const GuidanceKind kind :
       {GuidanceKind::kNone, GuidanceKind::kVidal, GuidanceKind::kVirtualFixture}) {
    const auto felt = Layered(kind);
    for (std::size_t i = 0; i < 800; ++i) {
      ASSERT_NEAR(felt[i].AxialN(), own[i].AxialN(), 1e-9) << i;
      ASSERT_EQ(felt[i].event, own[i].event) << i;
    }
  }
}

// The trajectory gives way without taking the needle deeper or shallower: the depth follows the
// tip.
TEST_F(GuidanceTest, TheDepthChangesNoFasterThanTheTip) {
  for (const auto& felt :
       {Layered(GuidanceKind::kVirtualFixture), Alamilla(GuidanceKind::kVirtualFixture)}) {
    double largest_mm = 0.0;
    for (std::size_t i = 1601; i < 2400; ++i) {  // 5 mm in, turned, in 800 steps.
      const double change_mm = felt[i].depth_mm - felt[i - 1].depth_mm;
      EXPECT_LT(std::abs(change_mm), 0.0064) << i;
      largest_mm = std::max(largest_mm, change_mm);
    }
    EXPECT_GT(largest_mm, 0.006);
  }
}

}  // namespace
}  // namespace acus::forces
