#include "acus/assess/regression/regression.h"

#include <gmock/gmock.h>
#include <regex>

#include "acus/assess/regression/bisect.h"
#include "acus/assess/regression/calibration.h"
#include "acus/assess/regression/new_suite.h"
#include "acus/assess/regression/regression_report.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "support/layered_scene.h"
#include "support/temporary_folder.h"

namespace acus::regression {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A suite of one short insertion, felt but not seen, and one that has no session any more.
class Regression : public testing::Test {
 protected:
  void SetUp() override {
    const auto scene =
        testing_support::LayeredScene(testing_support::PlanOf(true, false, false, false), true);
    volume::WriteLabelMap(folder_ / "labels.seg.nrrd", *scene.labels);
    session::Session session;
    for (int ms = 0; ms < 1000; ++ms) {
      session::PoseSample needle{.time_ns = ms * std::int64_t{1'000'000}};
      needle.reference_from_tool =
          Eigen::Isometry3d(Eigen::Translation3d(0.0, 20.0, -5.0 + 0.025 * ms));
      session.needle.push_back(needle);
    }
    session::WriteSession(folder_ / "session", session, context_);
    WriteTextFile(folder_ / "scene.json", R"({"format": "acus-scenario/1",
      "patient": {"labels": "labels.seg.nrrd",
        "ct_from_reference": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}, "effects": {"needle_force": {}}})");
    setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    WriteSuite("[]");
  }

  void WriteSuite(const std::string& changes) {
    WriteTextFile(folder_ / "suite.json",
                  R"({"format": "acus-regression/1", "time_min_s": 1000, "cases": [{"name": "in",
        "scenario": "scene.json", "session": "session", "set": )" +
                      changes + "}]}");
  }

  /// Runs the suite into a folder, with its page.
  SuiteResult Run(const std::string& name) {
    const fs::path result_folder = folder_ / name;
    fs::create_directories(result_folder);
    SuiteResult result = RunSuite(ReadSuite(folder_), result_folder, context_);
    WriteResult(result_folder, result, context_);
    return result;
  }

  testing_support::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
  RunContext context_;
};

TEST_F(Regression, IsNewThenAcceptedThenTheSame) {
  const SuiteResult first = Run("first");
  EXPECT_FALSE(first.passed());
  ASSERT_EQ(first.cases.size(), 1);
  EXPECT_EQ(first.cases[0].verdict, Verdict::kNew);
  EXPECT_THAT(AcceptResult(ReadSuite(folder_), folder_ / "first"), HasSubstr("has one now"));
  const SuiteResult second = Run("second");
  EXPECT_TRUE(second.passed()) << TextOf(second);
  EXPECT_THAT(AcceptResult(ReadSuite(folder_), folder_ / "second"), HasSubstr("was as expected"));
  context_.overwrite = true;  // Of the result as a whole, not of runs in it.
  const SuiteResult again = RunSuite(ReadSuite(folder_), folder_ / "second", context_);
  EXPECT_EQ(again.cases[0].verdict, Verdict::kNoResult);
  EXPECT_THAT(again.cases[0].message, HasSubstr("exists already"));
}

TEST_F(Regression, ReportsWhatMovedAndAcceptsItOnlyIfRequested) {
  Run("first");
  AcceptResult(ReadSuite(folder_), folder_ / "first");
  const std::string before = ReadTextFile(folder_ / "expected/in/forces.csv");
  WriteSuite(R"(["/needle=needles/trocar_18g.json", "/effects/needle_force/model=alamilla"])");
  const SuiteResult moved = Run("moved");
  EXPECT_FALSE(moved.passed());
  EXPECT_EQ(moved.cases[0].verdict, Verdict::kMoved);
  EXPECT_THAT(TextOf(moved), AllOf(HasSubstr("MOVED"), HasSubstr("force_axial_n")));
  const auto failed = moved.cases[0].comparison->failed();
  ASSERT_GT(failed.size(), 2U);
  EXPECT_THAT(TextOf(moved), HasSubstr(Message(failed.size() - 1, " more")))
      << "one is named, the others are counted";
  EXPECT_THAT(ReadTextFile(folder_ / "moved/regression.html"),
              AllOf(HasSubstr("force_axial_n"), HasSubstr(">expected<"), HasSubstr(">now<")));
  EXPECT_EQ(ReadTextFile(folder_ / "expected/in/forces.csv"), before);
  EXPECT_THAT(AcceptResult(ReadSuite(folder_), folder_ / "moved"),
              AllOf(HasSubstr("in: old | new"), HasSubstr("force_axial_n: RMS difference: ")));
  EXPECT_NE(ReadTextFile(folder_ / "expected/in/forces.csv"), before);
  EXPECT_TRUE(Run("after").passed());
}

