#include "acus/assess/regression/comparison/run_comparison.h"

#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/session/sequence_writer.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::comparison {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

/// A run as acus-replay writes it, small, with what a test wants to be different.
struct SmallRun {
  int samples = 200;
  double force_offset_n = 0.0;  ///< Added to force_axial_n everywhere.
  double spike_n = 0.0;         ///< Added to friction_n at sample 50.
  int puncture_at = 80;         ///< Sample of the event.
  int air_samples = 0;          ///< Before the skin.
  std::string event = "puncture";
  std::string extra_column;
  std::string extra_value = "1";
  int frames = 5;
  int size = 24;
  int gray_offset = 0;  ///< Added to every pixel of frame 3.
  double path_length_mm = 120.0;
  bool has_images = true;

  void Write(const fs::path& folder) const {
    fs::create_directories(folder);
    std::string csv = "time_s,depth_mm,tissue,force_axial_n,friction_n,event" +
                      (extra_column.empty() ? "" : "," + extra_column) + "\n";
    for (int i = 0; i < samples; ++i) {
      const double axial_n = 0.01 * i + force_offset_n;
      const double friction_n = 0.2 + (i == 50 ? spike_n : 0.0);
      csv += NumberText(i * 1e-3) + "," + NumberText(0.1 * i) + "," +
             (i < air_samples ? "air"
              : i < 100       ? "skin"
                              : "fat") +
             "," + NumberText(axial_n) + "," + NumberText(friction_n) + "," +
             (i == puncture_at ? event : "") + (extra_column.empty() ? "" : "," + extra_value) +
             "\n";
    }
    WriteTextFile(folder / "forces.csv", csv);
    config::WriteJson(folder / "metrics.json",
                      {{"format", "acus-metrics/1"},
                       {"metrics",
                        {{{"name", "path length"}, {"unit", "mm"}, {"value", path_length_mm}},
                         {{"name", "hits"}, {"unit", ""}, {"value", nullptr}}}}});
    if (has_images) WriteImages(folder / "images.igs.mha");
  }

  void WriteImages(const fs::path& path) const {
    session::SequenceFormat format;
    format.width = static_cast<std::size_t>(size);
    format.height = static_cast<std::size_t>(size);
    session::SequenceWriter writer(path, format);
    for (int f = 0; f < frames; ++f) {
      std::vector<std::uint8_t> pixels(static_cast<std::size_t>(size) * size);
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        pixels[i] = static_cast<std::uint8_t>(40 + (i * 7 + i / 24 * 13 + f) % 150 +
                                              (f == 3 ? gray_offset : 0));
      }
      writer.AddFrame(f * 33'000'000, pixels, {});
    }
    writer.Commit();
  }
};

class RunComparisonTest : public testing::Test {
 protected:
  RunComparison Compare(const SmallRun& a, const SmallRun& b, const nlohmann::json& changes = {}) {
    a.Write(folder_ / "a");
    b.Write(folder_ / "b");
    return CompareWritten(changes);
  }

  RunComparison CompareWritten(const nlohmann::json& changes = {}, Lack lack = Lack::kFails) {
    nlohmann::json document = {{"format", "acus-tolerances/1"}};
    if (!changes.is_null()) document.update(changes);
    return CompareRuns(folder_ / "a", folder_ / "b", TolerancesFrom(document, "tolerances"), lack,
                       RunContext{});
  }

  static const Check& Find(const RunComparison& comparison, const std::string& quantity) {
    for (const Check& check : comparison.checks) {
      if (check.quantity == quantity) return check;
    }
    throw InputError("no check is named " + quantity);
  }

  testing_support::TemporaryFolder folder_;
};

TEST_F(RunComparisonTest, AgreesWithItselfToTheLastBit) {
  SmallRun{}.Write(folder_ / "a");
  SmallRun{}.Write(folder_ / "b");
  const auto preset = fs::path(ACUS_SOURCE_DIR) / "configs" / "tolerances" / "identical.json";
  const RunComparison comparison =
      CompareRuns(folder_ / "a", folder_ / "b", ReadTolerances(preset), Lack::kFails, RunContext{});
  EXPECT_TRUE(comparison.passed()) << TableText(comparison);
  EXPECT_EQ(comparison.images.num_identical, 5U);
  EXPECT_FALSE(Find(comparison, "images: smallest PSNR").value.has_value());
  EXPECT_EQ(*Find(comparison, "images: smallest SSIM").value, 1.0);
  const auto document = ToJson(comparison);
  EXPECT_TRUE(document["images"]["worst_frame"]["psnr_db"].is_null());
  EXPECT_NO_THROW(config::WriteJson(folder_ / "c.json", document));
}

