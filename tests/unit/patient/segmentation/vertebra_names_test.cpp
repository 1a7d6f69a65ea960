#include "acus/patient/segmentation/vertebra_names.h"

#include <gmock/gmock.h>

namespace acus::segmentation {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// From T11 to the sacrum, as a CT of an abdomen and pelvis shows them.
std::vector<VertebraEvidence> ThoracicToSacrum(int num_lumbar = 5) {
  std::vector<VertebraEvidence> list;
  for (int n = 0; n < 2 + num_lumbar; ++n) {
    VertebraEvidence v{.is_whole = true, .shows_flanks = true};
    v.reach_mm = n < 2 ? std::array{74.0, 73.0} : std::array{40.0, 45.0};
    v.height_mm = 28.0 + n;
    list.push_back(v);
  }
  list.push_back({.is_whole = false, .shows_flanks = true, .reach_mm = {75.0, 75.0}});
  return list;
}

TEST(VertebraNames, FollowFromTheSacrumAndTheLastRib) {
  const auto both = NameVertebrae(ThoracicToSacrum(), std::nullopt, true);
  EXPECT_EQ(both.from, NamedFrom::kSacrumAndLastRib);
  EXPECT_THAT(both.names, ElementsAre("T11", "T12", "L1", "L2", "L3", "L4", "L5", "S1"));
  auto no_flanks = ThoracicToSacrum();
  for (auto& v : no_flanks) v.shows_flanks = false;
  const auto sacrum = NameVertebrae(no_flanks, std::nullopt, true);
  EXPECT_EQ(sacrum.from, NamedFrom::kSacrum);
  EXPECT_EQ(sacrum.names, both.names);
  const auto rib = NameVertebrae(ThoracicToSacrum(), std::nullopt, false);
  EXPECT_EQ(rib.from, NamedFrom::kLastRib);
  EXPECT_EQ(rib.names, both.names);
}

TEST(VertebraNames, AreNumbersIfNothingFixesThem) {
  auto list = ThoracicToSacrum();
  list.resize(3);  // One vertebra without ribs is not enough: its rib may be short.
  const auto found = NameVertebrae(list, std::nullopt, false);
  EXPECT_EQ(found.from, NamedFrom::kNothing);
  EXPECT_THAT(found.names, ElementsAre("vertebra_1", "vertebra_2", "vertebra_3"));
  EXPECT_THAT(found.doubt, HasSubstr("neither the sacrum"));
}

TEST(VertebraNames, AreNumbersIfSacrumAndRibsContradictEachOther) {
  for (const int lumbar : {4, 6}) {
    const auto found = NameVertebrae(ThoracicToSacrum(lumbar), std::nullopt, true);
    EXPECT_EQ(found.from, NamedFrom::kNothing) << lumbar;
    EXPECT_THAT(found.doubt, HasSubstr("not 5"));
  }
}

TEST(VertebraNames, ARibThatMayBelongToTheNextFixesNothing) {
  auto list = ThoracicToSacrum();
  list.erase(list.begin());
  list.front().is_whole = false;
  EXPECT_EQ(NameVertebrae(list, std::nullopt, false).from, NamedFrom::kNothing);
  EXPECT_EQ(NameVertebrae(list, std::nullopt, true).from, NamedFrom::kSacrumAndLastRib);
  for (const double reach : {58.0, 61.0}) {  // Neither rib nor transverse process.
    auto short_ribs = ThoracicToSacrum();
    short_ribs[2].reach_mm = {reach, reach};
    EXPECT_EQ(NameVertebrae(short_ribs, std::nullopt, false).from, NamedFrom::kNothing);
  }
}

TEST(VertebraNames, OfANeckAreNoLumbarOnes) {
  // Vertebrae of 18 mm, below which bone on both sides looks like a sacrum.
  auto list = ThoracicToSacrum();
  for (auto& v : list) v.height_mm = v.is_whole ? 18.0 : 0.0;
  for (auto& v : list) v.shows_flanks = false;
  const auto found = NameVertebrae(list, std::nullopt, true);
  EXPECT_EQ(found.from, NamedFrom::kNothing);
  EXPECT_THAT(found.doubt, HasSubstr("lower than lumbar"));
}

TEST(VertebraNames, EndWhereHeightsBreakOffAndWhereADiscLiesBetweenPedicles) {
  auto list = ThoracicToSacrum();
  list[2].height_mm = 60.0;  // Two vertebrae, whose disc was missed.
  for (auto& v : list) v.shows_flanks = false;
  const auto found = NameVertebrae(list, std::nullopt, true);
  EXPECT_THAT(found.names,
              ElementsAre("vertebra_1", "vertebra_2", "vertebra_3", "L2", "L3", "L4", "L5", "S1"));
  EXPECT_THAT(found.doubt, HasSubstr("beyond L2"));
  auto parted = ThoracicToSacrum();
  parted[3].lies_on_open_disc = false;
  EXPECT_THAT(NameVertebrae(parted, std::nullopt, true).doubt, HasSubstr("between pedicles"));
}

TEST(VertebraNames, ThatAreGivenWin) {
  auto list = ThoracicToSacrum();
  list[3].known = NumberOfVertebra("L3");
  const auto imported = NameVertebrae(list, std::nullopt, false);
  EXPECT_EQ(imported.from, NamedFrom::kImport);
  EXPECT_EQ(imported.names[2], "L2");
  const auto user = NameVertebrae(list, GivenName{3, *NumberOfVertebra("L1")}, false);
  EXPECT_EQ(user.from, NamedFrom::kUser);
  EXPECT_EQ(user.names[3], "L1");
}

}  // namespace
}  // namespace acus::segmentation
