// Compares a trainee's newest session with the earlier ones and with a group of other persons.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/assess/study/study_data.h"
#include "acus/base/math/bootstrap.h"
#include "acus/run/training/assessment.h"

namespace acus::study {

/// Smallest size of a group for intervals.
inline constexpr int kFewestPersons = 3;

/// The result for one metric. Intervals have 95 % confidence.
struct Standing {
  MetricKey metric;
  double value = 0.0;           ///< Value of the newest session.
  std::vector<double> earlier;  ///< Values of the trainee's earlier sessions, in order.
  std::vector<double> persons;  ///< Means of the group's persons, in ascending order.
  double group_mean = 0.0;      ///< Mean of these.
  double percentile = 0.0;      ///< Share of persons below the value, ties by half, percent.
  bool is_of_goal = false;      ///< The metric of a goal, the score, or the share of goals met.
  /// Between order statistics; nothing with fewer than 6 earlier sessions.
  std::optional<math::Interval> earlier_median;
  /// Percentile bootstrap over persons; nothing with fewer than kFewestPersons, as for the next
  /// one.
  std::optional<math::Interval> group_interval;
  /// Clopper-Pearson, from the strictly smaller to the smaller or equal persons, percent.
  std::optional<math::Interval> percentile_interval;
};

struct GroupComparison {
  std::string code;
  std::string exercise;
  int num_persons = 0;
  int num_trials = 0;
  std::vector<Standing> standings;  ///< Metrics of goals first; only metrics that the group has.
};

/// @param sessions  Sessions of one exercise, in order; the trainee is that of the last one.
/// @param folders  Folders with the group's trials at any depth; the trainee's are omitted.
/// @throws InputError if the group has no trial of another person in this exercise.
GroupComparison CompareWithGroup(std::span<const training::Assessment> sessions,
                                 std::span<const std::filesystem::path> folders,
                                 RunContext& context);

}  // namespace acus::study