TEST_F(RunComparisonTest, StatesForceDifferencesAsTheyAre) {
  SmallRun b;
  b.force_offset_n = 0.004;
  b.spike_n = 0.5;
  const RunComparison comparison = Compare(SmallRun{}, b);
  EXPECT_NEAR(*Find(comparison, "force_axial_n: RMS difference").value, 0.004, 1e-12);
  EXPECT_NEAR(*Find(comparison, "force_axial_n: largest difference").value, 0.004, 1e-12);
  EXPECT_NEAR(*Find(comparison, "friction_n: RMS difference").value, 0.5 / std::sqrt(200.0), 1e-12);
  EXPECT_NEAR(*Find(comparison, "friction_n: largest difference").value, 0.5, 1e-12);
  EXPECT_THAT(Find(comparison, "friction_n: largest difference").remark, HasSubstr("at 0.05 s"));
  EXPECT_THAT(comparison.failed(),
              ElementsAre("force_axial_n: RMS difference", "friction_n: RMS difference",
                          "friction_n: largest difference"));
  const nlohmann::json lenient = {
      {"forces",
       {{"rms_n", 0.005}, {"components", {{"friction_n", {{"rms_n", 0.1}, {"max_n", 1}}}}}}}};
  EXPECT_TRUE(CompareWritten(lenient).passed());
}

TEST_F(RunComparisonTest, CountsSamplesInAnotherTissueFromTheFirstOn) {
  SmallRun b;
  b.air_samples = 1;
  const Check check = Find(Compare(SmallRun{}, b), "tissue: samples that differ");
  EXPECT_DOUBLE_EQ(*check.value, 0.5);
  EXPECT_THAT(check.remark, HasSubstr("first at 0 s: skin | air"));
}

TEST_F(RunComparisonTest, HoldsTheShapeOfANeedleThatBends) {
  const auto with = [](const char* column, const char* value) {
    SmallRun run;
    run.extra_column = column;
    run.extra_value = value;
    return run;
  };
  EXPECT_TRUE(Compare(with("deflection_mm", "1"), with("deflection_mm", "1.005")).passed());
  EXPECT_FALSE(Compare(with("deflection_mm", "1"), with("deflection_mm", "1.02")).passed());
  EXPECT_TRUE(Compare(with("torque_x_n_mm", "5"), with("torque_x_n_mm", "5.05")).passed());
  EXPECT_FALSE(Compare(with("torque_x_n_mm", "5"), with("torque_x_n_mm", "5.2")).passed());
  EXPECT_FALSE(Compare(with("deflection_mm", "1"), SmallRun()).passed());  // A column is missing.
}

TEST_F(RunComparisonTest, StatesImageDifferencesAsTheyAre) {
  SmallRun b;
  b.gray_offset = 5;
  const RunComparison comparison = Compare(SmallRun{}, b);
  EXPECT_NEAR(*Find(comparison, "images: smallest PSNR").value, 20 * std::log10(255.0 / 5), 1e-9);
  EXPECT_THAT(Find(comparison, "images: smallest PSNR").remark, HasSubstr("frame 3 at 0.099 s"));
  EXPECT_EQ(comparison.images.num_identical, 4U);
  EXPECT_EQ(*comparison.images.worst, 3U);
  EXPECT_THAT(comparison.failed(), ElementsAre("images: smallest PSNR"));
  const SideBySide image =
      ShowFrame(folder_ / "a" / "images.igs.mha", folder_ / "b" / "images.igs.mha", 3);
  EXPECT_EQ(image.width, 3 * 24 + 16);
  EXPECT_EQ(image.largest_difference, 5);
  EXPECT_EQ(image.pixels[32] - image.pixels[0], 5);
  EXPECT_EQ(image.pixels[64], 255);
}

TEST_F(RunComparisonTest, HoldsEventsByNameOrderAndTime) {
  SmallRun later;
  later.puncture_at = 81;
  EXPECT_NEAR(*Find(Compare(SmallRun{}, later), "events: time").value, 0.001, 1e-12);
  later.puncture_at = 90;
  EXPECT_THAT(Compare(SmallRun{}, later).failed(), ElementsAre("events: time"));
  SmallRun other;
  other.event = "bone";
  const RunComparison comparison = Compare(SmallRun{}, other);
  EXPECT_THAT(comparison.failed(), ElementsAre("events"));
  EXPECT_THAT(Find(comparison, "events").remark,
              HasSubstr("number 1: puncture at 0.08 s | bone at 0.08 s"));
  other.event = "";
  EXPECT_THAT(Find(Compare(SmallRun{}, other), "events").remark, HasSubstr("| none"));
}

