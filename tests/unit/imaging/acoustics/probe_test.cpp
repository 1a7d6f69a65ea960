#include "acus/imaging/acoustics/probe.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::acoustics {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::filesystem::path Preset(const char* name) {
  return std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "probes" / name;
}

Probe ProbeLinear() {
  return {.name = "test",
          .kind = ProbeKind::kLinear,
          .frequency_mhz = 10,
          .width_mm = 38,
          .depth_mm = 60,
          .image_width_px = 512,
          .image_height_px = 512,
          .dynamic_range_db = 60};
}

Probe Curved() {
  Probe probe = ProbeLinear();
  probe.kind = ProbeKind::kCurvilinear;
  probe.scan_lines = 128;
  probe.radius_mm = 60;
  probe.field_of_view_rad = 1.2;
  probe.depth_mm = 150;
  return probe;
}

TEST(Probe, PresetsAreReadWithTheDefaultsOfTheSchema) {
  const Probe linear = ReadProbe(Preset("linear_l14.json"));
  EXPECT_EQ(linear.kind, ProbeKind::kLinear);
  EXPECT_EQ(linear.width_mm, 50.0);
  EXPECT_EQ(linear.image_width_px, 512);
  EXPECT_EQ(linear.dynamic_range_db, 60.0);
  const Probe curved = ReadProbe(Preset("curvilinear_c5.json"));
  EXPECT_EQ(curved.kind, ProbeKind::kCurvilinear);
  EXPECT_NEAR(curved.field_of_view_rad, 54.0 * M_PI / 180.0, 1e-12);
  EXPECT_EQ(curved.scan_lines, 384);
}

TEST(PlaceInBeams, FindsTheSamplesOfTheGridAlsoWhereLinesLean) {
  for (Probe probe : {ProbeLinear(), Curved()}) {
    for (const double steer_rad : {0.0, 0.2, -0.3}) {
      probe.steer_rad = steer_rad;
      probe.scan_lines = 65;
      probe.samples_per_line = 301;
      const ScanGrid grid = BeamGridOf(probe);
      for (int line = 0; line < grid.lines(); line += 16) {
        for (int sample = 0; sample < grid.samples; sample += 50) {
          const Eigen::Vector2d at_mm =
              grid.start_mm[static_cast<std::size_t>(line)] +
              sample * grid.step_mm * grid.direction[static_cast<std::size_t>(line)];
          const BeamPlace place = PlaceInBeams(probe, grid, at_mm);
          EXPECT_NEAR(place.line, line, 1e-6) << steer_rad;
          EXPECT_NEAR(place.sample, sample, 1e-6) << steer_rad;
        }
      }
    }
  }
}

TEST(Probe, TheFaceOfACurvedProbeIsTheChordOfItsArc) {
  EXPECT_EQ(FaceLengthMm(ProbeLinear()), 38.0);
  EXPECT_NEAR(FaceLengthMm(Curved()), 2.0 * 60.0 * std::sin(0.6), 1e-12);
}

TEST(Probe, TheArrayOfACurvedProbeIsAsLongAsItsArc) {
  EXPECT_EQ(ReadProbe(Preset("linear_l14.json")).ArrayLengthMm(), 50.0);
  Probe curved = ReadProbe(Preset("curvilinear_c5.json"));
  EXPECT_NEAR(curved.ArrayLengthMm(), 2.0 * M_PI * curved.radius_mm * 54.0 / 360.0, 1e-9);
}

TEST(Probe, ALinearProbeWithoutWidthSaysSo) {
  const testing_support::TemporaryFolder folder;
  const auto path = folder / "probe.json";
  std::ofstream(path) << R"({"format": "acus-probe/1", "name": "x", "kind": "linear",
                             "frequency_mhz": 5, "depth_mm": 50})";
  EXPECT_THAT([&] { ReadProbe(path); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("/width_mm"), HasSubstr("linear"))));
}

TEST(Probe, APhasedProbeSteersFromTheMiddleOfItsFace) {
  const Probe probe = ReadProbe(Preset("phased_s5_1.json"));
  EXPECT_EQ(probe.kind, ProbeKind::kPhased);
  EXPECT_EQ(probe.ArrayLengthMm(), 22.4);
  for (const ScanGrid& grid : {ScanGridOf(probe), BeamGridOf(probe)}) {
    EXPECT_EQ(grid.lines(), 192);
    EXPECT_EQ(grid.start_mm.front(), Eigen::Vector2d(0, 0));
    EXPECT_EQ(grid.start_mm.back(), Eigen::Vector2d(0, 0));
    const double angle = std::atan2(grid.direction.back().x(), grid.direction.back().y());
    EXPECT_NEAR(angle, 40.0 * M_PI / 180.0, 1e-12);
  }
  // The whole sector is in the image, its tip at the top.
  const image::ImageGeometry image = ImageOf(probe);
  EXPECT_EQ(image.depth_of_top_row_mm, 0.0);
  EXPECT_GE(image.width_px * image.lateral_mm_per_px, 2 * 160 * std::sin(40 * M_PI / 180) - 1e-9);
}

