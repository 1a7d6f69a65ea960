#include "acus/run/launcher/workplaces.h"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>

#include "acus/run/launcher/patient_image.h"

namespace acus::launcher {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class Workplaces : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    Write("b/scenario.json", R"({"format": "acus-scenario/1", "name": "Lumbar puncture"})");
    fs::create_directories(folder_ / "b/exercises");
    fs::copy(fs::path(ACUS_SOURCE_DIR) / "configs/exercises/lumbar_puncture.json",
             folder_ / "b/exercises/first.json");
    Write("a/scenario.json", "{ no scenario");
    fs::create_directories(folder_ / "c");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void Write(const fs::path& file, const std::string& text) {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text;
  }
  void AddTrial(const std::string& session, bool reached) {
    Write("b/sessions/T1/" + session + "/report/training.json",
          std::string(R"({"format": "acus-training/1", "exercise": "L", "trainee": "T1",
 "session": "s", "by_virtual_trainee": false, "target": "", "target_radius_mm": 3.0,
 "metrics": [{"name": "attempts", "unit": "", "value": 1}], "structures": [], "checklist": [],
 "goals": [{"metric": "attempts", "unit": "", "at_least": null, "at_most": 1, "weight": 1,
 "must": true, "why": "", "value": 1, "met": )") +
              (reached ? "true" : "false") + "}]}");
  }

  fs::path folder_ = fs::path(testing::TempDir()) / ("workplaces_" + std::to_string(getpid()));
};

TEST_F(Workplaces, AreFoundWithTheirExercisesAndTroubles) {
  const auto found = FindWorkplaces(folder_);
  ASSERT_EQ(found.size(), 2U) << "a folder without scenario.json is none";
  EXPECT_EQ(found[0].name, "a");
  EXPECT_THAT(found[0].trouble, HasSubstr("scenario.json"));
  EXPECT_EQ(found[1].patient, "Lumbar puncture");
  EXPECT_EQ(found[1].trouble, "");
  ASSERT_EQ(found[1].exercises.size(), 1U);
  EXPECT_EQ(found[1].exercises[0].file_name, "first");
  EXPECT_EQ(found[1].exercises[0].title, "Lumbar puncture under ultrasound");
  EXPECT_EQ(FindWorkplaces(folder_ / "b").size(), 1U) << "a workplace itself";
  EXPECT_TRUE(FindWorkplaces(folder_ / "nowhere").empty());
}

TEST_F(Workplaces, TrialsAreThoseThatCount) {
  AddTrial("2026-01-02_10-11-12_first", true);
  AddTrial("2026-01-01_10-11-12_first", false);
  AddTrial("2026-01-03_10-11-12.2_first", true);
  Write("b/sessions/T1/2026-01-03_10-11-12.2_first/discarded.json", "{}");
  AddTrial("2026-01-04_10-11-12_second", true);
  Write("b/sessions/T1/2026-01-05_10-11-12_first/report/training.json", "{");
  const auto found = FindWorkplaces(folder_);
  EXPECT_THAT(found[1].trainees, ElementsAre("T1"));
  const auto trials = TrialsOf(found[1], "T1", "first");
  ASSERT_EQ(trials.size(), 2U);
  EXPECT_EQ(trials[0].time, "2026-01-01 10:11");
  EXPECT_FALSE(trials[0].passed);
  EXPECT_EQ(trials[0].goals_met, 0U);
  EXPECT_EQ(trials[1].num_goals, 1U);
  EXPECT_TRUE(trials[1].passed);
  EXPECT_TRUE(TrialsOf(found[1], "T2", "first").empty());
}

TEST(TraineeCode, HasLettersDigitsAndDashes) {
  EXPECT_TRUE(IsTraineeCode("A-7_b"));
  for (const char* bad : {"", "A 7", "Müller", "../x"}) EXPECT_FALSE(IsTraineeCode(bad)) << bad;
}

TEST(PathImage, ShowsThePathDownToTheTarget) {
  volume::Geometry grid;
  grid.size = {80, 80, 80};
  grid.spacing_mm.setConstant(2.0);
  volume::CtVolume ct(grid, std::int16_t{90});
  const Eigen::Vector3d entry(80.0, 140.0, 80.0);
  const Eigen::Vector3d target(80.0, 60.0, 80.0);
  const image::ColourImage image = PathImage(ct, entry, target, 120);  // 1 mm a pixel.
  const auto at = [&](int column, int row) {
    const auto i = static_cast<std::size_t>(3 * (row * image.width + column));
    return Eigen::Array3i(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]);
  };
  // The middle of the image is 0.55 of the path below the entry: 44 mm.
  const Eigen::Array3i line = at(60, 60 - 24);
  EXPECT_GT(line[2], line[0] + 80) << "the path is blue";
  const Eigen::Array3i ring = at(64, 60 + 36);
  EXPECT_GT(ring[0], ring[2] + 80) << "the target is yellow";
  const Eigen::Array3i tissue = at(20, 60);
  EXPECT_EQ(tissue[0], tissue[2]);
  EXPECT_NEAR(tissue[0], 128, 2) << "90 HU of -160 to 340";
}

}  // namespace
}  // namespace acus::launcher
