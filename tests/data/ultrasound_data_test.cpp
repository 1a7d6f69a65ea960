// Ultrasound of a real abdomen: what any sonographer would expect of it.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <optional>

#include "acus/data/image/png.h"
#include "acus/data/volume/volume_io.h"
#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "acus/imaging/ultrasound/display/annotate.h"
#include "support/shared_data.h"

namespace acus::ultrasound {
namespace {

namespace fs = std::filesystem;

/// On the skin, where the line from `inside` along `outwards` leaves the body; looking back inside.
Eigen::Isometry3d ProbeOnSkin(const slicing::CtSampler& sampler, const Eigen::Vector3d& inside,
                              const Eigen::Vector3d& outwards, const Eigen::Vector3d& marked_side) {
  // The last tissue on the line: gas within the body does not end it.
  double skin_mm = 0.0;
  for (double s = 0.0; s < 300.0; s += 0.25) {
    if (sampler.At(inside + s * outwards.normalized()) > -200.0) skin_mm = s;
    if (s > skin_mm + 25.0) break;  // Beyond it is the table.
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d y = -outwards.normalized();
  const Eigen::Vector3d x = (marked_side - marked_side.dot(y) * y).normalized();
  pose.linear() << x, y, x.cross(y);
  pose.translation() = inside + (skin_mm - 2.0) * outwards.normalized();  // Pressed in by 2 mm.
  return pose;
}

class RealAbdomen : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (const auto folder = testing_support::SharedData("ct/ircadb01_dicom")) {
      ct_ = volume::ReadCt(*folder, "", RunContext{});
    }
  }
  void SetUp() override {
    if (!ct_) GTEST_SKIP() << "test data ct/ircadb01_dicom is not here";
  }

  /// A linear probe over a place inside; kept as a file if ACUS_KEEP_IMAGES names a folder.
  void Look(const char* acoustics, const Eigen::Vector3d& inside_mm,
            const Eigen::Vector3d& outwards, const Eigen::Vector3d& marked_side, const char* file) {
    const fs::path configs = fs::path(ACUS_SOURCE_DIR) / "configs";
    const acoustics::Probe probe = acoustics::ReadProbe(configs / "probes" / "linear_l14.json");
    const Eigen::Isometry3d pose =
        ProbeOnSkin(slicing::CtSampler(*ct_), inside_mm, outwards, marked_side);
    BModeRenderer renderer(*ct_, probe, ReadBModeOptions(configs / "acoustics" / acoustics));
    renderer.Render(pose, std::nullopt, bmode_);
    slice_.emplace(*ct_, renderer.image(), probe.slice_thickness_mm);
    image::GrayImage slice;
    slice_->Render(pose, std::nullopt, slice);
    if (const char* folder = std::getenv("ACUS_KEEP_IMAGES")) {
      image::GrayImage both;
      Screen(probe, Screen::Shows::kBoth).Compose(bmode_, &slice, file, both);
      image::WritePng(fs::path(folder) / file, both);
    }
    margin_px_ = (probe.image_width_px - acoustics::ScanGridOf(probe).lines()) / 2;
  }

  int Row(double depth_mm) const {
    return static_cast<int>(depth_mm / slice_->image().axial_mm_per_px);
  }
  double Mean(int column, int first_row, int end_row) const {
    double sum = 0.0;
    for (int r = first_row; r < end_row; ++r) sum += bmode_.At(column, r);
    return sum / std::max(1, end_row - first_row);
  }

  /// The first row of bone in a column, or -1.
  int BoneSurface(int column) const {
    const slicing::BeamImage& hu = slice_->hu();
    int surface = -1;
    float peak = -1024.0F;
    for (int r = Row(3.0); r < Row(48.0); ++r) {
      peak = std::max(peak, hu.row(r)[column]);
      if (surface < 0 && hu.row(r)[column] > 250.0F) surface = r;
    }
    return peak > 400.0F ? surface : -1;
  }

  /// Counts columns with bone all over the width of the beam, and those of them that are bright at
  /// its surface and dark below.
  void CountBones(int& with_bone, int& bright, int& dark) const {
    with_bone = bright = dark = 0;
    constexpr int kHalfBeamPx = 5;
    for (int c = margin_px_ + kHalfBeamPx; c < bmode_.width - margin_px_ - kHalfBeamPx; ++c) {
      const int surface = BoneSurface(c);
      bool whole = true;
      for (int d = -kHalfBeamPx; d <= kHalfBeamPx; ++d) whole = whole && BoneSurface(c + d) >= 0;
      if (!whole) continue;
      ++with_bone;
      std::uint8_t line = 0;
      for (int r = surface - Row(2.0); r <= surface + Row(2.0); ++r) {
        line = std::max(line, bmode_.At(c, r));
      }
      bright += line >= 200;
      dark += Mean(c, surface + Row(5.0), bmode_.height) <= 10.0;
    }
  }

  static std::optional<volume::CtVolume> ct_;
  image::GrayImage bmode_;
  std::optional<slicing::CtSliceRenderer> slice_;
  int margin_px_ = 0;
};
std::optional<volume::CtVolume> RealAbdomen::ct_;

TEST_F(RealAbdomen, TheSpineIsABrightLineWithAShadow) {
  for (const char* acoustics : {"hu_2010.json", "hu_textured.json"}) {
    Look(acoustics, {145.6, 185.6, 62.4}, {0, 1, 0}, {1, 0, 0}, "spine.png");
    int with_bone = 0;
    int bright = 0;
    int dark = 0;
    CountBones(with_bone, bright, dark);
    EXPECT_GT(with_bone, 20);
    EXPECT_GE(bright, 0.9 * with_bone) << acoustics;
    EXPECT_GE(dark, 0.8 * with_bone) << acoustics;  // Walls along the beam reflect little.
  }
}

TEST_F(RealAbdomen, RibsShadowTheLiverAndTheGapsBetweenThemDoNot) {
  for (const char* acoustics : {"hu_2010.json", "hu_textured.json"}) {
    Look(acoustics, {85.6, 135.6, 122.4}, {-1, -0.2, 0}, {0, 0, 1}, "ribs.png");
    int with_bone = 0;
    int bright = 0;
    int dark = 0;
    CountBones(with_bone, bright, dark);
    EXPECT_GT(with_bone, 20);
    EXPECT_GE(bright, 0.9 * with_bone) << acoustics;
    EXPECT_GE(dark, 0.9 * with_bone) << acoustics;
    int windows = 0;
    for (int c = margin_px_; c < bmode_.width - margin_px_; ++c)
      windows += Mean(c, Row(30), Row(50)) > 25.0;
    EXPECT_GT(windows, 150) << acoustics;
  }
}

}  // namespace
}  // namespace acus::ultrasound
