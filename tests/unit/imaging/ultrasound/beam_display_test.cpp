#include "acus/imaging/ultrasound/display/beam_display.h"

#include <gtest/gtest.h>

namespace acus::ultrasound {
namespace {

TEST(BeamDisplay, BothEdgesOfAFanAreAlike) {
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kCurvilinear, acoustics::ProbeKind::kPhased}) {
    acoustics::Probe probe = acoustics::DefaultProbe();
    probe.kind = kind;
    probe.scan_lines = 24;  // Few: a line is several pixels wide.
    probe.samples_per_line = 200;
    probe.image_width_px = 151;
    probe.image_height_px = 120;
    probe.field_of_view_rad = 0.9;
    if (kind == acoustics::ProbeKind::kCurvilinear) probe.radius_mm = 40;
    const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
    slicing::BeamImage intensity;
    intensity.Resize(grid.lines(), grid.samples);
    for (int k = 0; k < grid.samples; ++k) {
      std::fill_n(intensity.row(k), grid.lines(), 1.0F);
      intensity.FillMargins(k);
    }
    BeamDisplay display(probe, grid);
    display.Compress(intensity, 0, grid.samples);
    image::GrayImage image;
    display.Show(image, 1);
    int seen = 0;
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        const int grey = image.At(column, row);
        EXPECT_NEAR(grey, image.At(image.width - 1 - column, row), 1) << column << " " << row;
        seen += grey > 200;
      }
    }
    EXPECT_GT(seen, 2000);
  }
}

}  // namespace
}  // namespace acus::ultrasound
