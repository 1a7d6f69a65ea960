#include "benchmarks/image_sweep.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "acus/base/config/json_file.h"
#include "acus/base/core/text_table.h"
#include "benchmarks/image_errors.h"

namespace acus::benchmarks {
namespace {

using image::GrayImage;

/// One way to make the image; what is not being swept is as Acus does it, or better.
struct Setting {
  int lines = 384;
  int samples = 2048;
  ultrasound::BeamOptions options;
  int warp_iterations = 8;
  double warp_spacing_mm = 2.0;
};

double Correlation(const GrayImage& a, const GrayImage& b) {
  double sa = 0.0, sb = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  const auto count = static_cast<double>(a.pixels.size());
  for (std::size_t n = 0; n < a.pixels.size(); ++n) {
    const double x = a.pixels[n];
    const double y = b.pixels[n];
    sa += x, sb += y, aa += x * x, bb += y * y, ab += x * y;
  }
  return (ab - sa * sb / count) / std::sqrt((aa - sa * sa / count) * (bb - sb * sb / count));
}

class ImageSweeper {
 public:
  ImageSweeper(bool quick, const RunContext& context)
      : quick_(quick), context_(context), scene_(MakeImageScene()) {}

  std::vector<Row> Run() {
    Sweep(
        "lines",
        quick_ ? std::vector<double>{64, 384} : std::vector<double>{64, 128, 256, 384, 512}, 384,
        [](Setting& s, double v) { s.lines = static_cast<int>(v); }, 1024);
    Sweep(
        "samples",
        quick_ ? std::vector<double>{256, 2048} : std::vector<double>{256, 512, 1024, 2048, 4096},
        2048, [](Setting& s, double v) { s.samples = static_cast<int>(v); }, 8192);
    Sweep(
        "elevation_planes", quick_ ? std::vector<double>{1, 3} : std::vector<double>{1, 3, 5, 7, 9},
        1, [](Setting& s, double v) { s.options.elevation_planes = static_cast<int>(v); }, 15);
    Sweep(
        "point_spread_reach",
        quick_ ? std::vector<double>{1.3, 2.6} : std::vector<double>{1.0, 1.3, 1.8, 2.2, 2.6, 3.5},
        2.6, [](Setting& s, double v) { s.options.point_spread_reach = v; }, 5.0);
    Sweep(
        "warp_spacing_mm", quick_ ? std::vector<double>{2, 8} : std::vector<double>{1, 2, 4, 8}, 2,
        [](Setting& s, double v) { s.warp_spacing_mm = v; }, 0.25);
    Sweep(
        "warp_iterations", quick_ ? std::vector<double>{1, 4} : std::vector<double>{1, 2, 3, 4, 6},
        4, [](Setting& s, double v) { s.warp_iterations = static_cast<int>(v); }, 30);
    Effects();
    Models();
    return std::move(rows_);
  }

 private:
  template <typename Renderer>
  TimedImage Rendered(Renderer& renderer, const Setting& setting) const {
    return TimedRender(scene_, renderer, {setting.warp_iterations, setting.warp_spacing_mm},
                       quick_ ? 4 : 12);
  }

  TimedImage Beams(const Setting& setting) const {
    ultrasound::BeamRenderer renderer({.labels = &scene_.labels, .acoustics = &scene_.acoustics},
                                      ImageProbe(setting.lines, setting.samples), setting.options);
    return Rendered(renderer, setting);
  }

  void Sweep(const std::string& knob, const std::vector<double>& values, double usual,
             const std::function<void(Setting&, double)>& turn, double most_expensive) {
    context_.Checkpoint(knob, 0.1 * static_cast<double>(++knobs_));
    Setting setting;
    turn(setting, most_expensive);
    const GrayImage reference = Beams(setting).image;
    for (const double value : values) {
      turn(setting, value);
      const TimedImage image = Beams(setting);
      Row row = TimedRow("beams", knob, RoundedText(value, 2), image);
      row.reference = "the same at " + RoundedText(most_expensive, 2);
      row.is_default = value == usual;
      AddImageErrors(std::move(row), image.image, reference, ImageChange::kError, rows_);
    }
  }

  /// What leaving one effect out changes, and what it saves; and what the more expensive ones cost.
  void Effects() {
    const GrayImage reference = Beams({}).image;
    const auto without = [&](const char* name, auto&& change) {
      Setting setting;
      change(setting.options);
      const TimedImage image = Beams(setting);
      Row row = TimedRow("beams", "effect", name, image);
      row.reference = "all standard effects";
      AddImageErrors(std::move(row), image.image, reference, ImageChange::kEffect, rows_);
    };
    using Options = ultrasound::BeamOptions;
    without("no speckle", [](Options& o) { o.speckle = false; });
    without("no point spread", [](Options& o) { o.point_spread = false; });
    without("no interfaces", [](Options& o) { o.interfaces = false; });
    without("no attenuation", [](Options& o) { o.attenuation = false; });
    without("no angles", [](Options& o) { o.angle = false; });
    without("no shadow", [](Options& o) { o.shadow = false; });
    without("no shadow of the needle", [](Options& o) { o.needle_shadow = false; });
    without("no comet tails", [](Options& o) { o.comet_tail = false; });
    without("with refraction", [](Options& o) { o.refraction = true; });
    without("with time of flight", [](Options& o) { o.time_of_flight = true; });
    without("with multiple reflections", [](Options& o) { o.multiple_reflections = true; });
  }

  void AddLevel(const char* name, const TimedImage& image, const GrayImage& reference, bool paper) {
    Row row = TimedRow(name, "model", name, image);
    row.error = 1.0 - Correlation(image.image, reference);
    row.error_unit = "1 - correlation";
    row.reference = "beams with 9 planes";
    row.is_paper = paper;
    row.is_default = std::string_view(name) == "columns_2010";
    rows_.push_back(std::move(row));
  }

  void Models() {
    Setting most_expensive;
    most_expensive.options.elevation_planes = 9;
    const TimedImage all = Beams(most_expensive);
    const acoustics::Probe probe = ImageProbe(Setting().lines, Setting().samples);
    ultrasound::VidalRenderer vidal(scene_.ct, probe, ultrasound::DefaultVidalOptions());
    AddLevel("vidal_2008", Rendered(vidal, {}), all.image, true);
    ultrasound::AlamillaRenderer alamilla(
        scene_.labels, probe,
        ultrasound::ReadAlamillaOptions(config::FindConfig("acoustics/alamilla_2021.json", ".")));
    AddLevel("alamilla_2021", Rendered(alamilla, {}), all.image, true);
    ultrasound::BModeRenderer columns(
        scene_.ct, probe,
        ultrasound::ReadBModeOptions(config::FindConfig("acoustics/hu_textured.json", ".")));
    AddLevel("columns_2010", Rendered(columns, {}), all.image, true);
    AddLevel("beams", Beams({}), all.image, false);
    Setting five;
    five.options.elevation_planes = 5;
    AddLevel("beams, 5 planes", Beams(five), all.image, false);
  }

  bool quick_;
  const RunContext& context_;
  ImageScene scene_;
  int knobs_ = 0;
  std::vector<Row> rows_;
};

}  // namespace

Sweep ImageSweep() {
  return {"image", "The ultrasound image",
          "A labelled block with a lesion, a vessel and a rib, pressed in by 2 mm around a needle; "
          "512 x 512 pixels, one thread. Errors are root mean squares in dB of the display, of "
          "pixels and of means over 1.5 mm, in which speckle averages out; models are compared by "
          "correlation, since not all of them know decibels. A step is one image.",
          [](bool quick, const RunContext& context) { return ImageSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
