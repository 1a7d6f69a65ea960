#include <CLI/CLI.hpp>
#include <algorithm>
#include <gmock/gmock.h>
#include <map>
#include <regex>

#include "acus/assess/study/box_plot.h"
#include "acus/assess/study/curriculum.h"
#include "acus/assess/study/curriculum_command.h"
#include "acus/assess/study/study_command.h"
#include "acus/assess/study/study_export.h"
#include "acus/assess/study/study_report.h"
#include "acus/assess/study/study_tables.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/run/training/assessment.h"
#include "acus/run/training/discarded.h"
#include "support/temporary_folder.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kStudy = R"({
  "format": "acus-study/1", "name": "Test", "groups": ["novice", "expert"],
  "participants": [
    {"code": "N1", "group": "novice", "consent": true}, {"code": "N2", "group": "novice", "consent": true},
    {"code": "N3", "group": "novice"}, {"code": "E_1", "group": "expert", "consent": true},
    {"code": "E2", "group": "expert", "consent": true, "hand": "left"}],
  "exercises": ["a.json", "b.json", "c.json"], "trials": 2, "order": "balanced", "seed": 5,
  "questionnaires": ["q.json"]})";
constexpr const char* kQuestions = R"({
  "format": "acus-questionnaire/1", "key": "face", "title": "Face", "scale": ["no", "so", "yes"],
  "items": [{"key": "looks", "text": "It looks real."},
            {"key": "bad", "text": "It is bad.", "reversed": true}]})";

class StudyTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const std::string key : {"a", "b", "c"}) {
      WriteTextFile(folder_ / (key + ".json"),
                    R"({"format": "acus-exercise/1", "name": "Exercise )" + key + "\"}");
    }
    WriteTextFile(folder_ / "q.json", kQuestions);
    Write(kStudy);
  }
  void Write(const std::string& text) { WriteTextFile(folder_ / "study.json", text); }
  Study Read() const { return ReadStudy(folder_ / "study.json"); }

  /// Novices take 20 s less each trial, experts always 30 s.
  void WriteTrials() {
    for (const auto& [code, seconds] :
         {std::pair{"N1", 80.0}, {"N2", 90.0}, {"N3", 70.0}, {"E_1", 30.0}, {"E2", 32.0}}) {
      for (int trial = 1; trial <= 2; ++trial) {
        const fs::path into = folder_ / "trials" / code / Message("trial_", trial + 8);
        fs::create_directories(into);
        training::Assessment a;
        a.exercise = "Exercise a";
        a.trainee = code;
        const bool novice = code[0] == 'N';
        a.metrics = {{"time", "s", seconds - (novice ? 20.0 * (trial - 1) : 0.0)},
                     {"attempts", "", 1.0}};
        a.goals = {{{"time", 50.0, std::nullopt, ""}, "s", a.metrics[0].value, !novice}};
        config::WriteJson(into / "training.json", training::ToJson(a));
        WriteTextFile(into / "events.csv",
                      "time_s,event,tissue,depth_mm,force_axial_n,force_before_n\n"
                      "1.5,contact,skin,0,0.1,0\n");
      }
    }
  }
  std::vector<TrialRecord> Trials(const fs::path& path) {
    const std::vector<fs::path> paths = {path};
    return ReadTrials(paths, Read(), context_);
  }

  testing_support::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
  RunContext context_;
};

TEST_F(StudyTest, EachExerciseStandsAtEachPlaceEquallyOften) {
  Study study = Read();
  study.participants.clear();
  for (int i = 0; i < 9; ++i)
    study.participants.push_back({Message("P", i), "novice", true, "right"});
  std::map<std::pair<std::string, std::size_t>, int> count;
  for (const PlannedOrder& order : PlanOrder(study)) {
    for (std::size_t place = 0; place < 3; ++place) ++count[{order.exercises[place], place}];
  }
  EXPECT_EQ(count.size(), 9U);
  for (const auto& [key, n] : count) EXPECT_EQ(n, 3);
}

