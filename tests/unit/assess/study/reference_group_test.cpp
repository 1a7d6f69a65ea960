#include "acus/assess/study/reference_group.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/assess/study/reference_page.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/exact_intervals.h"
#include "support/temporary_folder.h"

namespace acus::study {
namespace {

using testing::DoubleNear;
using testing::HasSubstr;
using testing::ThrowsMessage;

class ReferenceGroup : public testing::Test {
 protected:
  static training::Assessment Session(const std::string& code, double distance_mm,
                                      const std::string& exercise = "Puncture") {
    training::Assessment session;
    session.exercise = exercise;
    session.trainee = code;
    session.metrics = {{"tip to target at the end", "mm", distance_mm}, {"passes", "", 1.0}};
    training::GoalResult goal;
    goal.goal.metric = "tip to target at the end";
    goal.goal.at_most = 3.0;
    goal.unit = "mm";
    goal.value = distance_mm;
    goal.met = distance_mm <= 3.0;
    session.goals = {goal};
    return session;
  }
  void Write(const training::Assessment& session, const std::string& folder) {
    config::WriteJson(folder_ / "group" / folder / "training.json", training::ToJson(session));
  }
  GroupComparison Compare(const std::vector<training::Assessment>& sessions) {
    const std::vector<std::filesystem::path> folders = {folder_ / "group"};
    return CompareWithGroup(sessions, folders, context_);
  }
  static const Standing& OfDistance(const GroupComparison& comparison) {
    return *std::ranges::find(comparison.standings, "tip to target at the end",
                              [](const Standing& s) { return s.metric.name; });
  }

  testing_support::TemporaryFolder folder_;
  RunContext context_;
};

TEST_F(ReferenceGroup, IsOfThePersonsMeansWithoutTheTrainee) {
  Write(Session("B", 1.0), "b1");
  Write(Session("B", 3.0), "b2");
  Write(Session("C", 4.0), "c");
  Write(Session("D", 6.0), "d");
  Write(Session("A", 100.0), "a");
  Write(Session("E", 100.0, "Another"), "e");
  const GroupComparison comparison = Compare({Session("A", 9.0), Session("A", 4.0)});
  EXPECT_EQ(comparison.code, "A");
  EXPECT_EQ(comparison.num_persons, 3);
  EXPECT_EQ(comparison.num_trials, 4);
  const Standing& distance = OfDistance(comparison);
  EXPECT_THAT(distance.persons, testing::ElementsAre(2.0, 4.0, 6.0));
  EXPECT_EQ(distance.group_mean, 4.0);
  EXPECT_EQ(distance.value, 4.0);
  EXPECT_THAT(distance.earlier, testing::ElementsAre(9.0));
  EXPECT_FALSE(distance.earlier_median) << "one session is no sample";
  EXPECT_EQ(distance.percentile, 50.0) << "one below, one equal";
  ASSERT_TRUE(distance.percentile_interval && distance.group_interval);
  EXPECT_EQ(distance.percentile_interval->low, 100.0 * math::ShareInterval(1, 3, 0.95).low);
  EXPECT_EQ(distance.percentile_interval->high, 100.0 * math::ShareInterval(2, 3, 0.95).high);
  EXPECT_GE(distance.group_interval->low, 2.0);
  EXPECT_LE(distance.group_interval->high, 6.0);
  EXPECT_TRUE(distance.is_of_goal);
  EXPECT_FALSE(comparison.standings.back().is_of_goal) << "goals come first";
}

TEST_F(ReferenceGroup, OfTwoPersonsHasNoIntervals) {
  Write(Session("B", 1.0), "b");
  Write(Session("C", 4.0), "c");
  const GroupComparison comparison = Compare({Session("A", 2.0)});
  EXPECT_FALSE(OfDistance(comparison).group_interval);
  EXPECT_FALSE(OfDistance(comparison).percentile_interval);
  EXPECT_THAT(ReferenceText(comparison), HasSubstr("too few persons for intervals"));
}

TEST_F(ReferenceGroup, KnowsTheEarlierSessionsOfTheTraineeAlone) {
  Write(Session("B", 1.0), "b");
  std::vector<training::Assessment> sessions = {Session("C", 50.0)};
  for (const double distance : {7.0, 3.0, 5.0, 4.0, 6.0, 8.0, 2.0}) {
    sessions.push_back(Session("A", distance));
  }
  const auto& standing = OfDistance(Compare(sessions));
  EXPECT_EQ(standing.value, 2.0);
  EXPECT_EQ(standing.earlier.size(), 6U);
  ASSERT_TRUE(standing.earlier_median);
  EXPECT_EQ(standing.earlier_median->low, 3.0);
  EXPECT_EQ(standing.earlier_median->high, 8.0);
}

TEST_F(ReferenceGroup, IsRefusedWhereItIsNone) {
  std::filesystem::create_directories(folder_ / "group");
  const std::vector<training::Assessment> sessions = {Session("A", 2.0)};
  EXPECT_THAT([&] { Compare(sessions); },
              ThrowsMessage<InputError>(HasSubstr("group: no trial was found")));
  Write(Session("B", 1.0, "Another"), "b");
  EXPECT_THAT([&] { Compare(sessions); },
              ThrowsMessage<InputError>(
                  HasSubstr("no trial is of the exercise \"Puncture\"; there are \"Another\"")));
  Write(Session("A", 1.0), "a");
  EXPECT_THAT([&] { Compare(sessions); },
              ThrowsMessage<InputError>(HasSubstr("all trials are those of A")));
}

TEST_F(ReferenceGroup, TableAndPageHaveTheSameNumbersForTheSameSeed) {
  for (const char* code : {"B", "C", "D", "E"}) Write(Session(code, code[0] - 'A'), code);
  const std::vector<training::Assessment> sessions = {Session("A", 2.5)};
  const std::string csv = ReferenceCsv(Compare(sessions));
  EXPECT_EQ(csv, ReferenceCsv(Compare(sessions)));
  EXPECT_THAT(csv, HasSubstr("\nA,Puncture,tip to target at the end,mm,2.5,0,,,,4,2.5,"));
  WriteProgress(folder_ / "page", sessions, Compare(sessions), context_);
  EXPECT_EQ(ReadTextFile(folder_ / "page/reference.csv"), csv);
  const std::string page = ReadTextFile(folder_ / "page/progress.html");
  EXPECT_THAT(page, HasSubstr("Reference group: 4 persons, 4 trials"));
  // Four persons and the newest session in each strip: distance, goals met, score.
  std::size_t dots = 0;
  for (std::size_t at = page.find("<circle cx"); at != std::string::npos;
       at = page.find("<circle cx", at + 1)) {
    ++dots;
  }
  EXPECT_GE(dots, 15U);
}

}  // namespace
}  // namespace acus::study
