#include "benchmarks/views_sweep.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/imaging/fluoroscopy/fluoroscope.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/physics/breathing/motion_map.h"
#include "benchmarks/insertion.h"
#include "benchmarks/trunk_body.h"

namespace acus::benchmarks {
namespace {

constexpr const char* kFluoroscopy = "fluoroscopy";
constexpr const char* kVolume = "volume rendering";
constexpr const char* kGrey = "grey levels of 255";
constexpr double kNoDefault = -1.0;

/// What is not being swept is as Acus does it.
struct ViewSetting {
  std::string layer = "skin";
  bool breathing = true;
  int side_px = 512;
  int supersampling = 1;
  volume_rendering::RaySettings rays;
};

struct TimedImage {
  volume_rendering::ViewImage image;
  std::vector<double> times_us;
};

/// Root mean square of the difference of all channels. Images of fewer pixels count as if each of
/// theirs were a block of `most expensive`.
double GreyLevels(const image::ColourImage& image, const image::ColourImage& most_expensive) {
  const int block = most_expensive.width / image.width;
  double sum = 0.0;
  for (int row = 0; row < most_expensive.height; ++row) {
    for (int column = 0; column < most_expensive.width; ++column) {
      const auto of_dearest = 3 * (static_cast<std::size_t>(row) * most_expensive.width + column);
      const auto of_image = 3 * (static_cast<std::size_t>(row / block) * image.width +
                                 static_cast<std::size_t>(column / block));
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const double off = static_cast<double>(image.rgb[of_image + channel]) -
                           most_expensive.rgb[of_dearest + channel];
        sum += off * off;
      }
    }
  }
  return std::sqrt(sum / (3.0 * most_expensive.width * most_expensive.height));
}

class ViewsSweeper {
 public:
  ViewsSweeper(bool quick, const RunContext& context)
      : quick_(quick),
        context_(context),
        ct_(TrunkBody::Ct(quick ? 96 : 256)),
        field_(TrunkBody::Breath(quick ? 32 : 128)) {}

  std::vector<Row> Run() {
    for (const int detail : {1, 2, 4}) Fluoroscopy("detail", detail, detail, 512);
    for (const int side : Sides()) Fluoroscopy("image_px", side, 2, side);
    RaySteps("skin");
    RaySteps("bone");
    ImageSizes();
    Sweep("supersampling", {1, 2}, 4, 2,
          [](ViewSetting& s, double v) { s.supersampling = static_cast<int>(v); });
    Sweep("warp_tolerance_mm", {0.002, 0.01, 0.05, 0.15}, 0.0, 0.15,
          [](ViewSetting& s, double v) { s.rays.warp.lattice_mm = v; });
    Sweep("pixel_tolerance", {0.005, 0.01, 0.02, 0.05}, 0.0, 0.0,
          [](ViewSetting& s, double v) { s.rays.pixel_tolerance = v; });
    // Every sample asks, to the end: as no scene does unless told.
    Sweep("warp_iterations", {1, 2, 5}, 50, kNoDefault, [](ViewSetting& s, double v) {
      s.rays.warp.lattice_mm = 0.0;
      s.rays.warp.tolerance_mm = 0.0;
      s.rays.warp.max_iterations = static_cast<int>(v);
    });
    Breaths();
    return std::move(rows_);
  }

 private:
  std::vector<int> Sides() const {
    return quick_ ? std::vector{128, 256} : std::vector{256, 512, 1024};
  }
  int Times() const { return quick_ ? 2 : 5; }

  Row RowOf(const std::string& knob, const std::string& value, const char* model,
            const std::vector<double>& times_us) {
    context_.Checkpoint(knob + " " + value,
                        std::min(0.99, 0.02 * static_cast<double>(rows_.size())));
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = model;
    row.step_us_median = math::Median(times_us);
    row.step_us_p999 = math::Quantile(times_us, 1.0);
    return row;
  }

  /// Against the closed form, of rays that pass at least 20 mm of water.
  void Fluoroscopy(const char* knob, int value, int detail, int side_px) {
    const fluoroscopy::CArm c_arm{
        .name = "sweep", .width_px = side_px, .height_px = side_px, .detail = detail};
    const fluoroscopy::CArmPose pose{.lao_rad = 0.35, .cranial_rad = 0.1};
    const double begin_s = ThreadCpuSeconds();
    fluoroscopy::Fluoroscope fluoroscope(*ct_, c_arm, pose);
    const double preparation_s = ThreadCpuSeconds() - begin_s;
    image::GrayImage image;
    std::vector<double> times_us;
    for (int n = 0; n <= Times(); ++n) {
      const double before_s = ThreadCpuSeconds();
      fluoroscope.Render(std::nullopt, image);
      if (n > 0) times_us.push_back(1e6 * (ThreadCpuSeconds() - before_s));
    }
    Row row = RowOf(std::string(kFluoroscopy) + ": " + knob, std::to_string(value), kFluoroscopy,
                    times_us);
    row.preparation_s = preparation_s;
    row.memory_mb = 1e-6 * static_cast<double>(fluoroscope.volume_bytes());
    row.is_default = detail == 2 && side_px == 512;
    row.reference = "closed form";
    row.error = RaySumPercent(fluoroscope, side_px);
    row.error_unit = "% of the ray's sum";
    rows_.push_back(std::move(row));
  }