TEST_F(StudyTest, RandomOrdersArePermutationsBySeed) {
  Study study = Read();
  study.order = OrderKind::kRandom;
  const std::string first = OrderCsv(study);
  EXPECT_EQ(first, OrderCsv(study));
  for (const PlannedOrder& order : PlanOrder(study)) {
    EXPECT_THAT(order.exercises, testing::UnorderedElementsAreArray(study.exercises));
  }
  study.seed = 6;
  EXPECT_NE(first, OrderCsv(study));
  study.order = OrderKind::kFixed;
  EXPECT_EQ(PlanOrder(study)[3].exercises, study.exercises);
}

TEST_F(StudyTest, ReadsTrialsInTheirOrderAndNoneWithoutConsent) {
  WriteTrials();
  std::vector<std::string> warnings;
  context_.on_warning = [&](std::string_view text) { warnings.emplace_back(text); };
  const auto trials = Trials(folder_ / "trials");
  ASSERT_EQ(trials.size(), 8U);
  EXPECT_EQ(trials[0].code, "N1");
  EXPECT_EQ(trials[0].trial, 1);
  EXPECT_EQ((trials[0].metrics.at({"time", "s"})), 80.0) << "trial_9 is before trial_10";
  EXPECT_EQ((trials[1].metrics.at({"time", "s"})), 60.0);
  EXPECT_EQ((trials[0].metrics.at({kGoalsMet, "%"})), 0.0);
  EXPECT_NEAR((trials[0].metrics.at({kScore, "%"})), 100.0 * 50.0 / 80.0, 1e-12);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], HasSubstr("N3 has not given consent"));
}

TEST_F(StudyTest, EveryTableComesAgainFromTheRawTable) {
  WriteTrials();
  WriteTextFile(folder_ / "answers.csv",
                "code,questionnaire,item,answer\nN1,face,looks,3\nN1,face,bad,1\n"
                "E2,face,looks,2\nE2,face,bad,3\nN2,face,looks,\nN3,face,looks,1\n");
  const Study study = Read();
  const auto report = [&](const fs::path& trials_path, const fs::path& answers_path,
                          const fs::path& into) {
    fs::create_directory(into);
    const auto trials = Trials(trials_path);
    const auto answers = ReadAnswers(answers_path, study, context_);
    WriteStudyReport(into, study, trials, answers, Analyse(study, trials, answers), context_);
  };
  report(folder_ / "trials", folder_ / "answers.csv", folder_ / "one");
  report(folder_ / "one/trials.csv", folder_ / "one/answers.csv", folder_ / "two");
  for (const char* file : {"trials.csv", "answers.csv", "descriptive.csv", "comparison.csv",
                           "learning.csv", "reliability.csv", "items.csv"}) {
    EXPECT_EQ(ReadTextFile(folder_ / "one" / file), ReadTextFile(folder_ / "two" / file)) << file;
  }
  EXPECT_THAT(ReadTextFile(folder_ / "one/study.html"),
              testing::AllOf(HasSubstr("Not distinguished by: attempts (p 1.000)"),
                             HasSubstr("It looks real."), HasSubstr("Cronbach")));
}

TEST_F(StudyTest, ComparesTheGroups) {
  WriteTrials();
  const auto trials = Trials(folder_ / "trials");
  const StudyAnalysis analysis = Analyse(Read(), trials, {});
  const auto time = std::ranges::find_if(
      analysis.metrics, [](const MetricAnalysis& a) { return a.metric.name == "time"; });
  ASSERT_NE(time, analysis.metrics.end());
  EXPECT_EQ(time->groups[0].values, (std::vector<double>{70.0, 80.0})) << "means of the trials";
  ASSERT_TRUE(time->comparison);
  EXPECT_EQ(time->comparison->auc, 0.0);
  EXPECT_EQ(time->comparison->DirectedAuc(), 1.0);
  EXPECT_FALSE(time->comparison->separates) << "two against two are no evidence";
  EXPECT_FALSE(time->comparison->delta_interval) << "nor is a bootstrap of two values";
  ASSERT_TRUE(time->comparison->g_interval);
  EXPECT_GT(time->comparison->g_interval->high, -5.0) << "wide, as two values are";
  EXPECT_GT(time->comparison->g_interval->low, -20.0) << "but not without bounds";
  EXPECT_THAT(
      StudyText(Read(), trials, analysis),
      testing::AllOf(HasSubstr("Too few participants to distinguish the groups: with 2 and 2 "
                               "and 4 metrics p (Holm) cannot be below 1"),
                     HasSubstr("distinguish novice from expert: none\n")));
  EXPECT_NEAR(time->comparison->test.p, 1.0 / 3.0, 1e-12) << "two of four values: 2 / 6";
  ASSERT_EQ(time->learning.size(), 2U);
  EXPECT_NEAR(time->learning[0].slopes[0], std::log(60.0 / 80.0) / std::log(2.0), 1e-12);
  EXPECT_NEAR(time->learning[1].slopes[0], 0.0, 1e-12);
  EXPECT_EQ(time->learning[0].mean_by_trial, (std::vector<double>{85.0, 65.0}));
}

