// Label images of a replay: the files, held against the label map and the poses.
#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/data/volume/scalar_file.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"

namespace acus::replay {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class LabelledReplayTest : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(folder_, R"({"needle_force": {}, "ultrasound": {}})", 10);
    WriteTextFile(folder_ / "corridor.csv", "name,x_mm,y_mm,z_mm\nentry,3,0,0\ntarget,3,5,20\n");
    session::WriteSession(folder_ / "session", Insertion(), context_);
  }

  /// Straight in at (3, 5) to 25 mm; the probe's plane is x = 3.2, off borders of voxels.
  static session::Session Insertion() {
    session::Session session;
    session.name = "insertion";
    Eigen::Isometry3d needle = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
    probe.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    probe.translation() << 3.2, 0.0, 0.0;
    for (int ms = 0; ms <= 1000; ++ms) {
      needle.translation() << 3.0, 5.0, -5.0 + 0.03 * ms;
      session.needle.push_back({ms * std::int64_t{1'000'000}, needle, true});
      if (ms % 20 == 0) session.probe.push_back({ms * std::int64_t{1'000'000}, probe, true});
    }
    return session;
  }

  void RunLabelled(const char* run_folder, LabelFormat format, int num_threads = 1) {
    RunContext context;
    context.num_threads = num_threads;
    ReplayOptions options;
    options.run_folder = folder_ / run_folder;
    options.labels = format;
    options.film = false;
    options.png = PngChoice::kNone;
    const std::vector<scenario::Override> changes = {
        {"/patient/corridor", (folder_ / "corridor.csv").string()}};
    ReplaySession(scenario::ReadScenario(folder_ / "scene.json", changes), folder_ / "session",
                  options, context);
  }

  /// Bytes of a stack of images.
  std::vector<std::uint8_t> Stack(const std::string& file) {
    const auto read = volume::ReadScalarFile(folder_ / file);
    size_ = read.geometry.size;
    const auto* first = reinterpret_cast<const std::uint8_t*>(read.bytes.data());
    return {first, first + read.bytes.size()};
  }

  Eigen::Array3i size_;
};

TEST_F(LabelledReplayTest, EachPixelIsWhatThePosesAndTheMapSay) {
  RunLabelled("run", LabelFormat::kNifti);
  const auto labels = Stack("run/labelled/labels.nii.gz");
  const auto map = volume::ReadTissues(folder_ / "labels.seg.nrrd");
  const Eigen::Affine3d index_from_ct = map.geometry.index_from_ct();
  const CsvTable frames(folder_ / "run/labelled/frames.csv");
  ASSERT_EQ(frames.num_rows(), 11U);
  ASSERT_EQ(size_[2], 11);
  int tissue = 0, shaft = 0, tip = 0;
  for (int frame = 0; frame < size_[2]; ++frame) {
    const auto at = [&](const std::string& column) {
      return frames.Numbers(column)[static_cast<std::size_t>(frame)];
    };
    Eigen::Affine3d ct_from_image = Eigen::Affine3d::Identity();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 4; ++c) ct_from_image(r, c) = at(Message("ct_from_image_", r, c));
    }
    const double tip_z_mm = -5.0 + 3.0 * frame;
    EXPECT_NEAR(at("ct_from_needle_23"), tip_z_mm, 1e-9);
    const Eigen::Vector3d seen_mm =
        ct_from_image * Eigen::Vector3d(at("tip_column_px"), at("tip_row_px"), 0.0);
    EXPECT_LT((seen_mm - Eigen::Vector3d(3.2, 5.0, tip_z_mm)).norm(), 1e-6);
    EXPECT_NEAR(at("tip_off_plane_mm"), -0.2, 1e-9);
    for (int r = 0; r < size_[1]; r += 3) {
      for (int c = 0; c < size_[0]; c += 3) {
        const int label = labels[static_cast<std::size_t>((frame * size_[1] + r) * size_[0] + c)];
        const Eigen::Vector3d place_mm = ct_from_image * Eigen::Vector3d(c, r, 0);
        if (label == 251) {
          ++shaft;
          EXPECT_LT(std::abs(place_mm.y() - 5.0), 0.6);
          EXPECT_LT(place_mm.z(), tip_z_mm);
        } else if (label == 252) {
          ++tip;
          EXPECT_LE((place_mm - seen_mm).norm(), 1.5 + 1e-6);
        } else if (label == 250) {
          EXPECT_LE((place_mm - Eigen::Vector3d(3, 5, 20)).norm(), 3.0 + 1e-3);
        } else if (label != 255) {
          const Eigen::Vector3d index = index_from_ct * place_mm;
          if ((index.array() - index.array().floor() - 0.5).abs().minCoeff() < 1e-3) continue;
          EXPECT_EQ(label, volume::LabelAt(map, index_from_ct, place_mm));
          ++tissue;
        }
      }
    }
  }
  EXPECT_GT(tissue, 10'000);
  EXPECT_GT(shaft, 100);
  EXPECT_GT(tip, 50);
}

