#include "benchmarks/breathing_sweep.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "benchmarks/breathing_body.h"
#include "benchmarks/insertion.h"

namespace acus::benchmarks {
namespace {

using breathing::Breath;
using breathing::MotionKind;
using breathing::MotionMap;
using breathing::MotionModel;
using Eigen::Vector3d;

constexpr MotionKind kKinds[] = {MotionKind::kSinusoid, MotionKind::kFullCycle,
                                 MotionKind::kHalfCycle, MotionKind::kSurrogate};
constexpr double kOffWallMm = 15.0;
constexpr int kPhases = 10;
constexpr int kNodes = 128;

constexpr const char* kAway = "mm, more than 15 mm from the sliding wall";
constexpr const char* kAtWall = "mm, mean within 15 mm of the sliding wall";
constexpr const char* kDeeper = "mm, breath 1.4 times as deep";
constexpr const char* kExact = "exact motion";

/// 95 of 100 errors are below this.
double P95(const std::vector<double>& errors_mm) {
  return math::Quantile(errors_mm, 0.95);
}

struct Timing {
  double median_us = 0.0;
  double p999_us = 0.0;
};

/// CPU time of one of `count` actions, means over ten: reading the clock takes 0.2 us.
template <typename Action>
Timing TimeOf(int count, const Action& action) {
  constexpr int kAtOnce = 10;
  std::vector<double> times_us;
  for (int n = 0; n < count; n += kAtOnce) {
    const double begin_s = ThreadCpuSeconds();
    for (int m = n; m < n + kAtOnce; ++m) action(m);
    times_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s) / kAtOnce);
  }
  return {math::Median(times_us), math::Quantile(times_us, 0.999)};
}

/// What breathing adds to a step of the hand: the tool at rest, and where the tissue along 25 nodes
/// of the needle is.
Timing HapticStep(const MotionModel& model) {
  breathing::ToolTrack track;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << 60.0, -40.0, 10.0;
  volatile double sink = 0.0;
  return TimeOf(4000, [&](int n) {
    const MotionMap map(model.field(), model.WeightsAt(BreathingBody::BreathAt(2.5e-4 * n)));
    const breathing::ToolAtRest tool = AtRest(map, pose, Vector3d::UnitZ(), track);
    double sum = 0.0;
    for (int node = 0; node < 25; ++node) {
      const Vector3d place = tool.ct_from_tool.translation() - Vector3d(0.0, 0.0, 4.0 * node);
      sum += map.DisplacementMm(place).z();
    }
    sink = sink + sum;
  });
}

/// |u_model - u| at these moments of a breath, mm.
std::vector<double> ModelErrors(const MotionModel& model, const std::vector<Vector3d>& places,
                                const std::vector<double>& cycles, double depth = 1.0) {
  std::vector<double> errors_mm;
  for (const double cycle : cycles) {
    const Breath breath = BreathingBody::BreathAt(cycle, depth);
    const MotionMap map(model.field(), model.WeightsAt(breath));
    for (const Vector3d& place : places) {
      errors_mm.push_back(
          (map.DisplacementMm(place) - BreathingBody::DisplacementMm(breath, place)).norm());
    }
  }
  return errors_mm;
}

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<double> WholeBreath() {
  std::vector<double> cycles;
  for (int n = 0; n < 40; ++n) cycles.push_back((n + 0.5) / 40.0);
  return cycles;
}

class BreathingSweeper {
 public:
  BreathingSweeper(bool quick, const RunContext& context)
      : quick_(quick),
        context_(context),
        places_(BreathingBody::Places(quick ? 300 : 2000, kOffWallMm)),
        at_wall_(BreathingBody::PlacesAtWall(quick ? 300 : 2000, kOffWallMm)) {}

  std::vector<Row> Run() {
    context_.Checkpoint("field_nodes", 0.0);
    FieldNodes();
    context_.Checkpoint("key_frames", 0.5);
    KeyFrames();
    context_.Checkpoint("model", 0.7);
    Models();
    context_.Checkpoint("iterations", 0.85);
    const MotionModel model =
        breathing::BuildModel(MotionKind::kFullCycle, BreathingBody::Phases(Nodes(), kPhases));
    HapticIterations(model);
    PixelIterations(model, true);
    PixelIterations(model, false);
    KnotSpacing(model);
    return std::move(rows_);
  }

 private:
  int Nodes() const { return quick_ ? 48 : kNodes; }

  Row RowOf(const char* knob, std::string value, MotionKind kind, const Timing& timing) const {
    Row row;
    row.knob = knob;
    row.value = std::move(value);
    row.model = std::string(NameOf(kind));
    row.step_us_median = timing.median_us;
    row.step_us_p999 = timing.p999_us;
    return row;
  }

  void Add(Row row, double error, const char* unit, const char* reference) {
    row.error = error;
    row.error_unit = unit;
    row.reference = reference;
    if (!std::isfinite(error)) row.unusable = "the error is not finite";
    rows_.push_back(std::move(row));
  }

