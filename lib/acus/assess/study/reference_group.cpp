#include "acus/assess/study/reference_group.h"

#include <algorithm>
#include <set>

#include "acus/assess/study/csv_cell.h"
#include "acus/assess/study/trial_values.h"
#include "acus/base/core/error.h"
#include "acus/base/core/words.h"
#include "acus/base/math/exact_intervals.h"
#include "acus/base/math/statistics.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;

constexpr double kReferenceConfidence = 0.95;
constexpr int kReferenceDraws = 2000;

std::vector<TrialRecord> GroupTrials(const training::Assessment& newest,
                                     std::span<const fs::path> folders, RunContext& context) {
  std::vector<TrialRecord> trials = FindTrials(folders, context);
  ACUS_REQUIRE(!trials.empty(), folders.front().string(),
               ": no trial was found; give run folders of acus-replay --exercise, or a folder of "
               "acus-training simulate");
  std::set<std::string> exercises;
  for (const TrialRecord& trial : trials) exercises.insert('"' + trial.exercise + '"');
  std::erase_if(trials, [&](const TrialRecord& t) { return t.exercise != newest.exercise; });
  ACUS_REQUIRE(!trials.empty(), folders.front().string(), ": no trial is of the exercise \"",
               newest.exercise, "\"; there are ",
               Joined(std::vector<std::string>(exercises.begin(), exercises.end())));
  std::erase_if(trials, [&](const TrialRecord& trial) { return trial.code == newest.trainee; });
  ACUS_REQUIRE(!trials.empty(), folders.front().string(), ": all trials are those of ",
               newest.trainee, "; a reference group is of other persons");
  return trials;
}

/// Means over the trials of each person that have the metric, in ascending order.
std::vector<double> MeansOfPersons(const MetricKey& metric, const std::string& exercise,
                                   std::span<const TrialRecord> trials) {
  std::vector<double> means;
  for (const auto& [code, values] : ValuesOf(trials, exercise, metric)) {
    means.push_back(MeanOf(values));
  }
  std::ranges::sort(means);
  return means;
}

/// The sessions of the trainee before the newest, in order.
std::vector<TrialRecord> EarlierOf(std::span<const training::Assessment> sessions) {
  std::vector<TrialRecord> earlier;
  for (const training::Assessment& session : sessions.first(sessions.size() - 1)) {
    if (session.trainee == sessions.back().trainee) earlier.push_back(RecordOf(session));
  }
  return earlier;
}

void PlaceInGroup(Standing& standing, std::uint64_t seed) {
  const std::vector<double>& persons = standing.persons;
  const auto n = static_cast<int>(persons.size());
  const auto below = static_cast<int>(
      std::ranges::count_if(persons, [&](double x) { return x < standing.value; }));
  const auto equal = static_cast<int>(std::ranges::count(persons, standing.value));
  standing.group_mean = math::Mean(persons);
  standing.percentile = 100.0 * (below + 0.5 * equal) / n;
  if (n < kFewestPersons) return;
  standing.group_interval = math::BootstrapIntervalOfMean(
      persons, kReferenceConfidence, kReferenceDraws, seed, "group " + standing.metric.name);
  standing.percentile_interval =
      math::Interval{100.0 * math::ShareInterval(below, n, kReferenceConfidence).low,
                     100.0 * math::ShareInterval(below + equal, n, kReferenceConfidence).high};
}

bool IsOfGoal(const std::string& metric, const training::Assessment& session) {
  return metric == kScore || metric == kGoalsMet ||
         std::ranges::any_of(session.goals, [&](const training::GoalResult& goal) {
           return CsvCell(goal.goal.metric) == metric;
         });
}

}  // namespace

GroupComparison CompareWithGroup(std::span<const training::Assessment> sessions,
                                 std::span<const fs::path> folders, RunContext& context) {
  const training::Assessment& newest = sessions.back();
  const std::vector<TrialRecord> group = GroupTrials(newest, folders, context);
  const std::vector<TrialRecord> earlier = EarlierOf(sessions);
  GroupComparison comparison{.code = newest.trainee,
                             .exercise = newest.exercise,
                             .num_persons = 0,
                             .num_trials = static_cast<int>(group.size()),
                             .standings = {}};
  std::set<std::string> codes;
  for (const TrialRecord& trial : group) codes.insert(trial.code);
  comparison.num_persons = static_cast<int>(codes.size());
  for (const auto& [metric, value] : RecordOf(newest).metrics) {
    Standing standing;
    standing.metric = metric;
    standing.value = value;
    standing.persons = MeansOfPersons(metric, newest.exercise, group);
    if (standing.persons.empty()) continue;
    for (const TrialRecord& before : earlier) {
      const auto found = before.metrics.find(metric);
      if (found != before.metrics.end()) standing.earlier.push_back(found->second);
    }
    standing.earlier_median = math::MedianInterval(standing.earlier, kReferenceConfidence);
    standing.is_of_goal = IsOfGoal(metric.name, newest);
    PlaceInGroup(standing, context.seed);
    comparison.standings.push_back(std::move(standing));
  }
  std::ranges::stable_partition(comparison.standings, &Standing::is_of_goal);
  return comparison;
}

}  // namespace acus::study