TEST_F(LabelledReplayTest, ImagesAreThoseOfTheSequenceAndForcesThoseOfTheLog) {
  RunLabelled("run", LabelFormat::kNifti);
  const auto images = Stack("run/labelled/images.nii.gz");
  session::SequenceFile sequence(folder_ / "run/images.igs.mha");
  std::vector<std::uint8_t> pixels;
  for (std::size_t frame = 0; frame < sequence.num_frames(); ++frame) {
    const auto image = sequence.ReadImageMarkedFar(frame);
    pixels.insert(pixels.end(), image.pixels.begin(), image.pixels.end());
  }
  EXPECT_TRUE(images == pixels);
  const CsvTable frames(folder_ / "run/labelled/frames.csv");
  const CsvTable forces(folder_ / "run/forces.csv");
  const auto of_frames = frames.Numbers("force_axial_n");
  const auto of_steps = forces.Numbers("force_axial_n");
  double largest_n = 0.0;
  for (std::size_t n = 0; n < of_frames.size(); ++n) {
    EXPECT_EQ(of_frames[n], of_steps[100 * n]) << n;
    largest_n = std::max(largest_n, of_frames[n]);
  }
  EXPECT_GT(largest_n, 0.1);
}

TEST_F(LabelledReplayTest, TheSameBytesWithAnyNumberOfThreadsInAllFormats) {
  for (const LabelFormat format : {LabelFormat::kPng, LabelFormat::kNifti, LabelFormat::kHdf5}) {
    const std::string name = Message("f", static_cast<int>(format));
    RunLabelled((name + "_one").c_str(), format, 1);
    RunLabelled((name + "_three").c_str(), format, 3);
    const auto hash = [&](const std::string& run) {
      return Sha256OfPath(folder_ / (name + run) / "labelled");
    };
    EXPECT_EQ(hash("_one"), hash("_three")) << name;
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "f1_one/labelled/images/00010.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "f1_one/labelled/labels/00010.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "f1_one/labelled/preview.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "f3_one/labelled/labelled.h5"));
  const auto document = config::ReadJson(folder_ / "f1_one/labelled/labelled.json");
  EXPECT_EQ(document.at("frames"), 11);
  EXPECT_EQ(document.at("classes").back().at("name"), "beyond_image");
  EXPECT_EQ(document.at("target").at("rest_ct_mm"), (nlohmann::json{3.0, 5.0, 20.0}));
}

TEST_F(LabelledReplayTest, APatientWithoutALabelMapIsRefused) {
  const std::vector<scenario::Override> changes = {{"/patient/labels", nullptr},
                                                   {"/effects/needle_force", nullptr}};
  ReplayOptions options;
  options.run_folder = folder_ / "run";
  options.labels = LabelFormat::kPng;
  EXPECT_THAT(
      [&] {
        ReplaySession(scenario::ReadScenario(folder_ / "scene.json", changes), folder_ / "session",
                      options, context_);
      },
      ThrowsMessage<InputError>(HasSubstr("the patient has no label map")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run"));
}

}  // namespace
}  // namespace acus::replay
