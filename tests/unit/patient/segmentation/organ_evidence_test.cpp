#include "acus/patient/segmentation/organ_evidence.h"

#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <sstream>
#include <tuple>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/words.h"

namespace acus::segmentation {
namespace {

/// An organ that an atlas found, with its Dice: a line of a run of segmentation_measures --organs.
struct OrganCase {
  std::string atlas;  ///< Its patient's name, without the place to which it was moved.
  OrganEvidence evidence;
  double dice = 0.0;
  bool is_sure = false;
};

std::vector<OrganCase> MeasuredCases() {
  std::vector<OrganCase> cases;
  const std::string text = ReadTextFile(ACUS_SOURCE_DIR "/testdata/organ_evidence.csv");
  for (const std::string_view line : LinesOf(text)) {
    std::istringstream in{std::string(line)};
    std::vector<std::string> cells;
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    if (cells.size() < 9 || cells[0] == "patient") continue;
    const auto number = [&](std::size_t n) { return std::stod(cells[n]); };
    OrganCase one;
    one.evidence = {.name = cells[3],
                    .edge_share = number(6),
                    .barred_share = number(7),
                    .covered_share = number(8)};
    one.atlas = cells[2].substr(0, cells[2].find(" moved"));
    one.dice = number(5);
    one.is_sure = cells[4] == "0" && DoubtsIn(one.evidence).empty();
    cases.push_back(one);
  }
  return cases;
}

TEST(OrganEvidence, NoMeasuredOrganThatIsWrongPassesAsSure) {
  const auto cases = MeasuredCases();
  ASSERT_GE(cases.size(), 40U);
  int wrong = 0;
  for (const OrganCase& one : cases) {
    if (one.is_sure) {
      EXPECT_GE(one.dice, kRightOrganDice) << one.evidence.name << " " << one.evidence.edge_share;
    }
    wrong += one.dice < kRightOrganDice ? 1 : 0;
  }
  EXPECT_GE(wrong, 30);
}

TEST(OrganEvidence, TheStatedCertaintyIsThatOfTheMeasuredCases) {
  // Several wrong places lead to the same result, which counts once.
  std::set<std::tuple<std::string, std::string, bool, long, long>> distinct;
  int all[2] = {}, right[2] = {};
  for (const OrganCase& one : MeasuredCases()) {
    const double edge = one.evidence.edge_share;
    const bool is_new = distinct
                            .emplace(one.atlas, one.evidence.name, one.is_sure,
                                     std::lround(50.0 * one.dice), std::lround(50.0 * edge))
                            .second;
    if (!is_new) continue;
    const int doubts = one.is_sure ? 0 : 1;
    ++all[doubts];
    right[doubts] += one.dice >= kRightOrganDice ? 1 : 0;
  }
  std::cout << "sure: " << right[0] << " of " << all[0] << " right, unsure: " << right[1] << " of "
            << all[1] << '\n';
  EXPECT_NEAR((right[0] + 1.0) / (all[0] + 2.0), 0.80, 0.005);  // As in quality_parts.cpp.
  EXPECT_NEAR((right[1] + 1.0) / (all[1] + 2.0), 0.17, 0.005);
}

TEST(OrganEvidence, TheExpectedDiceIsNearTheMeasuredOne) {
  std::vector<double> errors;
  for (const OrganCase& one : MeasuredCases()) {
    errors.push_back(std::abs(ExpectedDice(one.evidence) - one.dice));
  }
  std::ranges::sort(errors);
  EXPECT_LT(errors[errors.size() / 2], 0.04);
  std::cout << "median error " << errors[errors.size() / 2] << ", 90 % "
            << errors[errors.size() * 9 / 10] << '\n';
}

}  // namespace
}  // namespace acus::segmentation
