#include "acus/imaging/slicing/kernels.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "support/instruction_sets.h"
#include "support/synthetic_ct.h"

namespace acus::slicing {
namespace {

using testing_support::OnEveryInstructionSet;

acoustics::Probe KernelsSmallProbe(acoustics::ProbeKind kind) {
  return {.name = "test",
          .kind = kind,
          .frequency_mhz = 5,
          .scan_lines = 60,
          .width_mm = 30,
          .radius_mm = 40,
          .field_of_view_rad = 0.9,
          .depth_mm = 40,
          .image_width_px = 101,
          .image_height_px = 90,
          .slice_thickness_mm = 3,
          .pulse_length_mm = 2,
          .beam_width_mm = 2,
          .dynamic_range_db = 60,
          .gain_db = 30};
}

TEST(Kernels, GiveTheSameBitsOnEveryInstructionSet) {
  RandomStream random(5, "voxels");
  const auto ct = testing_support::SyntheticCt(
      {50, 60, 40}, 1.0, [&](double, double, double) { return random.Uniform(0.0, 100.0); });
  ultrasound::BModeOptions options = ultrasound::DefaultBModeOptions();
  options.texture = true;
  options.attenuation = true;
  options.angle_exponent = 1;
  Eigen::Isometry3d pose(Eigen::Translation3d(25, 3, 20) *
                         Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 1, 1).normalized()));
  image::NeedleInImage needle;
  needle.tip_in_ct_mm << 25, 30, 21;
  needle.axis_in_ct = Eigen::Vector3d(1, 1, 0).normalized();
  needle.length_mm = 50;
  needle.radius_mm = 0.6;
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    image::GrayImage first;
    OnEveryInstructionSet([&](const char* name) {
      ultrasound::BModeRenderer renderer(ct, KernelsSmallProbe(kind), options);
      image::GrayImage image;
      renderer.Render(pose, needle, image);
      if (first.pixels.empty()) first = image;
      EXPECT_EQ(image.pixels, first.pixels) << name;
    });
    // Not just black.
    long sum = 0;
    for (const std::uint8_t p : first.pixels) sum += p;
    EXPECT_GT(sum, 10 * static_cast<long>(first.pixels.size()));
  }
}

TEST(Kernels, CompressionIsTheLogarithm) {
  image::AlignedFloats in;
  constexpr int kCount = 4096;
  in.Reserve(kCount);
  for (int n = 0; n < kCount; ++n)
    in.data()[n] = static_cast<float>(std::pow(10.0, -9.0 + n * 12.0 / kCount));
  in.data()[0] = 0.0F;
  constexpr float kGain = 1e6F;
  const auto scale = static_cast<float>(255.0 / std::log2(1.0 + 1e6));
  std::vector<std::uint8_t> out(kCount);
  OnEveryInstructionSet([&](const char* name) {
    kernels::CompressRow(in.data(), kGain, scale, kCount, out.data());
    for (int n = 0; n < kCount; ++n) {
      const double exact = 255.0 * std::log1p(1e6 * in.data()[n]) / std::log1p(1e6);
      EXPECT_NEAR(out[n], std::min(255.0, exact), 0.501) << name << " at " << in.data()[n];
    }
  });
}

TEST(Kernels, WindowsAreSymmetricSums) {
  image::AlignedFloats row;
  row.Reserve(96);
  std::fill_n(row.data(), 96, 0.0F);
  row.data()[40] = 1.0F;
  const float half[] = {0.4F, 0.2F, 0.1F};
  image::AlignedFloats out;
  out.Reserve(64);
  OnEveryInstructionSet([&](const char* name) {
    kernels::BlurAcrossRow(row.data() + 16, half, 2, 64, out.data());
    const float expected[] = {0.1F, 0.2F, 0.4F, 0.2F, 0.1F};
    for (int n = 0; n < 64; ++n) {
      const int t = n - (40 - 16 - 2);
      EXPECT_EQ(out.data()[n], t >= 0 && t < 5 ? expected[t] : 0.0F) << name << " lane " << n;
    }
  });
}

}  // namespace
}  // namespace acus::slicing
