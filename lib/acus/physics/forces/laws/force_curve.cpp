#include "acus/physics/forces/laws/force_curve.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <sstream>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::forces {
namespace {

constexpr double kLargestDepthMm = 2000.0;
constexpr double kLargestForceN = 1000.0;
constexpr double kLargestOfNeedleN = 100.0;
constexpr double kLeastTravelMm = 1.0;
constexpr double kLargestHu = 1e5;
constexpr std::size_t kFewestSamples = 20;

/// One or more columns over time, as read, with the table kept for messages.
struct Signals {
  CsvTable table;
  std::vector<double> time_s;
  std::vector<std::vector<double>> values;
  std::string how_read;
};

void Note(std::string& notes, const std::string& note) {
  if (!note.empty()) notes += (notes.empty() ? "" : "; ") + note;
}

/// Samples of one stamp become one, their mean.
void MergeEqualStamps(Signals& signals) {
  std::vector<double>& time_s = signals.time_s;
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < time_s.size(); ++kept) {
    std::size_t end = begin + 1;
    while (end < time_s.size() && time_s[end] == time_s[begin]) ++end;
    ACUS_REQUIRE(end == time_s.size() || time_s[end] > time_s[begin], signals.table.Where(end),
                 ": time_s is ", time_s[end], " after ", time_s[begin],
                 "; time must not go back. Sort the rows, or use the part before or after it");
    for (auto& values : signals.values) {
      double sum = 0.0;
      for (std::size_t i = begin; i < end; ++i) sum += values[i];
      values[kept] = end == begin + 1 ? values[begin] : sum / static_cast<double>(end - begin);
    }
    time_s[kept] = time_s[begin];
    begin = end;
  }
  if (kept < time_s.size()) {
    Note(signals.how_read, Message(time_s.size() - kept,
                                   " rows had the time stamp of the row before and were averaged "
                                   "with it"));
  }
  time_s.resize(kept);
  for (auto& values : signals.values) values.resize(kept);
}

struct WantedColumn {
  const char* name;
  double largest;
  const char* unit;
};

constexpr WantedColumn kDepthColumn = {"depth_mm", kLargestDepthMm, "mm"};
constexpr WantedColumn kForceColumn = {"force_n", kLargestForceN, "N"};

Signals ReadSignals(CsvTable table, std::span<const WantedColumn> wanted) {
  Signals signals{std::move(table), {}, {}, {}};
  std::vector<std::string_view> names = {"time_s"};
  for (const WantedColumn& column : wanted) names.emplace_back(column.name);
  Note(signals.how_read, signals.table.how_read());
  for (const std::string_view name : names) Note(signals.how_read, signals.table.Taken(name));
  const std::size_t dropped = signals.table.DropRowsWithout(names);
  if (dropped > 0)
    Note(signals.how_read, Message(Counted(dropped, "row# with empty cells"), " omitted"));
  signals.time_s = signals.table.Numbers("time_s");
  for (const WantedColumn& column : wanted) {
    const auto& values = signals.values.emplace_back(signals.table.Numbers(column.name));
    for (std::size_t i = 0; i < values.size(); ++i) {
      ACUS_REQUIRE(std::abs(values[i]) <= column.largest, signals.table.Where(i), ": ", column.name,
                   " is ", values[i], "; allowed: -", column.largest, " to ", column.largest, " ",
                   column.unit, ". Is the column in another unit?");
    }
  }
  return signals;
}

/// The columns of a machine's export, by the mapping or by their usual names.
void FindColumns(CsvTable& table, const ForceColumns& columns) {
  static constexpr std::string_view kTime[] = {"t", "elapsed_time", "timestamp", "test_time",
                                               "zeit"};
  static constexpr std::string_view kDepth[] = {"displacement", "extension", "insertion_depth",
                                                "crosshead",    "stroke",    "weg"};
  static constexpr std::string_view kForce[] = {"load", "axial_force", "kraft"};
  const auto find = [&table](const ForceColumn& column, const char* name, auto& words) {
    if (column.column.empty()) {
      table.Accept(name, words);
    } else {
      table.Take(name, column.column, column.unit);
    }
  };
  find(columns.time, "time_s", kTime);
  find(columns.depth, "depth_mm", kDepth);
  find(columns.force, "force_n", kForce);
}