TEST_F(Regression, PathsOfChangesAreThoseOfTheSuite) {
  fs::create_directories(folder_ / "other");
  fs::rename(folder_ / "labels.seg.nrrd", folder_ / "other/labels.seg.nrrd");
  fs::copy(fs::path(ACUS_SOURCE_DIR) / "configs/needles/trocar_18g.json",
           folder_ / "other/needle.json");
  WriteSuite(R"(["/patient/labels=other/labels.seg.nrrd", "/needle=other/needle.json"])");
  const SuiteResult result = Run("result");
  EXPECT_EQ(result.cases[0].verdict, Verdict::kNew) << result.cases[0].message;
  EXPECT_EQ(config::ReadJson(folder_ / "result/in/run/run.json")["scenario"]["needle"],
            (folder_ / "other/needle.json").string());
}

TEST_F(Regression, ARunWithChangesIsComparedButNotAccepted) {
  Run("first");
  AcceptResult(ReadSuite(folder_), folder_ / "first");
  const fs::path into = folder_ / "changed";
  fs::create_directories(into);
  const Suite suite = With(ReadSuite(folder_), {"/effects/needle_force/model=alamilla"});
  const SuiteResult result = RunSuite(suite, into, context_);
  WriteResult(into, result, context_);
  EXPECT_EQ(result.cases[0].verdict, Verdict::kMoved);
  EXPECT_THAT(ReadTextFile(into / "regression.html"), HasSubstr("Changed for this run"));
  EXPECT_THAT([&] { AcceptResult(ReadSuite(folder_), into); },
              ThrowsMessage<InputError>(HasSubstr("is a result with --set")));
  EXPECT_THAT(AdviceText(result),
              testing::AllOf(HasSubstr("with /effects/needle_force/model=alamilla"),
                             HasSubstr("cannot be accepted")));
  EXPECT_TRUE(Run("again").passed());
}

TEST_F(Regression, ANewSuiteFindsItsFilesFromAnyFolder) {
  fs::copy(folder_ / "session", folder_ / "Try 2-b.1", fs::copy_options::recursive);
  NewSuite made{.scenario = folder_ / "scene.json",
                .sessions = {folder_ / "session", folder_ / "session/", folder_ / "Try 2-b.1"},
                .labels = folder_ / "labels.seg.nrrd"};
  WriteTextFile(folder_ / "points.csv", "name,x_mm,y_mm,z_mm\ntarget,0,20,20\n");
  made.changes = {Message("/patient/corridor=", (folder_ / "points.csv").string())};
  EXPECT_THAT(WriteNewSuite(folder_ / "made", made, context_),
              HasSubstr("3 cases: Try_2-b.1 session session-2"));
  const auto document = config::ReadJson(folder_ / "made/suite.json");
  EXPECT_EQ(document["cases"][0]["name"], "session");
  EXPECT_EQ(document["cases"][1]["name"], "session-2");
  EXPECT_EQ(document["cases"][2]["name"], "Try_2-b.1");
  EXPECT_EQ(document["cases"][0]["scenario"], "../scene.json");
  EXPECT_EQ(document["cases"][0]["session"], "../session");
  EXPECT_EQ(document["cases"][0]["patient"]["labels"], "../labels.seg.nrrd");
  EXPECT_EQ(document["cases"][0]["set"][0], "/patient/corridor=\"../points.csv\"");
  EXPECT_EQ(document["tolerances"], "tolerances/default.json");
  // Moved with all that it names, it is still whole.
  fs::create_directories(folder_ / "elsewhere");
  for (const char* name :
       {"made", "scene.json", "session", "Try 2-b.1", "labels.seg.nrrd", "points.csv"}) {
    fs::rename(folder_ / name, folder_ / "elsewhere" / name);
  }
  fs::create_directories(folder_ / "result");
  const Suite suite = ReadSuite(folder_ / "elsewhere/made");
  const SuiteResult result = RunSuite(suite, folder_ / "result", context_);
  for (const CaseResult& c : result.cases) EXPECT_EQ(c.verdict, Verdict::kNew) << c.message;
  EXPECT_TRUE(fs::exists(folder_ / "result/session/run/target.mrk.json")) << "of points.csv";
}

