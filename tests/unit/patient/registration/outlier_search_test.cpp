#include "acus/patient/registration/outlier_search.h"

#include <cmath>
#include <gmock/gmock.h>

#include "support/marker_layouts.h"

namespace acus::registration {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;
using testing_support::KnownPose;
using testing_support::NoisyMarkers;
using testing_support::SpreadMarkers;

TEST(MostOutliers, LeavesAMajority) {
  EXPECT_EQ(MostOutliers(3), 0);
  EXPECT_EQ(MostOutliers(4), 1);
  EXPECT_EQ(MostOutliers(5), 1);
  EXPECT_EQ(MostOutliers(6), 2);
  EXPECT_EQ(MostOutliers(8), 3);
  EXPECT_EQ(MostOutliers(12), 5);
}

// One wrong point, from four on; with four a clear error is needed.
TEST(SearchOutliers, NamesOneWrongPoint) {
  for (const int count : {4, 5, 6, 8, 12}) {
    int named = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const transforms::Markers reference_mm = SpreadMarkers(count, seed);
      transforms::Markers ct_mm = NoisyMarkers(KnownPose() * reference_mm, 0.3, seed);
      ct_mm.col(2) += count == 4 ? Vector3d(20, -15, 10) : Vector3d(6, -4, 3);
      const auto search = SearchOutliers(reference_mm, ct_mm, 0.3);
      named += search.wrong == std::vector<Eigen::Index>{2};
    }
    EXPECT_GE(named, count == 4 ? 30 : 38) << count;
  }
}

// Three of eight moved by the same way (the marker sheet slipped): they hide each other from a
// search that takes one at a time.
TEST(SearchOutliers, FindsPointsThatHideEachOther) {
  int greedy = 0, thorough = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const transforms::Markers reference_mm = SpreadMarkers(8, seed);
    transforms::Markers ct_mm = NoisyMarkers(KnownPose() * reference_mm, 0.4, seed);
    for (const int i : {1, 4, 6}) ct_mm.col(i) += Vector3d(8, 7, -6);
    const auto search = SearchOutliers(reference_mm, ct_mm, {});
    auto found = search.wrong;
    std::ranges::sort(found);
    thorough += found == std::vector<Eigen::Index>{1, 4, 6};
    std::vector<Eigen::Index> one_by_one;
    for (const auto& outlier : FindOutliers(reference_mm, ct_mm)) {
      one_by_one.push_back(outlier.marker);
    }
    std::ranges::sort(one_by_one);
    greedy += one_by_one == std::vector<Eigen::Index>{1, 4, 6};
  }
  EXPECT_GE(thorough, 28);
  EXPECT_LE(greedy, 15);
}

TEST(SearchOutliers, AccusesGoodPointsRarely) {
  int accused = 0;
  int accused_with_fle = 0;
  constexpr int kTrials = 1000;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const transforms::Markers reference_mm = SpreadMarkers(7);
    const transforms::Markers ct_mm = NoisyMarkers(KnownPose() * reference_mm, 1.0, trial);
    accused += !SearchOutliers(reference_mm, ct_mm, {}, 0.05).wrong.empty();
    accused_with_fle += !SearchOutliers(reference_mm, ct_mm, 1.0, 0.05).wrong.empty();
  }
  EXPECT_LT(accused, 0.07 * kTrials);
  EXPECT_LT(accused_with_fle, 0.07 * kTrials);
}

// Markers on skin and in tissue scatter differently, here by a factor of 1.6 (SD): the F test alone
// accuses a point of one in six such good sets, where it says one in 100.
TEST(SearchOutliers, AccusesGoodPointsOfUnevenScatterRarely) {
  int accused = 0;
  constexpr int kTrials = 1000;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const transforms::Markers reference_mm = SpreadMarkers(9);
    transforms::Markers error_mm = NoisyMarkers(transforms::Markers::Zero(3, 9), 1.0, trial);
    RandomStream random(5, "uneven", trial);
    for (Eigen::Index i = 0; i < 9; ++i) error_mm.col(i) *= std::exp(0.47 * random.Normal());
    const transforms::Markers ct_mm = KnownPose() * reference_mm + error_mm;
    accused += !SearchOutliers(reference_mm, ct_mm, {}).wrong.empty();
  }
  EXPECT_LE(accused, 0.04 * kTrials);
}

TEST(SearchOutliers, ReportsWhenItIsUndetermined) {
  // A rectangle of which one corner slid along its side: the corner opposite may as well have slid.
  transforms::Markers reference_mm(3, 4);
  reference_mm << 0, 100, 100, 0, 0, 0, 60, 60, 0, 0, 0, 0;
  transforms::Markers ct_mm = KnownPose() * reference_mm;
  reference_mm(0, 2) += 9.0;
  const auto search = SearchOutliers(reference_mm, ct_mm, 0.3);
  ASSERT_EQ(search.wrong.size(), 1U);
  EXPECT_TRUE(search.wrong[0] == 2 || !search.instead.empty());
}

TEST(SearchOutliers, IsQuietWithoutNoiseAndWithFewPoints) {
  EXPECT_THAT(SearchOutliers(SpreadMarkers(7), KnownPose() * SpreadMarkers(7), {}).wrong,
              IsEmpty());
  EXPECT_THAT(SearchOutliers(SpreadMarkers(3), NoisyMarkers(SpreadMarkers(3), 5, 0), {}).wrong,
              IsEmpty());
  transforms::Markers ct_mm = KnownPose() * SpreadMarkers(7);
  ct_mm(0, 2) += 1.0;
  const auto search = SearchOutliers(SpreadMarkers(7), ct_mm, {});
  EXPECT_THAT(search.wrong, ElementsAre(2));
  EXPECT_NEAR(search.error_mm[2], 1.0, 1e-9);
}

TEST(SearchOutliers, ContinuesWhereThereAreTooManySets) {
  const transforms::Markers reference_mm = SpreadMarkers(40);
  transforms::Markers ct_mm = NoisyMarkers(KnownPose() * reference_mm, 0.4, 2);
  for (const int i : {3, 9, 17, 25, 33, 38}) ct_mm.col(i) += Vector3d(5.0 + i, -i, 8);
  EXPECT_THAT(SearchOutliers(reference_mm, ct_mm, {}).wrong,
              UnorderedElementsAre(3, 9, 17, 25, 33, 38));
}

}  // namespace
}  // namespace acus::registration