void RequireEnough(const std::filesystem::path& path, std::size_t count) {
  ACUS_REQUIRE(count >= kFewestSamples, path.string(), ": has ", count,
               " usable samples; at least ", kFewestSamples, " are needed");
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

/// No needle takes 100 N: it would bend, or the force is in mN.
void RequireForceOfNeedle(const std::filesystem::path& path, const ForceCurve& curve,
                          bool as_it_is) {
  double largest_n = 0.0;
  for (const double force_n : curve.force_n) largest_n = std::max(largest_n, std::abs(force_n));
  ACUS_REQUIRE(as_it_is || largest_n <= kLargestOfNeedleN, path.string(), ": the force reaches ",
               largest_n, " N; needles are inserted with less than ", kLargestOfNeedleN,
               " N. Is it in mN or gram-force? Name the column with its unit (force_mN), or read "
               "it by a mapping (--columns); --as-it-is takes it as N");
}

/// No insertion takes a quarter of an hour at a sample each second: the time is in ms.
void RequireSeconds(const std::filesystem::path& path, const ForceCurve& curve, bool as_it_is) {
  constexpr double kLongestS = 900.0;
  constexpr double kLongestStepS = 0.9;
  const double duration_s = curve.time_s.back() - curve.time_s.front();
  const double step_s = duration_s / static_cast<double>(curve.size() - 1);
  ACUS_REQUIRE(as_it_is || duration_s < kLongestS || step_s < kLongestStepS, path.string(),
               ": the recording takes ", duration_s, " s, with a sample every ", step_s,
               " s: its time is probably in ms. Name the column with its unit (time_ms), or read "
               "it by a mapping (--columns); --as-it-is takes it as s");
}

ForceCurve ReadFolder(const std::filesystem::path& folder) {
  const auto read = [&](const char* file, const WantedColumn& column) {
    Signals signals =
        ReadSignals(CsvTable(folder / file, {"time_s", column.name}), std::span(&column, 1));
    MergeEqualStamps(signals);
    return signals;
  };
  const Signals depth = read("time_displacement.csv", kDepthColumn);
  const Signals force = read("time_force.csv", kForceColumn);
  ForceCurve curve;
  curve.name = folder.filename().string();
  if (!depth.how_read.empty()) curve.how_read = "time_displacement.csv: " + depth.how_read;
  if (!force.how_read.empty()) Note(curve.how_read, "time_force.csv: " + force.how_read);
  std::size_t next = 1;  // First depth sample that is not before the force sample.
  for (std::size_t i = 0; i < force.time_s.size() && depth.time_s.size() >= 2; ++i) {
    const double time = force.time_s[i];
    if (time < depth.time_s.front() || time > depth.time_s.back()) continue;
    while (depth.time_s[next] < time) ++next;
    const double fraction =
        (time - depth.time_s[next - 1]) / (depth.time_s[next] - depth.time_s[next - 1]);
    curve.time_s.push_back(time);
    curve.depth_mm.push_back(depth.values[0][next - 1] +
                             fraction * (depth.values[0][next] - depth.values[0][next - 1]));
    curve.force_n.push_back(force.values[0][i]);
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

ForceCurve ReadForceCurve(const std::filesystem::path& path, const ForceColumns& columns,
                          bool as_it_is) {
  if (std::filesystem::is_directory(path)) {
    ForceCurve curve = ReadFolder(path);
    RequireForceOfNeedle(path, curve, as_it_is);
    RequireSeconds(path, curve, as_it_is);
    return curve;
  }
  CsvTable table(path);
  FindColumns(table, columns);
  std::vector<WantedColumn> wanted = {kDepthColumn, kForceColumn};
  for (const char* column : {"hu", "hu_gradient_per_mm"}) {
    if (table.Has(column)) wanted.push_back({column, kLargestHu, "HU"});
  }
  Signals signals = ReadSignals(std::move(table), wanted);
  MergeEqualStamps(signals);
  RequireEnough(path, signals.time_s.size());
  ForceCurve curve;
  curve.name = path.stem().string();
  curve.time_s = std::move(signals.time_s);
  curve.depth_mm = std::move(signals.values[0]);
  curve.force_n = std::move(signals.values[1]);
  curve.how_read = std::move(signals.how_read);
  for (std::size_t i = 2; i < wanted.size(); ++i) {
    const bool is_hu = std::string_view(wanted[i].name) == "hu";
    (is_hu ? curve.hu : curve.hu_gradient_per_mm) = std::move(signals.values[i]);
  }
  for (double& depth_mm : curve.depth_mm) depth_mm *= columns.depth.sign;
  for (double& force_n : curve.force_n) force_n *= columns.force.sign;
  RequireMillimetres(path, curve);
  RequireForceOfNeedle(path, curve, as_it_is);
  RequireSeconds(path, curve, as_it_is);
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
