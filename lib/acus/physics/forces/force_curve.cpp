#include "acus/physics/forces/force_curve.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::forces {
namespace {

constexpr double kLargestDepthMm = 2000.0;
constexpr double kLargestForceN = 1000.0;
constexpr double kLeastTravelMm = 1.0;
constexpr double kLargestHu = 1e5;
constexpr std::size_t kFewestSamples = 20;

/// One column over time, as read, with the table kept for messages.
struct Signal {
  CsvTable table;
  std::vector<double> time_s;
  std::vector<double> value;
};

Signal ReadSignal(const std::filesystem::path& path, const char* column, double largest,
                  const char* unit, bool has_header) {
  Signal signal{has_header ? CsvTable(path) : CsvTable(path, {"time_s", column}), {}, {}};
  signal.time_s = signal.table.Numbers("time_s");
  signal.value = signal.table.Numbers(column);
  for (std::size_t i = 0; i < signal.value.size(); ++i) {
    ACUS_REQUIRE(std::abs(signal.value[i]) <= largest, signal.table.Where(i), ": ", column, " is ",
                 signal.value[i], "; allowed: -", largest, " to ", largest, " ", unit,
                 ". Is the column in another unit?");
    ACUS_REQUIRE(i == 0 || signal.time_s[i] > signal.time_s[i - 1], signal.table.Where(i),
                 ": time_s is ", signal.time_s[i], " after ", signal.time_s[i - 1],
                 "; time must increase. Sort the rows and remove repeated ones");
  }
  return signal;
}

void RequireEnough(const std::filesystem::path& path, std::size_t count) {
  ACUS_REQUIRE(count >= kFewestSamples, path.string(), ": has ", count,
               " usable samples; at least ", kFewestSamples,
               " are needed. Is the recording cut off?");
}

/// A depth in metres: an insertion of 10 to 300 mm would be one of 0.01 to 0.3 "mm", over which
/// tissue makes no forces that rise and fall for seconds.
void RequireMillimetres(const std::filesystem::path& path, const ForceCurve& curve) {
  const auto [low_mm, high_mm] = std::ranges::minmax(curve.depth_mm);
  const auto [low_n, high_n] = std::ranges::minmax(curve.force_n);
  const double travel_mm = high_mm - low_mm;
  const double duration_s = curve.time_s.back() - curve.time_s.front();
  const bool is_tiny = travel_mm > 0.0 && travel_mm < kLeastTravelMm;
  ACUS_REQUIRE(!is_tiny || duration_s < 2.0 || high_n - low_n < 0.05, path.string(),
               ": the depth changes by ", travel_mm, " in all over ", duration_s,
               " s: it seems to be in metres. It is needed in mm: multiply the column by 1000");
}

ForceCurve ReadFolder(const std::filesystem::path& folder) {
  const Signal depth = ReadSignal(folder / "time_displacement.csv", "depth_mm", kLargestDepthMm,
                                  "mm", /*has_header=*/false);
  const Signal force = ReadSignal(folder / "time_force.csv", "force_n", kLargestForceN, "N",
                                  /*has_header=*/false);
  ForceCurve curve;
  curve.name = folder.filename().string();
  std::size_t next = 1;  // First depth sample that is not before the force sample.
  for (std::size_t i = 0; i < force.time_s.size() && depth.time_s.size() >= 2; ++i) {
    const double time = force.time_s[i];
    if (time < depth.time_s.front() || time > depth.time_s.back()) continue;
    while (depth.time_s[next] < time) ++next;
    const double fraction =
        (time - depth.time_s[next - 1]) / (depth.time_s[next] - depth.time_s[next - 1]);
    curve.time_s.push_back(time);
    curve.depth_mm.push_back(depth.value[next - 1] +
                             fraction * (depth.value[next] - depth.value[next - 1]));
    curve.force_n.push_back(force.value[i]);
  }
  RequireEnough(folder, curve.size());
  RequireMillimetres(folder, curve);
  return curve;
}

void RequireSensible(const CurveParameters& truth, const DrivePlan& plan, double noise_n) {
  const auto require = [](bool fine, const char* key, double value, const char* allowed) {
    ACUS_REQUIRE(fine, "force curve: ", key, " is ", value, "; allowed: ", allowed);
  };
  require(truth.a1_n_per_mm >= 0.0, "a1_n_per_mm", truth.a1_n_per_mm, "0 or more");
  require(truth.a2_n_per_mm2 >= 0.0, "a2_n_per_mm2", truth.a2_n_per_mm2, "0 or more");
  require(truth.contact_depth_mm >= 0.0, "contact_depth_mm", truth.contact_depth_mm, "0 or more");
  require(truth.puncture_depth_mm > 0.0, "puncture_depth_mm", truth.puncture_depth_mm, "> 0");
  require(truth.relaxation_fraction >= 0.0 && truth.relaxation_fraction <= 1.0,
          "relaxation_fraction", truth.relaxation_fraction, "0 to 1");
  require(truth.relaxation_time_s > 0.0, "relaxation_time_s", truth.relaxation_time_s, "> 0");
  require(truth.reversal_mm > 0.0, "reversal_mm", truth.reversal_mm, "> 0");
  require(std::isfinite(truth.plateau_n + truth.plateau_slope_n_per_mm + truth.friction_n_per_mm +
                        truth.offset_n),
          "a force", NAN, "a finite number");
  require(plan.rate_hz >= 10.0 && plan.rate_hz <= 1e5, "rate_hz", plan.rate_hz, "10 to 100000");
  require(plan.rest_s >= 0.0 && plan.rest_s <= 60.0, "rest_s", plan.rest_s, "0 to 60");
  require(plan.hold_s >= 0.0 && plan.hold_s <= 600.0, "hold_s", plan.hold_s, "0 to 600");
  require(plan.advance_mm_per_s >= 0.1, "advance_mm_per_s", plan.advance_mm_per_s, "0.1 or more");
  require(plan.retract_mm_per_s >= 0.1, "retract_mm_per_s", plan.retract_mm_per_s, "0.1 or more");
  require(plan.end_depth_mm > truth.contact_depth_mm + truth.puncture_depth_mm &&
              plan.end_depth_mm <= kLargestDepthMm,
          "end_depth_mm", plan.end_depth_mm, "beyond contact + puncture depth, up to 2000");
  require(noise_n >= 0.0 && noise_n <= 10.0, "noise_n", noise_n, "0 to 10");
}

}  // namespace

