#include "acus/assess/tuning/run_store.h"

#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <unistd.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

Measured SomeRun() {
  Measured run;
  run.knob = "needle_nodes";
  run.setting = {{"needle_nodes", 15}, {"tissue_model", "springs"}, {"speckle", true}};
  run.repetition = 2;
  run.seed = 9;
  run.steps = 2000;
  run.step_us_median = 4.125;
  run.step_us_p999 = 0.1 + 0.2;  // Must come back to the last bit.
  run.stages = {{"needle shape", "step", 0.75, 0.25}};
  run.preparation_s = 1.0 / 3.0;
  run.force_rms_n = 0.013;
  return run;
}

class RunStoreTest : public testing::Test {
 protected:
  testing_support::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path() / "sweep";
  nlohmann::json plan_ = {{"format", "acus-tradeoff-plan/1"}, {"seconds", 2.0}};
};

TEST_F(RunStoreTest, ARunComesBackBitForBit) {
  const Measured run = SomeRun();
  const RunStore store(folder_, plan_, false);
  EXPECT_FALSE(store.Find("a").has_value());
  store.Keep("a", run);
  const auto back = store.Find("a");
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(ToJson(*back), ToJson(run));
  EXPECT_EQ(back->step_us_p999, run.step_us_p999);
  EXPECT_TRUE(std::isnan(back->image_ms_median));
  EXPECT_EQ(back->setting, run.setting);
}

TEST_F(RunStoreTest, IsTakenUpAgainWithTheSamePlanOnly) {
  RunStore(folder_, plan_, false).Keep("a", SomeRun());
  EXPECT_TRUE(RunStore(folder_, plan_, false).Find("a").has_value());
  nlohmann::json other = plan_;
  other["seconds"] = 5.0;
  EXPECT_THAT([&] { RunStore(folder_, other, false); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("/seconds: 2.0 there, 5.0 now"), HasSubstr("--overwrite"))));
  EXPECT_TRUE(RunStore(folder_, plan_, false).Find("a").has_value());
  EXPECT_FALSE(RunStore(folder_, other, true).Find("a").has_value());
}

TEST_F(RunStoreTest, RunsOfAnotherBuildAreNotTakenUp) {
  plan_["build"] = "0.1.0 (034f33f), program 00aa";
  RunStore(folder_, plan_, false).Keep("a", SomeRun());
  nlohmann::json other = plan_;
  other["build"] = "0.1.0 (034f33f-dirty), program 00bb";
  EXPECT_THAT(
      [&] { RunStore(folder_, other, false); },
      ThrowsMessage<InputError>(AllOf(
          HasSubstr("another build"), HasSubstr("\"0.1.0 (034f33f), program 00aa\" there"),
          HasSubstr("\"0.1.0 (034f33f-dirty), program 00bb\" now"), HasSubstr("--overwrite"))));
  other.erase("build");
  EXPECT_THAT([&] { RunStore(folder_, other, false); },
              ThrowsMessage<InputError>(HasSubstr("an unnamed one now")));
  EXPECT_TRUE(RunStore(folder_, plan_, false).Find("a").has_value());
}

TEST_F(RunStoreTest, AFolderOfSomethingElseIsNeverTouched) {
  fs::create_directories(folder_);
  WriteTextFile(folder_ / "notes.txt", "mine");
  for (const bool overwrite : {false, true}) {
    EXPECT_THAT([&] { RunStore(folder_, plan_, overwrite); },
                ThrowsMessage<InputError>(HasSubstr("no folder of a sweep")));
  }
  EXPECT_EQ(ReadTextFile(folder_ / "notes.txt"), "mine");
}

TEST_F(RunStoreTest, WhatTheKilledLeftIsTidiedAndWhatTheLivingWriteStays) {
  const RunStore store(folder_, plan_, false);
  // No process has a number as large as this.
  const fs::path dead = folder_ / "runs/.partial-2147483646-0-a.json";
  const fs::path living = folder_ / Message("runs/.partial-", getpid(), "-0-b.json");
  WriteTextFile(dead, "half");
  WriteTextFile(living, "half");
  store.Tidy();
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(living));
}

// A run is there as it was written, or it is not there.
TEST_F(RunStoreTest, ADamagedRunIsToBeRunAgain) {
  const std::string whole = RunText(SomeRun());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(RunFromText(whole.substr(0, size)).has_value()) << size;
  }
  for (std::size_t byte = 0; byte < whole.size(); ++byte) {
    std::string changed = whole;
    changed[byte] = static_cast<char>(changed[byte] ^ (1 << byte % 8));
    EXPECT_FALSE(RunFromText(changed).has_value()) << byte;
  }
  EXPECT_FALSE(RunFromText(whole + whole).has_value());
  EXPECT_TRUE(RunFromText(whole).has_value());
}

TEST(Measured, OtherDocumentsAreRefused) {
  for (const char* text :
       {"{}", "[]", "3", R"({"format": "acus-tradeoff-run/1"})", R"({"format": "acus-run/1"})"}) {
    EXPECT_THROW(MeasuredFromJson(nlohmann::json::parse(text), "x"), InputError) << text;
  }
}

TEST(Measured, IdenticalImagesHaveInfinitePsnr) {
  Measured run;
  EXPECT_TRUE(std::isnan(run.ImagePsnrDb()));
  run.image_rms_grey = 0.0;
  EXPECT_TRUE(std::isinf(run.ImagePsnrDb()));
  run.image_rms_grey = 25.5;
  EXPECT_NEAR(run.ImagePsnrDb(), 20.0, 1e-12);
}

}  // namespace
}  // namespace acus::tuning