TEST(Probe, BeamsReachFromFaceToDepthOverTheWholeWidth) {
  Probe probe = ReadProbe(Preset("linear_l14_5.json"));
  const ScanGrid linear = BeamGridOf(probe);
  EXPECT_EQ(linear.lines(), 256);
  EXPECT_EQ(linear.samples, 2048);
  EXPECT_DOUBLE_EQ(linear.start_mm.front().x(), -19.2);
  EXPECT_DOUBLE_EQ(linear.start_mm.back().x(), 19.2);
  EXPECT_DOUBLE_EQ(linear.step_mm * 2047, 50.0);
  for (int l = 0; l < linear.lines(); ++l) {
    EXPECT_EQ(linear.start_mm[l].y(), 0.0) << "on the face";
    EXPECT_EQ(linear.direction[l], Eigen::Vector2d::UnitY());
  }
  const ScanGrid fan = BeamGridOf(ReadProbe(Preset("curvilinear_c5_2.json")));
  const Eigen::Vector2d end = fan.start_mm[0] + fan.step_mm * 2047 * fan.direction[0];
  EXPECT_NEAR((end + Eigen::Vector2d(0, 60)).norm(), 210.0, 1e-9);
  probe.scan_lines = 1;
  EXPECT_THROW(BeamGridOf(probe), InputError);
  probe.scan_lines = 2;
  probe.depth_mm = 0;
  EXPECT_THROW(BeamGridOf(probe), InputError);
}

TEST(Probe, ExtremesWorkOrSayWhatIsAllowed) {
  const testing_support::TemporaryFolder folder;
  const auto path = folder / "probe.json";
  const auto read = [&](const char* pointer, const nlohmann::json& value) {
    auto document = config::ReadJson(Preset("curvilinear_c5_2.json"));
    document["pitch_mm"] = 0;
    document[nlohmann::json::json_pointer(pointer)] = value;
    config::WriteJson(path, document);
    return ReadProbe(path);
  };
  const auto refuses = [&](const char* pointer, const nlohmann::json& value) {
    EXPECT_THAT([&] { read(pointer, value); }, ThrowsMessage<InputError>(HasSubstr(pointer)))
        << value;
  };
  EXPECT_EQ(ScanGridOf(read("/field_of_view_deg", 10)).lines(), 256);
  EXPECT_EQ(BeamGridOf(read("/depth_mm", 100)).samples, 2048);
  EXPECT_EQ(BeamGridOf(read("/radius_mm", 100)).samples, 2048);
  EXPECT_EQ(read("/dynamic_range_db", 120).dynamic_range_db, 120.0);
  refuses("/dynamic_range_db", 121);
  refuses("/depth_mm", 0);
  refuses("/depth_mm", 301);
  refuses("/field_of_view_deg", 4.9);
  refuses("/field_of_view_deg", 161);
  refuses("/fractional_bandwidth", 0.04);
  refuses("/fractional_bandwidth", 1.6);
  refuses("/elements", 7);
  refuses("/elements", 1025);
  refuses("/pitch_mm", -0.1);
  refuses("/pitch_mm", 0.6);  // Longer than the face.
  refuses("/f_number", 0.4);
  refuses("/f_number", 21);
  refuses("/elevation_aperture_mm", 0.4);
  refuses("/elevation_focus_mm", 301);
  refuses("/samples_per_line", 63);
  refuses("/samples_per_line", 8193);
  refuses("/kind", "convex");
}

TEST(Probe, WhatIsSetWithoutAFileIsCheckedToo) {
  const auto with = [](double depth_mm, double dynamic_range_db) {
    Probe probe = ProbeLinear();
    probe.depth_mm = depth_mm;
    probe.dynamic_range_db = dynamic_range_db;
    return probe;
  };
  EXPECT_NO_THROW(CheckedProbe(with(0.05, 120.0)));
  EXPECT_THROW(CheckedProbe(with(0.0, 60.0)), InputError);
  EXPECT_THROW(CheckedProbe(with(60.0, 120.1)), InputError);
  EXPECT_THROW(CheckedProbe(with(60.0, 0.0)), InputError);
  Probe fan = ReadProbe(Preset("curvilinear_c5_2.json"));
  EXPECT_NO_THROW(CheckedProbe(fan));
  for (const double field_of_view_rad : {0.0, 3.1, std::nan("")}) {
    fan.field_of_view_rad = field_of_view_rad;
    EXPECT_THROW(CheckedProbe(fan), InputError) << field_of_view_rad;
  }
}

