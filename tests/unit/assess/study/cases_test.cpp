#include "acus/assess/study/cases.h"

#include <gmock/gmock.h>
#include <map>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::study {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class Cases : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"a", "b", "c", "d"}) {
      WriteTextFile(folder_ / Message(name, ".json"),
                    Message(R"({"format": "acus-exercise/1", "name": "Case )", name, "\"}"));
    }
    WriteTextFile(folder_ / "cases.csv",
                  "exercise,difficulty\nd.json,0.9\na.json,0.1\nc.json,0.5\nb.json,0.3\n");
  }
  std::vector<std::string> Names(const std::vector<Case>& cases) {
    std::vector<std::string> names;
    for (const Case& one : cases) names.push_back(one.exercise);
    return names;
  }

  testing_support::TemporaryFolder folder_;
};

TEST_F(Cases, AreThoseOfTheRangeTheEasiestFirst) {
  EXPECT_THAT(Names(ReadCases(folder_ / "cases.csv", {})),
              testing::ElementsAre("Case a", "Case b", "Case c", "Case d"));
  EXPECT_THAT(Names(ReadCases(folder_ / "cases.csv", {0.3, 0.5})),
              testing::ElementsAre("Case b", "Case c"));
  EXPECT_EQ(ReadCases(folder_ / "cases.csv", {0.2, 0.4}).front().file, folder_ / "b.json");
}

TEST_F(Cases, AreRefusedWithTheRow) {
  const auto reading = [this](const std::string& rows, const DifficultyRange& range) {
    WriteTextFile(folder_ / "wrong.csv", "exercise,difficulty\n" + rows);
    return [this, range] { ReadCases(folder_ / "wrong.csv", range); };
  };
  EXPECT_THAT(reading("a.json,1.5\n", {}),
              ThrowsMessage<InputError>(HasSubstr("wrong.csv:2: difficulty is 1.5")));
  EXPECT_THAT(reading("a.json,0.5\na.json,0.6\n", {}),
              ThrowsMessage<InputError>(HasSubstr("wrong.csv:3: another row")));
  EXPECT_THAT(reading("a.json,0.5\n", {0.6, 0.9}),
              ThrowsMessage<InputError>(HasSubstr("no case has a difficulty from 0.6 to 0.9")));
  EXPECT_THAT(reading("none.json,0.5\n", {}), ThrowsMessage<InputError>(HasSubstr("none.json")));
}

TEST_F(Cases, LeastDoneGivesEachTraineeAllCasesEquallyOftenInAnOrderOfTheirOwn) {
  const auto cases = ReadCases(folder_ / "cases.csv", {});
  std::map<std::string, int> first;
  for (int person = 0; person < 40; ++person) {
    const std::string code = Message("T", person);
    std::vector<CaseTrial> trials;
    std::map<std::string, int> done;
    for (int n = 0; n < 8; ++n) {
      const Case& next = NextCase(cases, CaseOrder::kLeastDone, code, trials);
      EXPECT_EQ(&next, &NextCase(cases, CaseOrder::kLeastDone, code, trials));
      if (n == 0) ++first[next.exercise];
      ++done[next.exercise];
      trials.push_back({next.exercise, n % 2 == 0});
    }
    for (const auto& [name, count] : done) EXPECT_EQ(count, 2) << code << ' ' << name;
  }
  ASSERT_EQ(first.size(), 4U);
  // 10 of 40 each; fewer than 3 or more than 20 has a probability below 0.002.
  for (const auto& [name, count] : first)
    EXPECT_THAT(count, testing::AllOf(testing::Ge(3), testing::Le(20)));
}

TEST_F(Cases, TheStaircaseRisesWithSuccessAndFallsWithFailure) {
  const auto cases = ReadCases(folder_ / "cases.csv", {});
  std::vector<CaseTrial> trials;
  const auto next = [&] { return NextCase(cases, CaseOrder::kStaircase, "A", trials).exercise; };
  EXPECT_EQ(next(), "Case a");
  for (const auto& [succeeds, then] : std::vector<std::pair<bool, std::string>>{{true, "Case b"},
                                                                                {true, "Case c"},
                                                                                {false, "Case b"},
                                                                                {false, "Case a"},
                                                                                {false, "Case a"},
                                                                                {true, "Case b"},
                                                                                {true, "Case c"},
                                                                                {true, "Case d"},
                                                                                {true, "Case d"}}) {
    trials.push_back({next(), succeeds});
    EXPECT_EQ(next(), then);
  }
  trials.push_back({"another exercise", false});
  EXPECT_EQ(next(), "Case d");
}

}  // namespace
}  // namespace acus::study