TEST_F(StudyTest, EnoughParticipantsAreDistinguished) {
  Study study = Read();
  std::vector<TrialRecord> trials;
  study.participants.clear();
  for (int i = 0; i < 12; ++i) {
    const bool novice = i < 6;
    study.participants.push_back({Message("P", i), novice ? "novice" : "expert", true, "right"});
    TrialRecord trial{.code = Message("P", i), .exercise = "Exercise a", .metrics = {}};
    trial.metrics[{"time", "s"}] = (novice ? 80.0 : 30.0) + i;
    trials.push_back(trial);
  }
  const StudyAnalysis analysis = Analyse(study, trials, {});
  ASSERT_EQ(analysis.metrics.size(), 1U);
  EXPECT_TRUE(analysis.metrics[0].comparison->separates);
  ASSERT_TRUE(analysis.metrics[0].comparison->delta_interval);
  EXPECT_THAT(StudyText(study, trials, analysis),
              testing::AllOf(HasSubstr("distinguish novice from expert: time (1.00)"),
                             testing::Not(HasSubstr("Too few"))));
}

TEST_F(StudyTest, SaysThatTraineesWereVirtual) {
  WriteTrials();
  auto trials = Trials(folder_ / "trials");
  EXPECT_THAT(StudyText(Read(), trials, Analyse(Read(), trials, {})),
              testing::Not(HasSubstr("virtual")));
  trials[3].by_virtual_trainee = true;
  const StudyAnalysis analysis = Analyse(Read(), trials, {});
  EXPECT_THAT(StudyText(Read(), trials, analysis), HasSubstr("1 of 8 trials are of virtual"));
  fs::create_directory(folder_ / "report");
  WriteStudyReport(folder_ / "report", Read(), trials, {}, analysis, context_);
  const std::string page = ReadTextFile(folder_ / "report/study.html");
  EXPECT_LT(page.find("are of virtual trainees"), page.find("Participants"));
  EXPECT_EQ(TrialsCsv(Read(), Trials(folder_ / "report/trials.csv")), TrialsCsv(Read(), trials));
}

TEST_F(StudyTest, ReversedItemsAreCountedFromTheOtherEnd) {
  const Study study = Read();
  const std::vector<Answer> answers = {{"N1", "face", "bad", 1}, {"N2", "face", "bad", 2}};
  const StudyAnalysis analysis = Analyse(study, {}, answers);
  const ItemAnalysis& bad = analysis.questionnaires[0].items[1];
  ASSERT_TRUE(bad.groups[0]);
  EXPECT_EQ(bad.groups[0]->mean, 2.5);
  EXPECT_EQ(bad.counts, (std::vector<int>{1, 1, 0}));
}