  /// Four key frames, at their own moments: what is wrong then is the field's resolution, and 16
  /// bits.
  void FieldNodes() {
    const std::vector<int> all = quick_ ? std::vector{16, 32, 48} : std::vector{32, 64, 128, 256};
    for (const int nodes : all) {
      const double begin_s = ThreadCpuSeconds();
      breathing::MotionField field(BreathingBody::Nodes(nodes), 3);
      for (int n = 0; n < 3; ++n) {
        context_.Checkpoint("field_nodes", 0.1 * n);
        field.SetComponent(
            n, BreathingBody::Field(field.nodes(), BreathingBody::BreathAt(0.25 * (n + 1))));
      }
      const double bytes = static_cast<double>(field.bytes());
      const MotionModel model = MotionModel::FullCycle(
          std::move(field),
          {{0.0, breathing::KeyFrame::kReference}, {0.25, 0}, {0.5, 1}, {0.75, 2}});
      const double ready_s = ThreadCpuSeconds();
      Row row = RowOf("field_nodes", std::to_string(nodes), model.kind(), HapticStep(model));
      row.preparation_s = ready_s - begin_s;
      row.memory_mb = 1e-6 * bytes;
      row.is_default = nodes == Nodes();
      row.is_paper = nodes == 64 || nodes == 256;
      const std::vector<double> frames{0.25, 0.5, 0.75};
      Add(row, P95(ModelErrors(model, places_, frames)), kAway, kExact);
      Add(row, Mean(ModelErrors(model, at_wall_, frames)), kAtWall, kExact);
    }
  }

  void KeyFrames() {
    const std::vector<int> all =
        quick_ ? std::vector{4, 10} : std::vector{4, 6, 8, kPhases, 14, 20};
    for (const int frames : all) {
      const double begin_s = ThreadCpuSeconds();
      const MotionModel model =
          breathing::BuildModel(MotionKind::kFullCycle, BreathingBody::Phases(Nodes(), frames));
      Row row = RowOf("key_frames", std::to_string(frames), model.kind(), {});
      row.preparation_s = ThreadCpuSeconds() - begin_s;
      const Timing timing = HapticStep(model);
      row.step_us_median = timing.median_us;
      row.step_us_p999 = timing.p999_us;
      row.memory_mb = 1e-6 * static_cast<double>(model.field().bytes());
      row.is_default = frames == kPhases;
      row.is_paper = frames == 14 || frames == 6 || frames == 4;
      Add(row, P95(ModelErrors(model, places_, WholeBreath())), kAway, kExact);
    }
  }

  void Models() {
    const breathing::MotionPhases phases = BreathingBody::Phases(Nodes(), kPhases);
    for (const MotionKind kind : kKinds) {
      const double begin_s = ThreadCpuSeconds();
      const MotionModel model = breathing::BuildModel(kind, phases);
      Row row = RowOf("model", std::string(NameOf(kind)), kind, {});
      row.preparation_s = ThreadCpuSeconds() - begin_s;
      const Timing timing = HapticStep(model);
      row.step_us_median = timing.median_us;
      row.step_us_p999 = timing.p999_us;
      row.memory_mb = 1e-6 * static_cast<double>(model.field().bytes());
      row.is_default = kind == MotionKind::kSurrogate;
      row.is_paper = true;
      Add(row, P95(ModelErrors(model, places_, WholeBreath())), kAway, kExact);
      Add(row, P95(ModelErrors(model, places_, WholeBreath(), 1.4)), kDeeper, kExact);
    }
  }

  /// At a kilohertz, hand still, two breaths: each step from where the one before left off.
  void HapticIterations(const MotionModel& model) {
    for (const int iterations : quick_ ? std::vector{1, 4} : std::vector{1, 2, 3, 4, 8}) {
      std::vector<double> errors_mm;
      std::vector<double> times_us;
      for (std::size_t p = 0; p < places_.size(); p += places_.size() / 20) {
        const Vector3d world = places_[p];
        Vector3d rest = world;
        const auto map_at = [&](int n) {
          return MotionMap(model.field(), model.WeightsAt(BreathingBody::BreathAt(2.5e-4 * n)));
        };
        const auto step = [&](int n) {
          rest = map_at(n)
                     .RestOf(world, rest, {.max_iterations = iterations, .tolerance_mm = 0.0})
                     .rest_mm;
        };
        times_us.push_back(TimeOf(4000, step).median_us);
        for (int n = 4000; n < 8000; ++n) {
          step(n);
          if (n % 20 != 0) continue;
          errors_mm.push_back((rest - MostExpensive(map_at(n), world)).norm());
        }
      }
      Row row = RowOf("haptic_iterations", std::to_string(iterations), model.kind(),
                      {math::Median(times_us), math::Quantile(times_us, 1.0)});
      row.is_default = row.is_paper = iterations == 1;
      Add(row, P95(errors_mm), "mm, of the hand at 1 kHz", "fifty iterations");
    }
  }

