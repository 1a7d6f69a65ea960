#include "acus/patient/registration/correspondence.h"

#include <gmock/gmock.h>

#include "support/marker_layouts.h"

namespace acus::registration {
namespace {

using testing::IsEmpty;
using testing_support::KnownPose;
using testing_support::NoisyMarkers;
using testing_support::SpreadMarkers;

TEST(BetterOrder, FindsTheOrderOfUpToEightPoints) {
  for (const int count : {4, 5, 6, 7, 8}) {
    std::vector<Eigen::Index> shuffled;
    for (int i = 0; i < count; ++i) shuffled.push_back((3 * i + 1) % count);
    if (count == 6) shuffled = {5, 3, 0, 1, 4, 2};
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const transforms::Markers reference_mm = SpreadMarkers(count, seed);
      const transforms::Markers ct_mm = NoisyMarkers(KnownPose() * reference_mm, 0.4, seed);
      transforms::Markers wrong_mm(3, count);  // CT marker shuffled[i] is reference marker i.
      for (int i = 0; i < count; ++i) {
        wrong_mm.col(shuffled[static_cast<std::size_t>(i)]) = ct_mm.col(i);
      }
      const auto order = BetterOrder(reference_mm, wrong_mm);
      ASSERT_TRUE(order) << count << " points, seed " << seed;
      EXPECT_EQ(order->ct_of, shuffled) << count << " points, seed " << seed;
      EXPECT_LT(order->fre_rms_mm, 1.0);
    }
  }
}

TEST(BetterOrder, FindsTheOrderOfManyPoints) {
  for (const int count : {9, 15, 40}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const transforms::Markers reference_mm = SpreadMarkers(count, seed);
      const transforms::Markers ct_mm = NoisyMarkers(KnownPose() * reference_mm, 0.4, seed);
      transforms::Markers reversed_mm(3, count);  // As listed from the end.
      for (int i = 0; i < count; ++i) reversed_mm.col(count - 1 - i) = ct_mm.col(i);
      const auto order = BetterOrder(reference_mm, reversed_mm);
      ASSERT_TRUE(order) << count << " points, seed " << seed;
      for (int i = 0; i < count; ++i) {
        EXPECT_EQ(order->ct_of[static_cast<std::size_t>(i)], count - 1 - i);
      }
      EXPECT_FALSE(BetterOrder(reference_mm, ct_mm)) << "a right order, seed " << seed;
    }
  }
}

TEST(BetterOrder, LeavesARightOrderAlone) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const transforms::Markers reference_mm = SpreadMarkers(6, seed);
    EXPECT_FALSE(BetterOrder(reference_mm, NoisyMarkers(KnownPose() * reference_mm, 2.0, seed)));
  }
  EXPECT_FALSE(BetterOrder(SpreadMarkers(6, 1), SpreadMarkers(6, 2)));  // Other points altogether.
}

TEST(EquallyGoodOrders, ReportsASymmetricalLayout) {
  transforms::Markers square_mm(3, 4);
  square_mm << 50, 50, -50, -50, 50, -50, -50, 50, 0, 0, 0, 0;
  // Four turns and four turns of the other side; the present one does not count.
  EXPECT_EQ(EquallyGoodOrders(square_mm, KnownPose() * square_mm).size(), 7U);
  square_mm.col(0).head<2>().array() += 20.0;
  EXPECT_THAT(EquallyGoodOrders(square_mm, NoisyMarkers(KnownPose() * square_mm, 0.3, 1)),
              testing::SizeIs(1));  // Still its own mirror image in the diagonal.
  EXPECT_THAT(EquallyGoodOrders(SpreadMarkers(6), NoisyMarkers(SpreadMarkers(6), 0.3, 1)),
              IsEmpty());
}

/// A grid of 4 x 4 looks the same after four turns, from both sides.
TEST(EquallyGoodOrders, ReportsAGridOfManyPoints) {
  transforms::Markers grid_mm(3, 16);
  for (int i = 0; i < 16; ++i) grid_mm.col(i) << 30.0 * (i % 4), 30.0 * (i / 4), 0.0;
  EXPECT_EQ(EquallyGoodOrders(grid_mm, KnownPose() * grid_mm).size(), 7U);
}

TEST(Order, IsSaidInNames) {
  const Order order{.ct_of = {2, 1, 0}, .fre_rms_mm = 0.1};
  EXPECT_EQ(DescribeOrder(order, {"A", "B", "C"}), "'A' is 'C', 'C' is 'A'");
}

}  // namespace
}  // namespace acus::registration