TEST_F(StudyTest, ExportsAfterBids) {
  WriteTrials();
  const auto trials = Trials(folder_ / "trials");
  fs::create_directory(folder_ / "bids");
  WriteBids(folder_ / "bids", Read(), trials, context_);
  EXPECT_THAT(ReadTextFile(folder_ / "bids/participants.tsv"),
              testing::AllOf(HasSubstr("sub-E1\texpert\tright"), HasSubstr("sub-E2\texpert\tleft"),
                             testing::Not(HasSubstr("N3"))));
  EXPECT_THAT(
      ReadTextFile(folder_ / "bids/sub-N1/beh/sub-N1_task-ExerciseA_run-02_events.tsv"),
      HasSubstr("onset\tduration\ttrial_type\ttissue\tdepth_mm\tforce_axial_n\n1.5\t0\tcontact"));
  EXPECT_THAT(ReadTextFile(folder_ / "bids/sub-N1/beh/sub-N1_task-ExerciseA_run-02_beh.tsv"),
              HasSubstr("time"));
}

TEST_F(StudyTest, SaysWhatIsWrong) {
  const auto replaced = [](std::string text, const std::string& what, const std::string& by) {
    return text.replace(text.find(what), what.size(), by);
  };
  const auto read = [&] { Read(); };
  Write(replaced(kStudy, "\"N2\"", "\"N1\""));
  EXPECT_THAT(read, ThrowsMessage<InputError>(HasSubstr("/participants/1: the code N1 is there")));
  Write(replaced(kStudy, "\"group\": \"expert\"", "\"group\": \"master\""));
  EXPECT_THAT(read, ThrowsMessage<InputError>(HasSubstr("\"master\" is not among /groups")));
  Write(replaced(kStudy, "b.json", "a.json\", \"b.json"));
  EXPECT_THAT(read, ThrowsMessage<InputError>(HasSubstr("/exercises")));
  Write(kStudy);
  WriteTrials();
  Write(replaced(kStudy, "E_1", "E9"));
  EXPECT_THAT([&] { Trials(folder_ / "trials"); },
              ThrowsMessage<InputError>(HasSubstr("the code \"E_1\" is not among")));
  Write(kStudy);
  const auto answers = [&](const std::string& row) {
    WriteTextFile(folder_ / "answers.csv", "code,questionnaire,item,answer\n" + row + "\n");
    return [this] { ReadAnswers(folder_ / "answers.csv", Read(), context_); };
  };
  EXPECT_THAT(answers("N1,face,looks,4"),
              ThrowsMessage<InputError>(HasSubstr("answers.csv:2: the answer 4 is off the scale")));
  EXPECT_THAT(answers("N1,face,looks,yes"), ThrowsMessage<InputError>(HasSubstr("whole number")));
  EXPECT_THAT(answers("N1,face,luks,1"), ThrowsMessage<InputError>(HasSubstr("no item \"luks\"")));
  EXPECT_THAT(answers("N1,face,looks,1\nN1,face,looks,1"),
              ThrowsMessage<InputError>(HasSubstr("given twice")));
  fs::create_directory(folder_ / "empty");
  EXPECT_THAT([&] { Trials(folder_ / "empty"); },
              ThrowsMessage<InputError>(HasSubstr("no trial was found")));
}

/// A trial of "A" with a score; all goals are met from 90 on.
TrialRecord Scored(const std::string& exercise, double score) {
  TrialRecord trial{"A", exercise, 1, {}, {}};
  trial.metrics[{kScore, "%"}] = score;
  trial.metrics[{kGoalsMet, "%"}] = score >= 90.0 ? 100.0 : 50.0;
  return trial;
}

TEST_F(StudyTest, DiscardedSessionsDoNotCount) {
  WriteTrials();
  EXPECT_EQ(Trials(folder_ / "trials").size(), 8U);
  // The session's folder holds the run's, as in a workplace.
  const fs::path session = folder_ / "trials" / "N1" / "session_1";
  fs::create_directories(session);
  fs::rename(folder_ / "trials" / "N1" / "trial_9", session / "report");
  EXPECT_EQ(Trials(folder_ / "trials").size(), 8U);
  WriteTextFile(session / training::kDiscardedFile, R"({"reason": "cable loose"})");
  const std::vector<TrialRecord> kept = Trials(folder_ / "trials");
  EXPECT_EQ(kept.size(), 7U);
  EXPECT_EQ(kept.front().code, "N1");
  EXPECT_EQ(kept.front().trial, 1) << "the one that is left is the first";
  const std::vector<fs::path> folders = {folder_ / "trials"};
  EXPECT_EQ(FindTrials(folders, context_).size(), 9U);

  const std::vector<fs::path> runs = {session / "report", folder_ / "trials/N2/trial_9"};
  EXPECT_EQ(training::KeptRuns(runs, context_), (std::vector<fs::path>{runs[1]}));
  EXPECT_THROW(training::KeptRuns(std::span(runs).first(1), context_), InputError);
}