ForceCurve ReadForceCurve(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return ReadFolder(path);
  Signal depth = ReadSignal(path, "depth_mm", kLargestDepthMm, "mm", /*has_header=*/true);
  Signal force = ReadSignal(path, "force_n", kLargestForceN, "N", /*has_header=*/true);
  RequireEnough(path, depth.time_s.size());
  ForceCurve curve{path.stem().string(),
                   std::move(depth.time_s),
                   std::move(depth.value),
                   std::move(force.value),
                   {},
                   {}};
  const auto read_if_any = [&](const char* column, std::vector<double>& into) {
    if (!force.table.Has(column)) return;
    into = force.table.Numbers(column);
    for (std::size_t i = 0; i < into.size(); ++i) {
      ACUS_REQUIRE(std::abs(into[i]) <= kLargestHu, force.table.Where(i), ": ", column, " is ",
                   into[i], "; allowed: -100000 to 100000");
    }
  };
  read_if_any("hu", curve.hu);
  read_if_any("hu_gradient_per_mm", curve.hu_gradient_per_mm);
  RequireMillimetres(path, curve);
  return curve;
}

void WriteForceCurve(const std::filesystem::path& path, const ForceCurve& curve) {
  ACUS_ASSERT(curve.depth_mm.size() == curve.size() && curve.force_n.size() == curve.size());
  constexpr std::string_view kColumns[] = {"time_s", "depth_mm", "force_n"};
  std::ostringstream text;
  CsvWriter writer(text, kColumns);
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const double row[] = {curve.time_s[i], curve.depth_mm[i], curve.force_n[i]};
    writer.Row(row);
  }
  WriteTextFile(path, text.view());
}

double CurveParameters::PunctureForceN() const {
  return (a1_n_per_mm + a2_n_per_mm2 * puncture_depth_mm) * puncture_depth_mm;
}

double CurveParameters::AdvanceForceN(double depth_mm) const {
  const double x = depth_mm - contact_depth_mm;
  if (x <= 0.0) return 0.0;
  if (x <= puncture_depth_mm) return (a1_n_per_mm + a2_n_per_mm2 * x) * x;
  return plateau_n + plateau_slope_n_per_mm * (x - puncture_depth_mm);
}

ForceCurve SynthesizeForceCurve(const CurveParameters& truth, const DrivePlan& plan, double noise_n,
                                std::uint64_t seed, const std::string& name) {
  RequireSensible(truth, plan, noise_n);
  const double advance_end_s = plan.rest_s + plan.end_depth_mm / plan.advance_mm_per_s;
  const double hold_end_s = advance_end_s + plan.hold_s;
  const double retract_end_s = hold_end_s + plan.end_depth_mm / plan.retract_mm_per_s;
  const auto count =
      static_cast<std::size_t>(std::floor((retract_end_s + plan.rest_s) * plan.rate_hz)) + 1;
  const auto relaxed_n = [&](double held_s) {
    return truth.AdvanceForceN(plan.end_depth_mm) *
           (1.0 + truth.relaxation_fraction * std::expm1(-held_s / truth.relaxation_time_s));
  };
  RandomStream noise(seed, "force curve " + name);
  ForceCurve curve;
  curve.name = name;
  for (std::size_t i = 0; i < count; ++i) {
    const double time = static_cast<double>(i) / plan.rate_hz;
    double depth = 0.0;
    double force = 0.0;
    if (time <= advance_end_s) {
      depth = std::max(0.0, (time - plan.rest_s) * plan.advance_mm_per_s);
      force = truth.AdvanceForceN(depth);
    } else if (time <= hold_end_s) {
      depth = plan.end_depth_mm;
      force = relaxed_n(time - advance_end_s);
    } else {
      const double back_mm =
          std::min((time - hold_end_s) * plan.retract_mm_per_s, plan.end_depth_mm);
      depth = plan.end_depth_mm - back_mm;
      const double buried_mm = depth - truth.contact_depth_mm;
      const double dragged_n = -truth.friction_n_per_mm * std::max(0.0, buried_mm);
      const double turning = buried_mm > 0.0 ? std::exp(-back_mm / truth.reversal_mm) : 0.0;
      force = dragged_n + (relaxed_n(plan.hold_s) - dragged_n) * turning;
    }
    curve.time_s.push_back(time);
    curve.depth_mm.push_back(depth);
    curve.force_n.push_back(force + truth.offset_n + noise_n * noise.Normal());
  }
  return curve;
}

}  // namespace acus::forces