TEST_F(RunComparisonTest, HoldsMetricsRelatively) {
  SmallRun b;
  b.path_length_mm = 120.06;
  EXPECT_TRUE(Compare(SmallRun{}, b).passed());
  b.path_length_mm = 120.3;
  EXPECT_THAT(Compare(SmallRun{}, b).failed(), ElementsAre("metric: path length"));
  EXPECT_TRUE(
      CompareWritten({{"metrics", {{"relative_by_name", {{"path length", 0.01}}}}}}).passed());
  config::WriteJson(folder_ / "b" / "metrics.json",
                    {{"metrics",
                      {{{"name", "hits"}, {"unit", ""}, {"value", 3}},
                       {{"name", "new"}, {"unit", "s"}, {"value", 1}}}}});
  EXPECT_THAT(CompareWritten().failed(),
              ElementsAre("metric: path length", "metric: hits", "metric: new"));
}

TEST_F(RunComparisonTest, GivesAVerdictOnRunsThatDoNotMatch) {
  SmallRun b;
  b.samples = 150;
  b.frames = 3;
  b.extra_column = "bone_n";
  const RunComparison shorter = Compare(SmallRun{}, b);
  EXPECT_THAT(shorter.failed(),
              ElementsAre("force log: columns", "force log: samples", "images: number"));
  EXPECT_THAT(Find(shorter, "force log: samples").remark, HasSubstr("200 | 150, 150 at the same"));
  EXPECT_THAT(Find(shorter, "force log: columns").remark, HasSubstr("only in B: bone_n"));
  EXPECT_EQ(shorter.images.frames.size(), 3U);
  SmallRun other_size;
  other_size.size = 32;
  const RunComparison resized = Compare(SmallRun{}, other_size);
  EXPECT_THAT(resized.failed(), ElementsAre("images: size"));
  EXPECT_FALSE(resized.images.worst.has_value());
  SmallRun without;
  without.has_images = false;
  fs::remove(folder_ / "b" / "images.igs.mha");
  EXPECT_THAT(Compare(SmallRun{}, without).failed(), ElementsAre("images.igs.mha"));
}

TEST_F(RunComparisonTest, StatesWhatOneHasAndComparesTheRest) {
  SmallRun a;
  a.has_images = false;
  a.Write(folder_ / "a");
  fs::remove(folder_ / "a" / "metrics.json");
  WriteTextFile(folder_ / "a" / "needle.csv", "time_s,x_mm\n0,1\n");
  SmallRun b;
  b.extra_column = "bone_n";
  b.Write(folder_ / "b");
  const RunComparison same = CompareWritten({}, Lack::kIsStated);
  EXPECT_TRUE(same.passed()) << TableText(same);
  ASSERT_EQ(same.only_in_one.size(), 3U);
  EXPECT_THAT(TableText(same),
              HasSubstr("Not compared: images.igs.mha (only in B), metrics.json (only in B), force "
                        "log: columns (only in B: bone_n)\n"));
  EXPECT_EQ(ToJson(same)["only_in_one"].size(), 3U);
  EXPECT_THAT(CompareWritten().failed(),
              ElementsAre("images.igs.mha", "metrics.json", "force log: columns"));
  b.spike_n = 0.5;
  b.Write(folder_ / "b");
  EXPECT_THAT(CompareWritten({}, Lack::kIsStated).failed(),
              ElementsAre("friction_n: RMS difference", "friction_n: largest difference"));
  fs::remove(folder_ / "b" / "forces.csv");
  EXPECT_THAT([&] { CompareWritten({}, Lack::kIsStated); },
              ThrowsMessage<InputError>(
                  HasSubstr("nothing in common to compare; A has forces.csv, B has images")));
}