TEST_F(StudyTest, RecordedConsentTakesThePlaceOfTheStudys) {
  Study study = Read();
  const fs::path file = folder_ / "consent.csv";
  WriteTextFile(file, "code,consent,time\nN3,no,9:00\nN3,yes,9:05\nN1,no,9:10\nguest,yes,9:20\n");
  ReadConsents(file, study, context_);
  EXPECT_TRUE(study.Find("N3")->consent) << "the last answer counts";
  EXPECT_FALSE(study.Find("N1")->consent);
  EXPECT_TRUE(study.Find("N2")->consent) << "as the study has it";
  WriteTextFile(file, "code,consent\nN1,maybe\n");
  EXPECT_THAT([&] { ReadConsents(file, study, context_); },
              ThrowsMessage<InputError>(HasSubstr("consent.csv:2: the consent must be yes or no")));
}

TEST_F(StudyTest, ACurriculumOpensStepsAsTheyAreMastered) {
  WriteTextFile(folder_ / "curriculum.json", R"({
    "format": "acus-curriculum/1", "name": "Two", "steps": [
      {"exercise": "a.json", "mastery": {"in_a_row": 2}},
      {"exercise": "b.json", "after": ["a.json"], "mastery": {"in_a_row": 1}, "time_limit_s": 90}]})");
  const Curriculum curriculum = ReadCurriculum(folder_ / "curriculum.json");
  std::vector<TrialRecord> trials = {Scored("Exercise a", 95.0), Scored("Exercise a", 60.0),
                                     Scored("Exercise a", 92.0)};
  auto states = ProgressOf(curriculum, "A", trials);
  EXPECT_EQ(states[0].trials, 3);
  EXPECT_EQ(states[0].longest_row, 1) << "the second one breaks the row";
  EXPECT_EQ(states[0].best_score_percent, 95.0);
  EXPECT_FALSE(states[0].mastered);
  EXPECT_FALSE(states[1].open);
  EXPECT_THAT(CurriculumText(curriculum, trials, {"A"}), HasSubstr("A: next: Exercise a"));
  const auto state = CurriculumJson(curriculum, trials, {"A", "new"});
  EXPECT_EQ(state["trainees"]["A"]["steps"][1]["next_case"]["file"], (folder_ / "b.json").string());
  EXPECT_EQ(state["steps"][1]["after"][0], 0);
  EXPECT_EQ(state["steps"][1]["time_limit_s"], 90.0);
  EXPECT_TRUE(state["steps"][0]["time_limit_s"].is_null());
  EXPECT_EQ(state["trainees"]["A"]["next"], 0);
  EXPECT_EQ(state["trainees"]["A"]["steps"][0]["trials"], 3);
  EXPECT_EQ(state["trainees"]["new"]["steps"][0]["state"], "open") << "nobody needs a trial first";
  EXPECT_EQ(state["trainees"]["new"]["steps"][1]["state"], "locked");
  trials.push_back(Scored("Exercise a", 91.0));
  trials.back().passed = false;
  EXPECT_FALSE(ProgressOf(curriculum, "A", trials)[0].mastered) << "a must was not met";
  trials.back().passed = true;
  trials.push_back(Scored("Exercise a", 10.0));
  states = ProgressOf(curriculum, "A", trials);
  EXPECT_TRUE(states[0].mastered) << "and stays so";
  EXPECT_TRUE(states[1].open);
  trials.push_back(Scored("Exercise b", 100.0));
  EXPECT_THAT(CurriculumText(curriculum, trials, {"A"}), HasSubstr("A: all mastered"));
  EXPECT_TRUE(CurriculumJson(curriculum, trials, {"A"})["trainees"]["A"]["next"].is_null());
  EXPECT_EQ(ProgressOf(curriculum, "B", trials)[0].trials, 0);
}

