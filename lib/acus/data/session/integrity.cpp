#include "acus/data/session/integrity.h"

#include <algorithm>

#include "acus/base/core/counted.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/data/session/pose_csv.h"

namespace acus::session {
namespace {

constexpr double kSecondsPerNs = 1e-9;
/// Ten standard deviations of white noise are some six median steps of it.
constexpr double kMotionOverNoise = 20.0;
/// No tracker sees farther, m.
constexpr double kFarthestOfMetres = 10.0;

void RequirePositive(double value, const char* name) {
  ACUS_REQUIRE(value > 0.0, name, " is ", value, "; it must be positive");  // Not for NaN either.
}

void Check(const IntegrityLimits& limits) {
  RequirePositive(limits.gap_s, "gap_s");
  RequirePositive(limits.jump_mm, "jump_mm");
  RequirePositive(limits.speed_mm_per_s, "speed_mm_per_s");
  RequirePositive(limits.jitter_mm, "jitter_mm");
  ACUS_REQUIRE(limits.gap_intervals >= 1.0, "gap_intervals is ", limits.gap_intervals,
               "; it must be at least 1");
}

void FindIntervals(const PoseStream& stream, const IntegrityLimits& limits,
                   IntegrityReport& report) {
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < stream.size(); ++i) {
    const std::int64_t interval_ns = stream[i].time_ns - stream[i - 1].time_ns;
    if (interval_ns <= 0) {
      ++report.num_repeated;
    } else {
      intervals_s.push_back(static_cast<double>(interval_ns) * kSecondsPerNs);
    }
  }
  if (intervals_s.empty()) return;
  report.median_interval_s = math::Median(intervals_s);
  report.longest_interval_s = std::ranges::max(intervals_s);
  // A recording at 10 Hz has no gaps only because it is slow.
  const double limit_s = std::max(limits.gap_s, limits.gap_intervals * report.median_interval_s);
  for (std::size_t i = 1; i < stream.size(); ++i) {
    const double interval_s =
        static_cast<double>(stream[i].time_ns - stream[i - 1].time_ns) * kSecondsPerNs;
    if (interval_s > limit_s) report.gaps.push_back({stream[i - 1].time_ns, i - 1, interval_s});
  }
}

bool IsSwap(std::span<const Command> commands, std::int64_t after_ns, std::int64_t until_ns) {
  return std::ranges::any_of(commands, [&](const Command& command) {
    return command.kind == CommandKind::kSwapHands && command.time_ns > after_ns &&
           command.time_ns <= until_ns;
  });
}

void FindJumps(const PoseStream& stream, const IntegrityLimits& limits,
               std::span<const Command> commands, IntegrityReport& report) {
  const PoseSample* last = nullptr;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const PoseSample& sample = stream[i];
    if (!sample.valid) continue;
    if (last != nullptr) {
      const double distance_mm =
          (sample.reference_from_tool.translation() - last->reference_from_tool.translation())
              .norm();
      const double time_s = static_cast<double>(sample.time_ns - last->time_ns) * kSecondsPerNs;
      const bool too_fast =
          distance_mm > limits.jitter_mm && distance_mm > limits.speed_mm_per_s * time_s;
      if ((distance_mm > limits.jump_mm || too_fast) &&
          !IsSwap(commands, last->time_ns, sample.time_ns)) {
        report.jumps.push_back({last->time_ns, i - 1, distance_mm});
      }
      if (sample.reference_from_tool == last->reference_from_tool) ++report.num_frozen;
    }
    last = &sample;
  }
}

void FindInvalidRuns(const PoseStream& stream, IntegrityReport& report) {
  for (std::size_t i = 0; i < stream.size(); ++i) {
    if (stream[i].valid) continue;
    ++report.num_invalid;
    if (i == 0 || stream[i - 1].valid) report.invalid_runs.push_back({stream[i].time_ns, i, 0.0});
    report.invalid_runs.back().amount += 1.0;
  }
}

