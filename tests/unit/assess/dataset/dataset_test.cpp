// Data sets of labelled images, of the layered patient.
#include "acus/assess/dataset/dataset.h"

#include <fstream>
#include <gmock/gmock.h>
#include <set>

#include "acus/assess/dataset/frame_moments.h"
#include "acus/assess/dataset/sequence_plan.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "support/layered_folder.h"
#include "support/temporary_folder.h"

namespace acus::dataset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::ThrowsMessage;

class DatasetTest : public testing::Test {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(
        folder_, R"({"needle_force": {}, "ultrasound": {"model": "columns_2010"}})", 10);
    WriteTextFile(folder_ / "corridor.csv", "name,x_mm,y_mm,z_mm\nentry,3,-5,0\ntarget,3,5,25\n");
    WriteTextFile(folder_ / "exercise.json",
                  R"({"format": "acus-exercise/1", "name": "Layers", "goals": []})");
  }

  /// Five ids that lie in the same body, three sequences each with two images.
  json Document() const {
    json patients = json::array();
    for (const char* id : {"a", "b", "c", "d", "e"}) {
      patients.push_back({{"id", id}, {"corridor", "corridor.csv"}});
    }
    return {{"format", "acus-dataset/1"},
            {"patients", patients},
            {"scenarios", {"scene.json"}},
            {"exercise", "exercise.json"},
            {"trainees", {"trainees/expert.json"}},
            {"ranges", {{"gain_offset_db", {-5, 5}}, {"depth_mm", {40, 60}}}},
            {"image_width_px", 64},
            {"image_height_px", 48},
            {"sequences", 5},
            {"frames_per_sequence", 4},
            {"step_rate_hz", 100},
            {"splits", {{"train", 0.6}, {"validation", 0.2}, {"test", 0.2}}}};
  }

  DatasetConfig Config(const json& document) const {
    config::WriteJson(folder_ / "dataset.json", document);
    return ReadDatasetConfig(folder_ / "dataset.json");
  }

  void Make(const char* name, std::uint64_t seed, int num_threads,
            replay::LabelFormat format = replay::LabelFormat::kPng) const {
    RunContext context;
    context.seed = seed;
    context.num_threads = num_threads;
    WriteDataset(Config(Document()), format, folder_ / name, context);
    fs::remove(folder_ / name / "provenance.json");  // It has the time and the command line.
  }

  void ExpectRefused(const json& document, const std::string& message) const {
    EXPECT_THAT([&] { Config(document); }, ThrowsMessage<InputError>(HasSubstr(message)));
  }

  testing_support::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
};

TEST_F(DatasetTest, NoPatientIsInTwoSplitsAndSharesAreKept) {
  const DatasetConfig config = Config(Document());
  std::set<std::vector<std::size_t>> seen;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const auto split_of = SplitPatients(config, seed);
    ASSERT_EQ(split_of.size(), 5U);
    EXPECT_EQ(std::ranges::count(split_of, 0U), 3);
    EXPECT_EQ(std::ranges::count(split_of, 1U), 1);
    EXPECT_EQ(std::ranges::count(split_of, 2U), 1);
    for (int number = 0; number < config.num_sequences; ++number) {
      EXPECT_LT(DrawSequence(config, seed, number).patient, 5U);
    }
    seen.insert(split_of);
  }
  EXPECT_GT(seen.size(), 5U) << "the seed does not matter";
}

TEST_F(DatasetTest, ValuesAreDrawnWithinTheirRangesAndFillThem) {
  json document = Document();
  document["sequences"] = 400;
  const DatasetConfig config = Config(document);
  double lowest_mm = 1e9, highest_mm = 0.0;
  std::set<std::uint64_t> motions;
  for (int number = 0; number < config.num_sequences; ++number) {
    const SequencePlan plan = DrawSequence(config, 3, number);
    EXPECT_GE(plan.probe_change.gain_offset_db, -5.0);
    EXPECT_LE(plan.probe_change.gain_offset_db, 5.0);
    lowest_mm = std::min(lowest_mm, *plan.probe_change.depth_mm);
    highest_mm = std::max(highest_mm, *plan.probe_change.depth_mm);
    EXPECT_FALSE(plan.probe_change.frequency_mhz);
    motions.insert(plan.motion_seed);
  }
  EXPECT_GE(lowest_mm, 40.0);
  EXPECT_LT(lowest_mm, 41.0);
  EXPECT_GT(highest_mm, 59.0);
  EXPECT_LE(highest_mm, 60.0);
  EXPECT_EQ(motions.size(), 400U);
}

TEST_F(DatasetTest, TheSameSeedGivesTheSameBytesAndAnotherSeedOthers) {
  using replay::LabelFormat;
  for (const LabelFormat format : {LabelFormat::kPng, LabelFormat::kHdf5}) {
    const std::string name = Message("f", static_cast<int>(format));
    Make((name + "_one").c_str(), 7, 1, format);
    Make((name + "_three").c_str(), 7, 3, format);
    EXPECT_EQ(Sha256OfPath(folder_ / (name + "_one")), Sha256OfPath(folder_ / (name + "_three")));
  }
  Make("other", 8, 2);
  for (const char* image :
       {"sequences/00000/images/00003.png", "sequences/00004/images/00000.png"}) {
    EXPECT_NE(Sha256OfPath(folder_ / "f1_one" / image), Sha256OfPath(folder_ / "other" / image));
  }
}

