#include "support/bound.h"

#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>
#include <limits>

#include "acus/base/core/atomic_file.h"
#include "support/temporary_folder.h"

namespace acus::testing_support {
namespace {

using nlohmann::json;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Bound, EachSenseHoldsUpToItsValueAndNotBeyond) {
  EXPECT_TRUE(Below(1.0).Holds(std::nextafter(1.0, 0.0)));
  EXPECT_FALSE(Below(1.0).Holds(1.0));
  EXPECT_TRUE(AtMost(1.0).Holds(1.0));
  EXPECT_FALSE(AtMost(1.0).Holds(std::nextafter(1.0, 2.0)));
  EXPECT_TRUE(Above(1.0).Holds(std::nextafter(1.0, 2.0)));
  EXPECT_FALSE(Above(1.0).Holds(1.0));
  EXPECT_TRUE(AtLeast(1.0).Holds(1.0));
  EXPECT_FALSE(AtLeast(1.0).Holds(std::nextafter(1.0, 0.0)));
  EXPECT_TRUE(Exactly(0.0).Holds(0.0));
  EXPECT_FALSE(Exactly(0.0).Holds(5e-324));
}

TEST(Bound, ANumberThatIsNoneHoldsNothing) {
  for (const Bound& bound : {Below(1.0), AtMost(1.0), Above(1.0), AtLeast(1.0), Exactly(kNan)}) {
    EXPECT_FALSE(bound.Holds(kNan)) << bound.Sign();
  }
}

TEST(Bound, AValueOverItsBoundFailsTheTest) {
  const HardCase hard("Nothing is.");
  hard.Expect("error", 0.5, AtMost(0.5), "mm");
  EXPECT_NONFATAL_FAILURE(HardCase("It is.").Expect("error", 0.75, AtMost(0.5), "mm"),
                          "error: 0.75 mm is not <= 0.5 mm\nIt is.");
  EXPECT_NONFATAL_FAILURE(HardCase("It is.").Expect("least", 0.4, AtLeast(0.5)), "is not >= 0.5");
  EXPECT_NONFATAL_FAILURE(HardCase("It is.").Expect("bits", 1.0, Exactly(0.0)), "is not == 0");
}

TEST(Bound, NothingThatIsNotFiniteHolds) {
  EXPECT_NONFATAL_FAILURE(HardCase("").Expect("a", kNan, AtMost(1.0)), "nan");
  EXPECT_NONFATAL_FAILURE(HardCase("").Expect("b", -kInfinity, AtMost(1.0)), "-inf");
  EXPECT_NONFATAL_FAILURE(HardCase("").Expect("c", kInfinity, AtLeast(1.0)), "inf");
  EXPECT_NONFATAL_FAILURE(HardCase("").Expect("d", 1.0, AtMost(kInfinity)), "inf");
  EXPECT_NONFATAL_FAILURE(HardCase("").Expect("e", 1.0, Below(kNan)), "nan");
}

TEST(Bound, LargestAndSmallestKeepWhatIsNoNumber) {
  Largest largest;
  EXPECT_EQ(largest, 0.0);
  for (const double value : {1.0, 3.0, 2.0}) largest.Add(value);
  EXPECT_EQ(largest, 3.0);
  largest.Add(kNan);
  largest.Add(4.0);
  EXPECT_TRUE(std::isnan(largest));
  Smallest smallest;
  EXPECT_EQ(smallest, kInfinity);
  for (const double value : {2.0, -3.0, 1.0}) smallest.Add(value);
  EXPECT_EQ(smallest, -3.0);
  smallest.Add(kNan);
  smallest.Add(-4.0);
  EXPECT_TRUE(std::isnan(smallest));
}

class KeptBounds : public testing::Test {
 protected:
  void SetUp() override { setenv("ACUS_BOUNDS", (folder_ / "kept").c_str(), 1); }
  void TearDown() override { unsetenv("ACUS_BOUNDS"); }

  std::vector<json> Kept() const {
    std::vector<json> records;
    std::istringstream lines(ReadTextFile(folder_ / "kept/stability_page.jsonl"));
    for (std::string line; std::getline(lines, line);) records.push_back(json::parse(line));
    return records;
  }
  TemporaryFolder folder_;
};

TEST_F(KeptBounds, AreOneLineEach) {
  const HardCase hard("Text with \"quotes\",\nlines and µ.");
  hard.Expect("error", 0.25, Below(0.5), "mm");
  hard.Plot({.title = "t",
             .x_label = "x [s]",
             .y_label = "y [N]",
             .log_y = true,
             .curves = {{.name = "force", .x = {0, 1}, .y = {2, 3}}}});
  hard.Note("seed", "7");
  const std::vector<json> kept = Kept();
  ASSERT_EQ(kept.size(), 3u);
  for (const json& record : kept) {
    EXPECT_EQ(record["module"], "stability_page");
    EXPECT_EQ(record["file"], "tests/stability_page/bound_test.cpp");
    EXPECT_EQ(record["suite"], "KeptBounds");
    EXPECT_EQ(record["test"], "AreOneLineEach");
    EXPECT_EQ(record["hard"], "Text with \"quotes\",\nlines and µ.");
  }
  EXPECT_EQ(kept[0]["kind"], "bound");
  EXPECT_EQ(kept[0]["quantity"], "error");
  EXPECT_EQ(kept[0]["measured"], 0.25);
  EXPECT_EQ(kept[0]["sense"], "<");
  EXPECT_EQ(kept[0]["bound"], 0.5);
  EXPECT_EQ(kept[0]["unit"], "mm");
  EXPECT_EQ(kept[0]["holds"], true);
  EXPECT_EQ(kept[1]["curves"][0]["y"], json({2.0, 3.0}));
  EXPECT_EQ(kept[1]["log_y"], true);
  EXPECT_EQ(kept[2]["value"], "7");
}

TEST_F(KeptBounds, WhatFailsIsKeptToo) {
  EXPECT_NONFATAL_FAILURE(HardCase("It is.").Expect("force", kNan, Below(0.5), "N"), "force");
  const std::vector<json> kept = Kept();
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0]["holds"], false);
  EXPECT_TRUE(kept[0]["measured"].is_null());
}

}  // namespace
}  // namespace acus::testing_support
