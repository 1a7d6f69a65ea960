#include "benchmarks/image_sweep.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "acus/base/config/json_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "benchmarks/image_scene.h"

namespace acus::benchmarks {
namespace {

using image::GrayImage;

constexpr double kDynamicRangeDb = 60.0;

/// One way to make the image; what is not being swept is as Acus does it, or better.
struct Setting {
  int lines = 384;
  int samples = 2048;
  ultrasound::BeamOptions options;
  int warp_iterations = 8;
  double warp_spacing_mm = 2.0;
};

acoustics::Probe ProbeOf(const Setting& setting) {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.frequency_mhz = 7.5;
  probe.width_mm = 40.0;
  probe.depth_mm = 45.0;
  probe.focus_mm = 28.0;
  probe.scan_lines = setting.lines;
  probe.samples_per_line = setting.samples;
  probe.image_width_px = probe.image_height_px = 512;
  probe.slice_thickness_mm = 3.0;
  probe.pulse_length_mm = 0.5;
  probe.beam_width_mm = 0.8;
  probe.dynamic_range_db = kDynamicRangeDb;
  probe.gain_db = 25.0;
  probe.tgc_db_per_cm = 7.0;
  return probe;
}

struct Image {
  GrayImage image;
  double median_us = 0.0;
  double most_us = 0.0;
};

/// Means over squares of 16 pixels, some 1.5 mm: what is left when speckle is averaged.
std::vector<double> LocalMeans(const GrayImage& image) {
  constexpr int kSide = 16;
  std::vector<double> means;
  for (int r = 0; r + kSide <= image.height; r += kSide) {
    for (int c = 0; c + kSide <= image.width; c += kSide) {
      double sum = 0.0;
      for (int n = 0; n < kSide * kSide; ++n) sum += image.At(c + n % kSide, r + n / kSide);
      means.push_back(sum / (kSide * kSide));
    }
  }
  return means;
}

template <typename Values>
double RmsDifference(const Values& a, const Values& b) {
  double sum = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    const double off = static_cast<double>(a[n]) - static_cast<double>(b[n]);
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

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
  Image Rendered(Renderer& renderer, const Setting& setting) const {
    Image out;
    std::vector<double> times_us;
    for (int n = 0; n < (quick_ ? 4 : 12); ++n) {
      const PressedTissue rest(scene_.needle.tip_in_ct_mm, setting.warp_iterations,
                               setting.warp_spacing_mm);
      const double begin_s = ThreadCpuSeconds();
      renderer.Render(scene_.ct_from_probe, scene_.needle, out.image, 1, &rest);
      if (n > 0) times_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
    }
    out.median_us = math::Median(times_us);
    out.most_us = std::ranges::max(times_us);
    return out;
  }

  Image Beams(const Setting& setting) const {
    ultrasound::BeamRenderer renderer({.labels = &scene_.labels, .acoustics = &scene_.acoustics},
                                      ProbeOf(setting), setting.options);
    return Rendered(renderer, setting);
  }

  Row RowOf(const std::string& knob, const std::string& value, const Image& image) const {
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = "beams";
    row.step_us_median = image.median_us;
    row.step_us_p999 = image.most_us;
    return row;
  }

  /// Two rows: pixel by pixel, and of local means, both in dB of the display.
  /// @param change  What an effect does is no error: it has a unit of its own.
  void Add(Row row, const GrayImage& image, const GrayImage& reference, bool change = false) {
    constexpr double kDbPerGrey = kDynamicRangeDb / 255.0;
    row.error = kDbPerGrey * RmsDifference(image.pixels, reference.pixels);
    row.error_unit = change ? "dB of change, pixels" : "dB, pixels";
    rows_.push_back(row);
    row.error = kDbPerGrey * RmsDifference(LocalMeans(image), LocalMeans(reference));
    row.error_unit = change ? "dB of change, means over 1.5 mm" : "dB, means over 1.5 mm";
    rows_.push_back(std::move(row));
  }

  void Sweep(const std::string& knob, const std::vector<double>& values, double usual,
             const std::function<void(Setting&, double)>& turn, double most_expensive) {
    context_.Checkpoint(knob, 0.1 * static_cast<double>(++knobs_));
    Setting setting;
    turn(setting, most_expensive);
    const GrayImage reference = Beams(setting).image;
    for (const double value : values) {
      turn(setting, value);
      const Image image = Beams(setting);
      Row row = RowOf(knob, RoundedText(value, 2), image);
      row.reference = "the same at " + RoundedText(most_expensive, 2);
      row.is_default = value == usual;
      Add(std::move(row), image.image, reference);
    }
  }

  /// What leaving one effect out changes, and what it saves; and what the more expensive ones cost.
  void Effects() {
    const GrayImage reference = Beams({}).image;
    const auto without = [&](const char* name, auto&& change) {
      Setting setting;
      change(setting.options);
      const Image image = Beams(setting);
      Row row = RowOf("effect", name, image);
      row.reference = "all standard effects";
      Add(std::move(row), image.image, reference, true);
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

  void AddLevel(const char* name, const Image& image, const GrayImage& reference, bool paper) {
    Row row = RowOf("model", name, image);
    row.model = name;
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
    const Image all = Beams(most_expensive);
    const acoustics::Probe probe = ProbeOf({});
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