TEST_F(StudyTest, AStepThatAnyTrialMeetsIsDoneAndNotMastered) {
  WriteTextFile(folder_ / "curriculum.json", R"({
    "format": "acus-curriculum/1", "name": "One", "steps": [
      {"exercise": "a.json", "mastery": {"score_percent": 0, "goals_met_percent": 0, "in_a_row": 1}}]})");
  const Curriculum curriculum = ReadCurriculum(folder_ / "curriculum.json");
  const std::vector<TrialRecord> trials = {Scored("Exercise a", 0.0)};
  EXPECT_EQ(CurriculumJson(curriculum, trials, {"A"})["trainees"]["A"]["steps"][0]["state"],
            "done");
  EXPECT_THAT(CurriculumText(curriculum, trials, {"A"}), HasSubstr("A: all done"));
}

TEST_F(StudyTest, AStepWithCasesCountsTrialsOfAllAndDrawsTheNextOne) {
  WriteTextFile(folder_ / "cases.csv", "exercise,difficulty\nb.json,0.2\nc.json,0.6\n");
  WriteTextFile(folder_ / "curriculum.json", R"({
    "format": "acus-curriculum/1", "name": "Cases", "steps": [
      {"cases": "cases.csv", "name": "Two patients", "order": "staircase", "mastery": {"in_a_row": 2}},
      {"exercise": "a.json", "after": ["cases.csv"]}]})");
  const Curriculum curriculum = ReadCurriculum(folder_ / "curriculum.json");
  const auto at = [](const std::string& exercise, double score, const char* folder) {
    TrialRecord trial = Scored(exercise, score);
    trial.folder = folder;
    return trial;
  };
  // Sorted by exercise, as they are read; in time b, c, b.
  std::vector<TrialRecord> trials = {at("Exercise b", 95.0, "s/2026-01-01_10-00-00_b/report"),
                                     at("Exercise b", 95.0, "s/2026-01-01_12-00-00_b/report"),
                                     at("Exercise c", 20.0, "s/2026-01-01_11-00-00_c/report")};
  auto states = ProgressOf(curriculum, "A", trials);
  EXPECT_EQ(states[0].trials, 3);
  EXPECT_EQ(states[0].longest_row, 1) << "the failure lies between the successes";
  EXPECT_EQ(states[0].next.exercise, "Exercise c") << "harder after a success";
  EXPECT_FALSE(states[1].open);
  EXPECT_THAT(CurriculumText(curriculum, trials, {"A"}),
              HasSubstr("A: next: Two patients: Exercise c (difficulty 0.60)"));
  const auto json = CurriculumJson(curriculum, trials, {"A"});
  EXPECT_EQ(json["steps"][0]["cases"], 2);
  EXPECT_EQ(json["trainees"]["A"]["steps"][0]["next_case"]["difficulty"], 0.6);
  trials.push_back(at("Exercise c", 92.0, "s/2026-01-01_13-00-00_c/report"));
  states = ProgressOf(curriculum, "A", trials);
  EXPECT_TRUE(states[0].mastered) << "in two patients";
  EXPECT_TRUE(states[1].open);
}

TEST_F(StudyTest, ACurriculumWithCasesIsRefusedWithTheReason) {
  WriteTextFile(folder_ / "cases.csv", "exercise,difficulty\nb.json,0.2\nc.json,0.6\n");
  const auto reading = [this](const std::string& steps) {
    WriteTextFile(folder_ / "curriculum.json",
                  R"({"format": "acus-curriculum/1", "name": "x", "steps": [)" + steps + "]}");
    return [this] { ReadCurriculum(folder_ / "curriculum.json"); };
  };
  EXPECT_THAT(reading(R"({"exercise": "a.json", "cases": "cases.csv"})"),
              ThrowsMessage<InputError>(HasSubstr("/steps/0: must have either")));
  EXPECT_THAT(reading("{}"), ThrowsMessage<InputError>(HasSubstr("/steps/0: must have either")));
  EXPECT_THAT(reading(R"({"cases": "cases.csv", "difficulty": [0.7, 0.1]})"),
              ThrowsMessage<InputError>(HasSubstr("/difficulty: from 0.7 to 0.1")));
  EXPECT_THAT(reading(R"({"cases": "cases.csv"}, {"exercise": "c.json"})"),
              ThrowsMessage<InputError>(HasSubstr("\"Exercise c\" is there twice")));
}