TEST_F(DatasetTest, TheManifestIsTrueOfTheFiles) {
  Make("made", 7, 2);
  const json manifest = config::ReadJson(folder_ / "made/manifest.json");
  std::set<std::string> patients;
  for (const auto& [name, ids] : manifest.at("splits").items()) {
    for (const json& id : ids) EXPECT_TRUE(patients.insert(id).second) << id << " is in two splits";
  }
  EXPECT_EQ(patients.size(), 5U);
  EXPECT_EQ(manifest.at("frames").at("train"), 12);
  const CsvTable frames(folder_ / "made/frames.csv");
  ASSERT_EQ(frames.num_rows(), 20U);
  const auto images = frames.Texts("image"), labels = frames.Texts("labels");
  const auto splits = frames.Texts("split"), of_patients = frames.Texts("patient");
  const auto visible = frames.Texts("inserted_mm");
  int inserted = 0;
  for (std::size_t n = 0; n < frames.num_rows(); ++n) {
    EXPECT_TRUE(fs::is_regular_file(folder_ / "made" / images[n])) << images[n];
    EXPECT_TRUE(fs::is_regular_file(folder_ / "made" / labels[n])) << labels[n];
    const json& in_split = manifest.at("splits").at(splits[n]);
    EXPECT_NE(std::find(in_split.begin(), in_split.end(), json(of_patients[n])), in_split.end());
    if (!visible[n].empty() && std::stod(visible[n]) > 0.0) ++inserted;
  }
  EXPECT_GE(inserted, 14) << "of each four, three with the tip in the body";
  for (const json& sequence : manifest.at("sequences")) {
    const json probe = config::ReadJson(folder_ / "made" /
                                        sequence.at("folder").get<std::string>() / "probe.json");
    EXPECT_EQ(probe.at("depth_mm"), sequence.at("depth_mm"));
    EXPECT_EQ(probe.at("image_width_px"), 64);
  }
}

TEST_F(DatasetTest, WhatCannotBeMadeIsRefusedBeforehand) {
  json document = Document();
  document["ranges"]["depth_mm"] = {60, 40};
  ExpectRefused(document, "/ranges/depth_mm: [60, 40] is empty; give the lowest value first");
  document = Document();
  document["ranges"]["depth_mm"] = {40, 900};
  ExpectRefused(document, "/ranges: the highest values do not suit the probe linear_l14.json");
  document = Document();
  document["patients"][3]["id"] = "a";
  ExpectRefused(document, "/patients/3/id: a is there twice");
  document = Document();
  document["splits"]["train"] = 0.9;
  ExpectRefused(document, "/splits: the shares add up to 1.3; they must add up to 1");
  document = Document();
  document["patients"] = {{{"id", "a"}}, {{"id", "b"}}};
  ExpectRefused(document, "/splits: 3 splits for 2 patients");
  document = Document();
  document["sequences"] = 4;
  ExpectRefused(document, "/sequences: 4 for 5 patients");
  document = Document();
  document["patients"][0]["folder"] = "nowhere";
  ExpectRefused(document, "/patients/0/ct: ");
}

TEST_F(DatasetTest, AScenarioWithoutUltrasoundLeavesNothingBehind) {
  WriteTextFile(folder_ / "bare.json", R"({"format": "acus-scenario/1",
    "patient": {"ct": "ct.nrrd", "labels": "labels.seg.nrrd"},
    "probe": "probes/linear_l14.json", "effects": {"needle_force": {}}})");
  json document = Document();
  document["scenarios"] = {"bare.json"};
  RunContext context;
  EXPECT_THAT(
      [&] { WriteDataset(Config(document), replay::LabelFormat::kPng, folder_ / "made", context); },
      ThrowsMessage<InputError>(HasSubstr("bare.json: /effects: has no ultrasound")));
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_FALSE(entry.is_directory()) << entry.path();
  }
}

TEST(FrameMoments, KeepTheShareAndAreSpread) {
  session::PoseStream needle;
  for (int ms = 0; ms < 1000; ++ms) needle.push_back({ms * std::int64_t{1'000'000}, {}, true});
  const auto after = [](std::int64_t from_ms) {
    return [from_ms](const session::PoseSample& sample) {
      return sample.time_ns >= from_ms * 1'000'000;
    };
  };
  const auto times_ns = FrameMoments(needle, after(900), 10, 0.7);
  ASSERT_EQ(times_ns.size(), 10U);
  EXPECT_TRUE(std::ranges::is_sorted(times_ns));
  EXPECT_EQ(std::ranges::count_if(times_ns, [](auto t) { return t >= 900'000'000; }), 7);
  EXPECT_EQ(times_ns[0], 150'000'000);
  // What there is none of is made up by the other kind.
  EXPECT_EQ(FrameMoments(needle, after(5000), 10, 0.7).size(), 10U);
  EXPECT_EQ(FrameMoments(needle, after(0), 10, 0.7).size(), 10U);
  needle.resize(4);
  EXPECT_EQ(FrameMoments(needle, after(0), 10, 0.7).size(), 4U);
}

}  // namespace
}  // namespace acus::dataset
