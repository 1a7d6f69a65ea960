// A trainee's newest session beside the earlier ones and beside a group of other persons.
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

/// Of a group, for intervals.
inline constexpr int kFewestPersons = 3;

/// One metric. Intervals are those of 95 %.
struct Standing {
  MetricKey metric;
  double value = 0.0;           ///< Of the newest session.
  std::vector<double> earlier;  ///< Of the trainee, in order.
  std::vector<double> persons;  ///< Means of the group's persons, in ascending order.
  double group_mean = 0.0;      ///< Of these.
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
  std::vector<Standing> standings;  ///< Those of goals first; only metrics that the group has.
};

/// @param sessions  Of one exercise, in order; the trainee is that of the last one.
/// @param folders  Of the group's trials at any depth; those of the trainee are left out.
/// @throws InputError if the group has no trial of another person in this exercise.
GroupComparison CompareWithGroup(std::span<const training::Assessment> sessions,
                                 std::span<const std::filesystem::path> folders,
                                 RunContext& context);

}  // namespace acus::study