TEST(Probe, DamagedFilesAreReadOrRefused) {
  const testing_support::TemporaryFolder folder;
  const std::string valid = ReadTextFile(Preset("curvilinear_c5.json"));
  const auto path = folder / "damaged.json";
  const auto read = [&] { ReadProbe(path); };
  EXPECT_GT(testing_support::ReadDamagedCopies(valid, path, 200, read), 50);
}

TEST(Probe, PixelsAreSquareAndTheTopMiddleOfALinearImageIsTheOrigin) {
  const image::ImageGeometry image = ImageOf(ProbeLinear());
  EXPECT_DOUBLE_EQ(image.axial_mm_per_px, 60.0 / 511.0);
  EXPECT_DOUBLE_EQ(image.lateral_mm_per_px, image.axial_mm_per_px);
  const Eigen::Vector3d top_middle = image.probe_from_image() * Eigen::Vector3d(255.5, 0, 0);
  EXPECT_NEAR(top_middle.norm(), 0.0, 1e-12);
  const Eigen::Vector3d bottom = image.probe_from_image() * Eigen::Vector3d(255.5, 511, 0);
  EXPECT_NEAR((bottom - Eigen::Vector3d(0, 60, 0)).norm(), 0.0, 1e-9);
  // The marked side, +x, is on the right.
  EXPECT_GT((image.probe_from_image() * Eigen::Vector3d(511, 0, 0)).x(), 0.0);
}

TEST(Probe, AWideProbeMakesPixelsGrowUntilItFits) {
  Probe probe = ProbeLinear();
  probe.width_mm = 100;
  EXPECT_DOUBLE_EQ(ImageOf(probe).lateral_mm_per_px, 100.0 / 512.0);
  EXPECT_EQ(ScanGridOf(probe).lines(), 512);
  EXPECT_LT(ScanGridOf(probe).samples, 512);
}

TEST(Probe, LinesOfALinearProbeLieOnThePixelColumnsOfItsFace) {
  const Probe probe = ProbeLinear();
  const image::ImageGeometry image = ImageOf(probe);
  const ScanGrid grid = ScanGridOf(probe);
  const int left = (512 - grid.lines()) / 2;
  for (int l = 0; l < grid.lines(); ++l) {
    const Eigen::Vector3d pixel = image.probe_from_image() * Eigen::Vector3d(left + l, 0, 0);
    EXPECT_NEAR(grid.start_mm[l].x(), pixel.x(), 1e-9);
    EXPECT_LE(std::abs(grid.start_mm[l].x()), 19.0);
  }
  EXPECT_NEAR(grid.lines() * image.lateral_mm_per_px, 38.0, 2 * image.lateral_mm_per_px);
  EXPECT_EQ(grid.samples, 512);
}

TEST(Probe, AFanStartsOnTheFaceAndItsSectorFillsTheImage) {
  const Probe probe = Curved();
  const ScanGrid grid = ScanGridOf(probe);
  const image::ImageGeometry image = ImageOf(probe);
  ASSERT_EQ(grid.lines(), 128);
  const Eigen::Vector2d centre(0.0, -60.0);
  for (int l = 0; l < 128; ++l) EXPECT_NEAR((grid.start_mm[l] - centre).norm(), 60.0, 1e-9);
  EXPECT_NEAR(std::acos(grid.direction.front().dot(grid.direction.back())), 1.2, 1e-9);
  EXPECT_LT(grid.start_mm.front().x(), 0.0);
  // The corners of the sector: the top at the outermost line, the sides at its end.
  EXPECT_NEAR(image.depth_of_top_row_mm, grid.start_mm.front().y(), 1e-9);
  const double half_width = 210.0 * std::sin(0.6);
  EXPECT_LE(half_width, 0.5 * 512 * image.lateral_mm_per_px + 1e-9);
  EXPECT_GE(image.depth_of_top_row_mm + 511 * image.axial_mm_per_px, 150.0 - 1e-9);
}

TEST(Probe, ImagesWithoutPixelsOrWithFlatOnesAreRefused) {
  EXPECT_THROW(ScanGridOf(image::ImageGeometry{.width_px = 0, .height_px = 4}), InputError);
  EXPECT_THROW(ScanGridOf(image::ImageGeometry{.width_px = 4, .height_px = 9000}), InputError);
  EXPECT_THROW(
      ScanGridOf(image::ImageGeometry{.width_px = 4, .height_px = 4, .lateral_mm_per_px = 0.0}),
      InputError);
  EXPECT_NO_THROW(ScanGridOf(image::ImageGeometry{.width_px = 1, .height_px = 1}));
}

}  // namespace
}  // namespace acus::acoustics
