#include "benchmarks/aperture_sweep.h"

#include <functional>
#include <string>

#include "acus/base/core/text_table.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "benchmarks/image_errors.h"

namespace acus::benchmarks {
namespace {

using ultrasound::ApertureOptions;

/// What is not being swept is as in the presets.
struct ApertureSetting {
  int lines = 256;
  int samples = 2048;
  ApertureOptions options;
};

class ApertureSweeper {
 public:
  ApertureSweeper(bool quick, const RunContext& context)
      : quick_(quick), context_(context), scene_(MakeImageScene()) {}

  std::vector<Row> Run() {
    const auto values = [this](std::vector<double> all, std::vector<double> few) {
      return quick_ ? few : all;
    };
    Sweep(
        "aperture_rays", values({1, 3, 5, 9, 13, 21}, {1, 13}),
        [](ApertureSetting& s, int v) { s.options.aperture_rays = v; }, 31);
    Sweep(
        "elevation_planes", values({1, 3, 5, 7}, {1, 5}),
        [](ApertureSetting& s, int v) { s.options.elevation_planes = v; }, 15);
    Sweep(
        "lines", values({64, 128, 256, 384}, {64, 256}),
        [](ApertureSetting& s, int v) { s.lines = v; }, 1024);
    Sweep(
        "samples", values({256, 512, 1024, 2048, 4096}, {256, 2048}),
        [](ApertureSetting& s, int v) { s.samples = v; }, 8192);
    Effects();
    return std::move(rows_);
  }

 private:
  TimedImage Rendered(const ApertureSetting& setting) const {
    ultrasound::BeamTissue tissue{
        .ct = &scene_.ct, .labels = &scene_.labels, .acoustics = &scene_.acoustics};
    tissue.fibres_in_ct["muscle"] = {1.0, 0.0, 0.3};
    ultrasound::ApertureRenderer renderer(tissue, ImageProbe(setting.lines, setting.samples),
                                          setting.options);
    return TimedRender(scene_, renderer, {}, quick_ ? 4 : 12);
  }

  void Sweep(const std::string& knob, const std::vector<double>& values,
             const std::function<void(ApertureSetting&, int)>& turn, int most_expensive) {
    context_.Checkpoint(knob, 0.2 * static_cast<double>(++knobs_));
    ApertureSetting setting;
    setting.options.noise = false;  // Drawn by sample and line: another one for other numbers.
    const image::GrayImage usual = Rendered(setting).image;
    turn(setting, most_expensive);
    const image::GrayImage reference = Rendered(setting).image;
    for (const double value : values) {
      turn(setting, static_cast<int>(value));
      const TimedImage image = Rendered(setting);
      Row row = TimedRow("aperture", knob, RoundedText(value, 2), image);
      row.reference = "the same at " + std::to_string(most_expensive);
      row.is_default = image.image.pixels == usual.pixels;
      AddImageErrors(std::move(row), image.image, reference, ImageChange::kError, rows_);
    }
  }

  /// What turning one effect on or off changes, and what it saves or costs.
  void Effects() {
    const image::GrayImage reference = Rendered({}).image;
    const auto with = [&](const char* name, const std::function<void(ApertureOptions&)>& turn) {
      ApertureSetting setting;
      turn(setting.options);
      const TimedImage image = Rendered(setting);
      Row row = TimedRow("aperture", "effect", name, image);
      row.reference = "as in the presets";
      AddImageErrors(std::move(row), image.image, reference, ImageChange::kEffect, rows_);
    };
    with("no texture", [](ApertureOptions& o) { o.texture = false; });
    with("no clutter", [](ApertureOptions& o) { o.clutter = false; });
    with("no noise", [](ApertureOptions& o) { o.noise = false; });
    with("no ring-down", [](ApertureOptions& o) { o.ring_down = false; });
    with("no interfaces", [](ApertureOptions& o) { o.interfaces = false; });
    with("no shadow", [](ApertureOptions& o) { o.shadow = false; });
    with("with fibres", [](ApertureOptions& o) { o.fibre_texture = true; });
    with("with side lobes", [](ApertureOptions& o) { o.side_lobes = true; });
    with("with refraction", [](ApertureOptions& o) { o.refraction = true; });
    with("with three angles", [](ApertureOptions& o) {
      o.display.compound_angles = 3;
      o.display.compound_span_rad = 0.28;
    });
  }

  bool quick_;
  const RunContext& context_;
  ImageScene scene_;
  int knobs_ = 0;
  std::vector<Row> rows_;
};

}  // namespace

Sweep ApertureSweep() {
  return {
      "aperture", "Ultrasound through a finite aperture",
      "The scene of the sweep image under the model aperture; 512 x 512 pixels, one thread. "
      "Errors are root mean squares in dB of the display, of pixels and of means over 1.5 mm, "
      "in which speckle averages out. A step is one image.",
      [](bool quick, const RunContext& context) { return ApertureSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