TEST_F(Regression, ANewSuiteIsMadeOfWhatCanBeReplayedOnly) {
  NewSuite made{.scenario = folder_ / "scene.json", .sessions = {folder_ / "expected"}};
  fs::create_directories(folder_ / "expected");
  EXPECT_THAT([&] { WriteNewSuite(folder_ / "made", made, context_); },
              ThrowsMessage<InputError>(HasSubstr("expected")));
  EXPECT_FALSE(fs::exists(folder_ / "made"));
  made.sessions = {folder_ / "session"};
  made.tolerances = "tolerances/none.json";
  EXPECT_THAT([&] { WriteNewSuite(folder_ / "made", made, context_); },
              ThrowsMessage<InputError>(HasSubstr("none.json")));
  made.tolerances = "tolerances/identical.json";
  context_.overwrite = true;
  EXPECT_THAT([&] { WriteNewSuite(folder_, made, context_); },
              ThrowsMessage<InputError>(HasSubstr("has expectations")));
}

TEST_F(Regression, ACaseWithoutResultDoesNotStopTheOthers) {
  WriteTextFile(folder_ / "suite.json", R"({"format": "acus-regression/1", "cases": [
    {"name": "broken", "scenario": "scene.json", "session": "session", "patient": {"labels": "no.nrrd"}},
    {"name": "in", "scenario": "scene.json", "session": "session"}]})");
  const SuiteResult result = Run("result");
  ASSERT_EQ(result.cases.size(), 2);
  EXPECT_EQ(result.cases[0].verdict, Verdict::kNoResult);
  EXPECT_THAT(result.cases[0].message, HasSubstr("no.nrrd"));
  EXPECT_EQ(result.cases[1].verdict, Verdict::kNew);
  WriteJUnit(folder_ / "junit.xml", result);
  EXPECT_THAT(ReadTextFile(folder_ / "junit.xml"),
              testing::AllOf(HasSubstr("tests=\"2\" failures=\"1\" errors=\"1\""),
                             HasSubstr("name=\"broken\""), HasSubstr("<error type=\"NO RESULT\""),
                             HasSubstr("<failure type=\"NEW\"")));
  EXPECT_THAT([&] { AcceptResult(ReadSuite(folder_), folder_ / "result"); },
              ThrowsMessage<InputError>(HasSubstr("has no run of broken")));
  EXPECT_FALSE(fs::exists(folder_ / "expected")) << "nothing is accepted by halves";
  AcceptResult(Only(ReadSuite(folder_), {"in"}), folder_ / "result");
  EXPECT_TRUE(fs::exists(folder_ / "expected/in/forces.csv"));
}

TEST_F(Regression, TimeIsComparedInCalibrationLoops) {
  WriteTextFile(folder_ / "suite.json", R"({"format": "acus-regression/1", "time_min_s": 0,
    "cases": [{"name": "in", "scenario": "scene.json", "session": "session"}]})");
  Run("first");
  AcceptResult(ReadSuite(folder_), folder_ / "first");
  const fs::path timing = folder_ / "expected/in/timing.json";
  // As if a machine that is 1000 times slower had taken a tenth of the work.
  auto expected = config::ReadJson(timing);
  expected["cpu_s"] = 100.0 * expected.at("cpu_s").get<double>();
  expected["calibration_s"] = 1000.0 * expected.at("calibration_s").get<double>();
  config::WriteJson(timing, expected);
  const SuiteResult slow = Run("slow");
  EXPECT_THAT(slow.cases[0].comparison->failed(),
              testing::ElementsAre("CPU time, more than expected"));
  const CaseResult& c = slow.cases[0];
  EXPECT_NEAR(*c.comparison->checks.back().value,
              100.0 * (c.timing.Ratio() / c.expected_timing->Ratio() - 1.0), 1e-6);
  // Verdict, case, checks passed, time / expected: ten times, give or take what else runs here.
  std::smatch row;
  const std::string text = TextOf(slow);
  ASSERT_TRUE(std::regex_search(text, row, std::regex(R"(MOVED +in +\d+ of \d+ +([0-9.]+))")))
      << text;
  EXPECT_GT(std::stod(row[1]), 3.0);
  EXPECT_LT(std::stod(row[1]), 30.0);
  // As if it had taken ten times the work: being faster is no fault.
  expected["cpu_s"] = 100.0 * expected.at("cpu_s").get<double>();
  config::WriteJson(timing, expected);
  EXPECT_TRUE(Run("fast").passed());
}