TEST_F(RunComparisonTest, ComparesProbeForcesAndTablesOfEffects) {
  for (const char* run : {"a", "b"}) {
    SmallRun{}.Write(folder_ / run);
    WriteTextFile(folder_ / run / "probe_forces.csv", "time_s,force_n,skin_mm\n0,1,2\n1,1,2\n");
    WriteTextFile(folder_ / run / "vessels.csv", "time_s,wall_mm\n0,1\n1,1\n");
    WriteTextFile(folder_ / run / "probe.csv", Message("time_s,x_mm\n0,", run, "\n"));
  }
  EXPECT_THAT(ComparableFiles(folder_ / "a"),
              ElementsAre("forces.csv", "probe_forces.csv", "images.igs.mha", "metrics.json",
                          "vessels.csv"));
  const RunComparison same = CompareWritten();
  EXPECT_TRUE(same.passed()) << TableText(same);
  WriteTextFile(folder_ / "b" / "probe_forces.csv", "time_s,force_n,skin_mm\n0,1,2\n1,3,2\n");
  WriteTextFile(folder_ / "b" / "vessels.csv", "time_s,wall_mm\n0,1\n1,1.5\n");
  EXPECT_THAT(CompareWritten().failed(), ElementsAre("probe_forces: force_n: RMS difference",
                                                     "probe_forces: force_n: largest difference",
                                                     "vessels: wall_mm: largest difference"));
}

TEST_F(RunComparisonTest, RefusesWhatIsNoRun) {
  SmallRun{}.Write(folder_ / "a");
  fs::create_directories(folder_ / "b");
  EXPECT_THAT([&] { CompareWritten(); }, ThrowsMessage<InputError>(HasSubstr("not a run folder")));
  SmallRun{}.Write(folder_ / "b");
  WriteTextFile(folder_ / "b" / "forces.csv", "time_s,force_axial_n\n0,1\n0,2\n");
  EXPECT_THAT([&] { CompareWritten(); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("forces.csv:3"), HasSubstr("not after"))));
  WriteTextFile(folder_ / "b" / "forces.csv", "time_s,force_axial_n\n0,nan\n");
  EXPECT_THAT([&] { CompareWritten(); }, ThrowsMessage<InputError>(HasSubstr("forces.csv:2")));
  SmallRun{}.Write(folder_ / "b");
  WriteTextFile(folder_ / "b" / "metrics.json", R"({"metrics": [{"name": "x", "value": "y"}]})");
  EXPECT_THAT([&] { CompareWritten(); }, ThrowsMessage<InputError>(HasSubstr("/metrics/0/value")));
  EXPECT_THAT(
      [&] {
        TolerancesFrom({{"format", "acus-tolerances/1"}, {"images", {{"ssim_min", 2}}}}, "t.json");
      },
      ThrowsMessage<InputError>(HasSubstr("/images/ssim_min")));
}

TEST_F(RunComparisonTest, SurvivesDamagedRuns) {
  SmallRun small;
  small.samples = 20;
  small.frames = 2;
  small.size = 12;
  for (const char* name : {"forces.csv", "images.igs.mha", "metrics.json"}) {
    small.Write(folder_ / "a");
    small.Write(folder_ / "b");
    const std::string valid = ReadTextFile(folder_ / "b" / name);
    EXPECT_GT(testing_support::ReadDamagedCopies(valid, folder_ / "b" / name, 200,
                                                 [&] { CompareWritten(); }),
              20)
        << name;
  }
}

TEST_F(RunComparisonTest, GivesTheSameWithAnyNumberOfThreads) {
  SmallRun b;
  b.gray_offset = 3;
  SmallRun{}.Write(folder_ / "a");
  b.Write(folder_ / "b");
  const Tolerances tolerances = TolerancesFrom({{"format", "acus-tolerances/1"}}, "t");
  RunContext one;
  RunContext four;
  four.num_threads = 4;
  EXPECT_EQ(ToJson(CompareRuns(folder_ / "a", folder_ / "b", tolerances, Lack::kFails, one)),
            ToJson(CompareRuns(folder_ / "a", folder_ / "b", tolerances, Lack::kFails, four)));
}

TEST_F(RunComparisonTest, WritesWhatItFound) {
  SmallRun b;
  b.gray_offset = 5;
  b.spike_n = 0.5;
  const RunComparison comparison = Compare(SmallRun{}, b);
  fs::create_directories(folder_ / "out");
  WriteComparison(folder_ / "out", comparison, RunContext{});
  const auto document = config::ReadJson(folder_ / "out" / "comparison.json");
  EXPECT_EQ(document["passed"], false);
  EXPECT_EQ(document["images"]["worst_frame"]["number"], 3);
  const std::string html = ReadTextFile(folder_ / "out" / "comparison.html");
  EXPECT_THAT(html, AllOf(HasSubstr("The runs differ"), HasSubstr("What differs"),
                          HasSubstr("data:image/png;base64,"), HasSubstr("friction_n")));
  EXPECT_GT(fs::file_size(folder_ / "out" / "worst_frame.png"), 100U);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "provenance.json"));
}

}  // namespace
}  // namespace acus::comparison
