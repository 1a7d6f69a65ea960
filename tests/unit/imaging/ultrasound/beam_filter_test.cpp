#include "acus/imaging/ultrasound/beams/beam_filter.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/random.h"

namespace acus::ultrasound {
namespace {

TEST(BeamFilter, NoiseHasAnEnvelopeOfOneAtAllDepths) {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.scan_lines = 192;
  probe.samples_per_line = 600;
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  const BeamFilter filter(probe, BeamOptions{}, grid);
  RandomStream random(3, "noise");
  ComplexBeams noise;
  for (slicing::BeamImage* part : {&noise.re, &noise.im}) {
    part->Resize(grid.lines(), grid.samples);
    for (int k = 0; k < grid.samples; ++k) {
      for (int l = 0; l < grid.lines(); ++l) {
        part->row(k)[l] =
            static_cast<float>(filter.NoiseGain(k) * random.Normal() * std::numbers::sqrt2 / 2.0);
      }
      part->FillMargins(k);
    }
  }
  image::AlignedFloats scratch;
  scratch.Reserve(2 * static_cast<std::size_t>(noise.re.stride()));
  slicing::BeamImage intensity;
  intensity.Resize(grid.lines(), grid.samples);
  filter.Apply(noise, 0, grid.samples, scratch.data(), intensity);
  // Away from the sides, where the noise is mirrored.
  for (int first = 0; first < 600; first += 200) {
    double sum = 0.0;
    for (int k = first; k < first + 200; ++k) {
      for (int l = 40; l < 152; ++l) sum += intensity.row(k)[l];
    }
    EXPECT_NEAR(std::sqrt(sum / (200.0 * 112.0)), 1.0, 0.05) << first;
  }
}

}  // namespace
}  // namespace acus::ultrasound
