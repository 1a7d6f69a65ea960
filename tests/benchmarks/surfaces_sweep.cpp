#include "benchmarks/surfaces_sweep.h"

#include <algorithm>
#include <string>

#include "acus/base/config/json_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "benchmarks/bumpy_balls.h"

namespace acus::benchmarks {
namespace {

constexpr double kUsualSpacingMm = 0.5;

class SurfacesSweeper {
 public:
  SurfacesSweeper(bool quick, const RunContext& context)
      : quick_(quick),
        context_(context),
        options_(ultrasound::ReadAlamillaOptions(
            config::FindConfig("acoustics/alamilla_2021.json", "."))) {}

  std::vector<Row> Run() {
    const int levels = quick_ ? 5 : 8;
    auto surfaces = BumpyBalls::Surfaces(levels);
    for (const double spacing_mm :
         quick_ ? std::vector{2.0, 1.0} : std::vector{2.0, 1.0, kUsualSpacingMm, 0.25}) {
      const std::string value = "voxels of " + RoundedText(spacing_mm, 3) + " mm";
      context_.Checkpoint(value, 0.1 * static_cast<double>(rows_.size()));
      Row row = Named("labels from", value, "label map");
      const volume::LabelMap labels = BumpyBalls::Voxels(surfaces, spacing_mm, row.preparation_s);
      row.memory_mb = 1e-6 * static_cast<double>(labels.voxels.size());
      row.is_default = spacing_mm == kUsualSpacingMm;
      Add(row, labels, nullptr,
          [&](const slicing::RestMap* rest) { return ErrorsOfVoxels(labels, rest); });
    }
    // The label map that remains is for the directions of fibres only.
    double fill_s = 0.0;
    const volume::LabelMap labels = BumpyBalls::Voxels(surfaces, 1.0, fill_s);
    const double begin_s = ThreadCpuSeconds();
    const tracing::SurfaceTracer tracer(std::move(surfaces), 1);
    const double build_s = ThreadCpuSeconds() - begin_s;
    for (const int l : quick_ ? std::vector{4} : std::vector{5, 6, 7}) {
      const tracing::SurfaceTracer coarse(BumpyBalls::Surfaces(l), 1);
      AddTriangles(coarse, kNotMeasured, labels);
    }
    AddTriangles(tracer, build_s, labels);
    return std::move(rows_);
  }

 private:
  static Row Named(const std::string& knob, const std::string& value, const std::string& model) {
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = model;
    row.reference = "closed form";
    return row;
  }

  void AddTriangles(const tracing::SurfaceTracer& tracer, double build_s,
                    const volume::LabelMap& labels) {
    const std::string value = std::to_string(tracer.num_triangles()) + " triangles";
    context_.Checkpoint(value, 0.1 * static_cast<double>(rows_.size()));
    Row row = Named("labels from", value, "triangles");
    row.preparation_s = build_s;
    row.memory_mb = 1e-6 * static_cast<double>(tracer.memory_bytes());
    Add(row, labels, &tracer,
        [&](const slicing::RestMap* rest) { return ErrorsOfTriangles(tracer, rest); });
  }

  /// Error and time at rest, and of tissue that a needle takes along.
  template <typename Errors>
  void Add(Row row, const volume::LabelMap& labels, const tracing::SurfaceTracer* triangles,
           const Errors& errors_with) {
    ultrasound::AlamillaRenderer renderer(labels, BumpyBalls::Probe(), options_, triangles);
    const TakenAlong moved;
    for (const slicing::RestMap* rest : {static_cast<const slicing::RestMap*>(nullptr),
                                         static_cast<const slicing::RestMap*>(&moved)}) {
      if (rest != nullptr) row.knob += ", deformed";
      image::GrayImage image;
      std::vector<double> times_us;
      for (int n = 0; n < (quick_ ? 4 : 16); ++n) {
        const double begin_s = ThreadCpuSeconds();
        renderer.Render(BumpyBalls::CtFromProbe(), std::nullopt, image, 1, rest);
        if (n > 0) times_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
      }
      row.step_us_median = math::Median(times_us);
      row.step_us_p999 = std::ranges::max(times_us);
      const LabelErrors errors = errors_with(rest);
      const auto add = [&](double error, const char* unit) {
        row.error = error;
        row.error_unit = unit;
        rows_.push_back(row);
      };
      add(errors.rms_mm, "mm");
      add(errors.most_mm, "mm, largest");
      add(errors.wrong_percent, "% of pixels");
      add(errors.lost_percent, "% of lines");
    }
  }

  bool quick_;
  const RunContext& context_;
  ultrasound::AlamillaOptions options_;
  std::vector<Row> rows_;
};

}  // namespace

Sweep SurfacesSweep() {
  return {
      "surfaces", "Scenes of surfaces",
      "Six bumpy layers around each other, the image of a linear probe of 512 x 512 pixels, by "
      "the model alamilla_2021, one thread. Errors against the closed form of the layers: "
      "depth of boundaries (root mean square and largest, on lines that meet the same "
      "tissues), pixels in the wrong tissue, and lines that meet other tissues. A step is one "
      "image.",
      [](bool quick, const RunContext& context) { return SurfacesSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