TEST(NaturallyBefore, NumbersByValue) {
  EXPECT_TRUE(NaturallyBefore("a/trial_2/x", "a/trial_10/x"));
  EXPECT_FALSE(NaturallyBefore("a/trial_10/x", "a/trial_2/x"));
  EXPECT_TRUE(NaturallyBefore("a", "a1"));
  EXPECT_TRUE(NaturallyBefore("a01b", "a1c"));
  EXPECT_FALSE(NaturallyBefore("a1", "a1"));
}

TEST(BoxPlotSvg, DrawsBoxesAndSaysIfThereIsNothing) {
  const std::vector<Box> boxes = {{"novice", {1, 2, 3, 40}}, {"expert & co", {2, 2}}};
  const std::string svg = BoxPlotSvg("time", "s", boxes);
  EXPECT_THAT(svg, testing::AllOf(HasSubstr("time [s]"), HasSubstr("expert &amp; co (2)")));
  EXPECT_THAT(BoxPlotSvg("time", "s", {}), HasSubstr("no values"));
}

TEST(BoxPlotSvg, TheAxisRisesInEqualStepsBeyondAllValues) {
  const std::vector<Box> boxes = {{"a", {100, 500}}, {"b", {300}}};
  const std::string svg = BoxPlotSvg("time", "s", boxes);
  const std::regex label("y=\"([0-9.]+)\" text-anchor=\"end\"[^>]*>([-0-9.]+)<");
  std::vector<std::pair<double, double>> labels;  // Pixels from the top, and values.
  for (std::sregex_iterator at(svg.begin(), svg.end(), label), end; at != end; ++at) {
    labels.emplace_back(std::stod((*at)[1]), std::stod((*at)[2]));
  }
  ASSERT_EQ(labels.size(), 5U);
  EXPECT_EQ(labels.front().second, 80.0) << "a twentieth of the range below the least";
  EXPECT_EQ(labels.back().second, 520.0);
  for (std::size_t i = 1; i < labels.size(); ++i) {
    EXPECT_NEAR(labels[i].second - labels[i - 1].second, 110.0, 1.0);
    EXPECT_NEAR(labels[i - 1].first - labels[i].first,
                0.25 * (labels.front().first - labels.back().first), 0.11);
  }
}

TEST_F(StudyTest, TheReportHasThreeDigits) {
  WriteTrials();
  auto trials = Trials(folder_ / "trials");
  for (TrialRecord& trial : trials) {
    for (auto& [metric, value] : trial.metrics) value /= 7.0;
  }
  WriteStudyReport(folder_, Read(), trials, {}, Analyse(Read(), trials, {}), context_);
  const std::string html = ReadTextFile(folder_ / "study.html");
  // Mean (SD); median [quartiles] of 70 / 7 and 80 / 7.
  EXPECT_THAT(html, HasSubstr("10.7 (1); 10.7 [10.4, 11.1]"));
}

TEST(StudyCommands, WhatFollowsTheTrialsIsNoTrial) {
  const testing_support::TemporaryFolder folder;
  const std::string trials = folder.path().string();
  const auto parses = [](CLI::App& app, std::vector<std::string> words) {
    std::ranges::reverse(words);
    EXPECT_NO_THROW(app.parse(words));
  };
  CLI::App study;
  const auto study_command = AddStudyCommands(study);
  parses(study, {"report", "--trials", trials, trials, "-o", "out"});
  CLI::App curriculum;
  const auto curriculum_command = AddCurriculumOptions(curriculum);
  parses(curriculum, {"--trials", trials, trials, "--json"});
}

}  // namespace
}  // namespace acus::study