  static Vector3d MostExpensive(const MotionMap& map, const Vector3d& world) {
    return map.RestOf(world, world, {.max_iterations = 50, .tolerance_mm = 0.0}).rest_mm;
  }

  /// An image of 150 x 150 mm, at end expiration: places at rest on its knots, row by row from the
  /// neighbour.
  static std::vector<Vector3d> Image(const MotionMap& map, double spacing_mm, int iterations,
                                     bool from_neighbour = true) {
    std::vector<Vector3d> rest;
    for (double y = 0.0; y <= 150.0; y += spacing_mm) {
      Vector3d moved_mm = Vector3d::Zero();
      for (double x = 0.0; x <= 150.0; x += spacing_mm) {
        const Vector3d place = ImageAt(x, y);
        rest.push_back(
            map.RestOf(place, place + moved_mm, {.max_iterations = iterations, .tolerance_mm = 0.0})
                .rest_mm);
        if (from_neighbour) moved_mm = rest.back() - place;
      }
    }
    return rest;
  }
  static Vector3d ImageAt(double x_mm, double y_mm) {
    return {-60.0 + 0.8 * x_mm, -70.0 + 0.6 * x_mm, 80.0 - y_mm};
  }

  /// @param from_neighbour  False: as if no pixel knew of another, as in the paper's slices.
  void PixelIterations(const MotionModel& model, bool from_neighbour) {
    const MotionMap map(model.field(), model.WeightsAt(BreathingBody::BreathAt(0.47)));
    constexpr double kPixelMm = 1.0;
    const std::vector<Vector3d> most_expensive = Image(map, kPixelMm, 50);
    const std::vector<int> all = quick_ ? std::vector{0, 1, 5} : std::vector{0, 1, 2, 3, 5, 10};
    for (const int iterations : all) {
      std::vector<Vector3d> rest;
      const Timing timing = TimeOf(
          quick_ ? 10 : 50, [&](int) { rest = Image(map, kPixelMm, iterations, from_neighbour); });
      std::vector<double> errors_mm;
      for (std::size_t n = 0; n < rest.size(); ++n) {
        errors_mm.push_back((rest[n] - most_expensive[n]).norm());
      }
      Row row = RowOf(from_neighbour ? "pixel_iterations" : "pixel_iterations, from nothing",
                      std::to_string(iterations), model.kind(), timing);
      row.is_default = from_neighbour && iterations == 5;
      row.is_paper = iterations == 5;
      Add(row, P95(errors_mm), "mm, of an image", "fifty iterations");
    }
  }

  /// Images ask at knots, and are linear between: against asking at every place.
  void KnotSpacing(const MotionModel& model) {
    const MotionMap map(model.field(), model.WeightsAt(BreathingBody::BreathAt(0.47)));
    const auto moved = [&](double x, double y) -> Vector3d {
      const Vector3d place = ImageAt(x, y);
      return MostExpensive(map, place) - place;
    };
    for (const double spacing_mm : quick_ ? std::vector{5.0} : std::vector{1.0, 2.5, 5.0, 10.0}) {
      std::vector<double> errors_mm;
      for (double y = 0.0; y + spacing_mm <= 150.0; y += spacing_mm) {
        for (double x = 0.0; x + spacing_mm <= 150.0; x += spacing_mm) {
          const Vector3d middle =
              0.25 * (moved(x, y) + moved(x + spacing_mm, y) + moved(x, y + spacing_mm) +
                      moved(x + spacing_mm, y + spacing_mm));
          errors_mm.push_back((middle - moved(x + 0.5 * spacing_mm, y + 0.5 * spacing_mm)).norm());
        }
      }
      const Timing timing = TimeOf(quick_ ? 10 : 50, [&](int) { Image(map, spacing_mm, 5); });
      Row row = RowOf("knot_spacing_mm", RoundedText(spacing_mm, 3), model.kind(), timing);
      row.is_default = spacing_mm == 5.0;
      Add(row, P95(errors_mm), "mm, of an image", "every place of its own");
    }
  }

  bool quick_;
  const RunContext& context_;
  std::vector<Vector3d> places_;
  std::vector<Vector3d> at_wall_;
  std::vector<Row> rows_;
};

}  // namespace

Sweep BreathingSweep() {
  return {
      "breathing", "Breathing",
      "A body whose motion is known in closed form: 20 mm at the diaphragm, sliding along a "
      "wall, with hysteresis. Errors are those that 95 of 100 places stay below. A step is what "
      "breathing adds to one of the hand: the tool taken to rest, and displacements at 25 nodes "
      "of the needle; for pixel_iterations and knot_spacing_mm, the knots of one image.",
      [](bool quick, const RunContext& context) { return BreathingSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