  static double RaySumPercent(const fluoroscopy::Fluoroscope& fluoroscope, int side_px) {
    const double water_per_mm = fluoroscope.c_arm().water_per_mm;
    const Eigen::Vector3d source = fluoroscope.geometry().source_in_ct_mm();
    double sum = 0.0;
    int count = 0;
    for (int row = 0; row < side_px; row += 2) {
      for (int column = 0; column < side_px; column += 2) {
        const Eigen::Vector3d pixel = fluoroscope.geometry().PixelInCtMm(column, row);
        const double exact = water_per_mm * TrunkBody::WaterMm(source, pixel);
        if (exact < 20.0 * water_per_mm) continue;
        const double off = fluoroscope.Sum(column, row) / exact - 1.0;
        sum += off * off;
        ++count;
      }
    }
    return 100.0 * std::sqrt(sum / count);
  }

  TimedImage Rendered(const ViewSetting& setting, int times) const {
    volume_rendering::PatientInView patient;
    patient.ct = ct_;
    patient.layers = {{setting.layer, 1.0}};
    patient.field = setting.breathing ? &field_ : nullptr;
    volume_rendering::ViewSettings settings;
    settings.rays = setting.rays;
    settings.supersampling = setting.supersampling;
    volume_rendering::PatientView view(patient, settings);
    const volume_rendering::ImageSize size{setting.side_px, setting.side_px};
    const volume_rendering::Camera camera =
        LookAt(ViewFrom("oblique", view.box_in_ct_mm(), size), size);
    breathing::MotionWeights weights;
    weights.Add(0, 0.9);
    const breathing::MotionMap motion(field_, weights);
    TimedImage out;
    for (int n = 0; n < times; ++n) {
      const double before_s = ThreadCpuSeconds();
      view.Render(camera, {.motion = setting.breathing ? &motion : nullptr}, out.image, 1);
      out.times_us.push_back(1e6 * (ThreadCpuSeconds() - before_s));
    }
    return out;
  }

  ViewSetting Usual() const {
    ViewSetting setting;
    setting.side_px = quick_ ? 192 : 512;
    return setting;
  }

  void Add(const std::string& knob, const std::string& value, const TimedImage& of,
           const image::ColourImage& most_expensive, const std::string& reference,
           bool is_default) {
    Row row = RowOf(std::string(kVolume) + ": " + knob, value, kVolume, of.times_us);
    row.error = GreyLevels(of.image.colour, most_expensive);
    row.error_unit = kGrey;
    row.reference = reference;
    row.is_default = is_default;
    rows_.push_back(std::move(row));
  }

  void Sweep(const std::string& knob, const std::vector<double>& values, double most_expensive,
             double usual, const std::function<void(ViewSetting&, double)>& turn,
             const std::string& layer = "skin") {
    ViewSetting setting = Usual();
    setting.layer = layer;
    turn(setting, most_expensive);
    const TimedImage reference = Rendered(setting, Times());
    const std::string name = RoundedText(most_expensive, 3);
    for (const double value : values) {
      turn(setting, value);
      Add(knob, RoundedText(value, 3), Rendered(setting, Times()), reference.image.colour,
          "the same at " + name, value == usual);
    }
    Add(knob, name, reference, reference.image.colour, "the same at " + name,
        most_expensive == usual);
  }

  /// At rest, so that the step alone matters.
  void RaySteps(const std::string& layer) {
    Sweep(
        "ray step_mm, " + layer,
        quick_ ? std::vector<double>{4.0, 1.0} : std::vector<double>{4.0, 2.0, 1.0, 0.5}, 0.125,
        1.0,
        [](ViewSetting& s, double v) {
          s.breathing = false;
          s.rays.step_mm = v;
        },
        layer);
  }

  void ImageSizes() {
    ViewSetting setting = Usual();
    setting.side_px = 2 * Sides().back();
    const TimedImage most_expensive = Rendered(setting, 1);
    for (const int side : Sides()) {
      setting.side_px = side;
      Add("image_px", std::to_string(side), Rendered(setting, Times()), most_expensive.image.colour,
          "the same at " + std::to_string(2 * Sides().back()), false);
    }
  }

  /// What breath changes and costs.
  void Breaths() {
    for (const char* layer : {"skin", "bone"}) {
      ViewSetting setting = Usual();
      setting.layer = layer;
      const TimedImage breathing = Rendered(setting, Times());
      setting.breathing = false;
      const TimedImage still = Rendered(setting, Times());
      for (const bool moves : {false, true}) {
        Add("breath, " + std::string(layer), moves ? "breathing" : "at rest",
            moves ? breathing : still, breathing.image.colour, "breathing", moves);
        rows_.back().error_unit = "grey levels of change";
      }
    }
  }

  bool quick_;
  const RunContext& context_;
  std::shared_ptr<volume::CtVolume> ct_;
  breathing::MotionField field_;
  std::vector<Row> rows_;
};

}  // namespace

Sweep ViewsSweep() {
  return {"views", "Fluoroscopy and volume rendering",
          "A trunk of ellipsoids in a CT of 256 x 256 x 256 voxels, one thread. Fluoroscopy: root "
          "mean square of the relative error of rays against their sums in closed form. Volume "
          "rendering: root mean square over all channels against the dearest setting. A step is "
          "one image.",
          [](bool quick, const RunContext& context) { return ViewsSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