double ExtentMm(const PoseStream& stream) {
  Eigen::AlignedBox3d box;
  for (const PoseSample& sample : stream) {
    if (sample.valid) box.extend(sample.reference_from_tool.translation());
  }
  return box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
}

double FarthestMm(const PoseStream& stream) {
  double farthest_mm = 0.0;
  for (const PoseSample& sample : stream) {
    if (!sample.valid) continue;
    farthest_mm =
        std::max(farthest_mm, sample.reference_from_tool.translation().cwiseAbs().maxCoeff());
  }
  return farthest_mm;
}

double MedianStepMm(const PoseStream& stream) {
  std::vector<double> steps_mm;
  const PoseSample* last = nullptr;
  for (const PoseSample& sample : stream) {
    if (!sample.valid) continue;
    const double step_mm =
        last == nullptr
            ? 0.0
            : (sample.reference_from_tool.translation() - last->reference_from_tool.translation())
                  .norm();
    if (step_mm > 0.0) steps_mm.push_back(step_mm);
    last = &sample;
  }
  return steps_mm.empty() ? 0.0 : math::Median(steps_mm);
}

std::string Sentence(const std::string& tool, const std::vector<IntegrityEvent>& events,
                     const char* what, const char* unit) {
  const auto worst = std::ranges::max_element(events, {}, &IntegrityEvent::amount);
  return Message(tool, ": ", Counted(std::ssize(events), what),
                 events.size() == 1 ? ", of " : ", the largest of ", RoundedText(worst->amount, 3),
                 " ", unit, " at ", SecondsText(worst->time_ns), " s (sample ", worst->sample, ")");
}

}  // namespace

IntegrityReport CheckIntegrity(const PoseStream& stream, const IntegrityLimits& limits,
                               std::span<const Command> commands) {
  Check(limits);
  IntegrityReport report;
  report.num_samples = stream.size();
  if (stream.empty()) return report;
  report.duration_s =
      static_cast<double>(stream.back().time_ns - stream.front().time_ns) * kSecondsPerNs;
  FindIntervals(stream, limits, report);
  FindJumps(stream, limits, commands, report);
  FindInvalidRuns(stream, report);
  report.extent_mm = ExtentMm(stream);
  report.median_step_mm = MedianStepMm(stream);
  report.farthest_mm = FarthestMm(stream);
  return report;
}

std::vector<std::string> Describe(const IntegrityReport& report, const std::string& tool) {
  std::vector<std::string> sentences;
  if (report.num_repeated > 0) {
    sentences.push_back(Message(tool, ": ", report.num_repeated, " samples are not later than the ",
                                "one before them"));
  }
  if (!report.gaps.empty()) {
    sentences.push_back(Sentence(tool, report.gaps, "gap# without samples", "s"));
  }
  if (!report.jumps.empty()) {
    sentences.push_back(
        Sentence(tool, report.jumps, "jump# faster or farther than a hand moves", "mm"));
  }
  if (report.num_invalid > 0) {
    sentences.push_back(
        Message(Sentence(tool, report.invalid_runs, "time# the tool was not seen", "samples"),
                ", together ", report.num_invalid, " of ", report.num_samples, " samples"));
  }
  // A hand that moved for seconds comes at least this far; a tool that lies still shows no more
  // than the tracker's noise, which is as large from sample to sample as over all of them.
  const bool moves = report.farthest_mm < kFarthestOfMetres &&
                     report.extent_mm > kMotionOverNoise * report.median_step_mm;
  if (report.duration_s > 2.0 && report.extent_mm > 0.05 && report.extent_mm < 2.0 && moves) {
    sentences.push_back(Message(tool, ": moves by no more than ", report.extent_mm, " mm in ",
                                report.duration_s,
                                " s. If it did move, its coordinates are in metres: they are "
                                "needed in mm, multiply them by 1000"));
  }
  return sentences;
}

}  // namespace acus::session