TEST_F(Regression, RefusesSuitesAndResultsThatDoNotFit) {
  const auto reading = [&](const std::string& cases) {
    return [this, cases] {
      WriteTextFile(folder_ / "suite.json",
                    R"({"format": "acus-regression/1", "cases": [)" + cases + "]}");
      ReadSuite(folder_);
    };
  };
  const std::string one = R"({"name": "a", "scenario": "scene.json", "session": "session"})";
  EXPECT_THAT(reading(one + "," + one),
              ThrowsMessage<InputError>(HasSubstr("two are named \"a\"")));
  EXPECT_THAT(reading(R"({"name": "a", "scenario": "scene.json", "session": "gone"})"),
              ThrowsMessage<InputError>(HasSubstr("gone: no such session")));
  EXPECT_THAT(reading(R"({"name": "../a", "scenario": "scene.json", "session": "session"})"),
              ThrowsMessage<InputError>(HasSubstr("/cases/0/name")));
  EXPECT_THAT(reading(""), ThrowsMessage<InputError>(HasSubstr("/cases")));
  reading(one)();
  EXPECT_THAT([&] { Only(ReadSuite(folder_), {"b"}); },
              ThrowsMessage<InputError>(HasSubstr("there is no case \"b\"; the suite has: a")));
  EXPECT_THAT([&] { AcceptResult(ReadSuite(folder_), folder_ / "session"); },
              ThrowsMessage<InputError>(HasSubstr("is not a result of acus-regression run")));
}

/// Two runs with a trace of three steps; `write` makes them differ.
class Bisecting : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* run : {"a", "b"}) {
      fs::create_directories(folder_ / run);
      Write(run, "trace.csv", "time_s,force/depth_mm,image/gain\n0,1,5\n0.1,2,5\n0.2,3,5\n");
    }
  }
  void Write(const char* run, const char* trace, std::string_view text) {
    WriteTextFile(folder_ / run / trace, text);
  }
  Bisection Found() const { return Bisect(folder_ / "a", folder_ / "b"); }

  testing_support::TemporaryFolder folder_;
};

TEST_F(Bisecting, NamesTheFirstStepAndInItTheFirstStage) {
  EXPECT_TRUE(Found().same());
  Write("b", "trace.csv", "time_s,force/depth_mm,image/gain\n0,1,5\n0.1,2.5,6\n0.2,3,7\n");
  const Bisection found = Found();
  ASSERT_TRUE(found.step);
  EXPECT_FALSE(found.image);
  EXPECT_EQ(found.step->row, 1U);
  EXPECT_EQ(found.step->time_s, "0.1");
  EXPECT_EQ(found.step->stage + "/" + found.step->variable, "force/depth_mm");
  EXPECT_EQ(found.step->a + " " + found.step->b, "2 2.5");
}

TEST_F(Bisecting, ImagesAreComparedIfAnyRunHasThem) {
  Write("a", "image_trace.csv", "time_s,image/gain\n0,1\n");
  EXPECT_THAT([&] { Found(); }, ThrowsMessage<InputError>(HasSubstr("b/image_trace.csv")));
  Write("b", "image_trace.csv", "time_s,image/gain\n0,2\n");
  ASSERT_TRUE(Found().image);
  EXPECT_EQ(Found().image->variable, "gain");
}

TEST(CalibrationSeconds, IsTheCpuTimeOfTheQuickestOfThreeGoes) {
  const double begin_s = ThreadCpuSeconds();
  const double least_s = CalibrationSeconds();
  const double all_s = ThreadCpuSeconds() - begin_s;
  EXPECT_GT(least_s, 0.1 * all_s);
  EXPECT_LE(3.0 * least_s, all_s);
}

}  // namespace
}  // namespace acus::regression
