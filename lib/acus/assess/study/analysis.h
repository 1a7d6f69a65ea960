// The statistics of a study: description and comparison of groups, metric by metric.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/assess/study/effect_size.h"
#include "acus/assess/study/rank_tests.h"
#include "acus/assess/study/reliability.h"
#include "acus/assess/study/study_data.h"

namespace acus::study {

/// The values of a group, one for each participant: the mean of the trials.
struct GroupValues {
  std::string group;
  std::vector<std::string> codes;
  std::vector<double> values;  ///< As long as codes.
};

/// n, mean, SD, median, quartiles, range.
struct Description {
  int n = 0;
  double mean = 0.0;
  double sd = 0.0;  ///< n - 1 in the denominator; 0 for one value.
  double median = 0.0, quartile_1 = 0.0, quartile_3 = 0.0;  ///< Type 7 of Hyndman & Fan.
  double least = 0.0, greatest = 0.0;
};

/// @pre not empty.
Description Describe(std::span<const double> values);

/// Comparison of the first two groups.
struct Comparison {
  RankTest test;
  double p_holm = 1.0;        ///< Corrected for the number of metrics of the exercise.
  double auc = 0.5;           ///< P(second > first); below 0.5: the first has the larger values.
  double cliffs_delta = 0.0;  ///< Delta of the second group relative to the first.
  /// By bootstrap; with kLeastToDrawAgain values in each group.
  std::optional<Interval> delta_interval;
  std::optional<double> hedges_g;  ///< With two values in each group, and scatter in one.
  std::optional<Interval> g_interval;
  SampleSize next_study;  ///< For a new study to detect this g.
  /// max(auc, 1 - auc) is at least AnalysisSettings::separating_auc, and p_holm below alpha.
  bool separates = false;

  /// The area in the direction in which the groups differ.
  double DirectedAuc() const { return auc < 0.5 ? 1.0 - auc : auc; }
};

/// Over trials 1 to n: value = first * trial^slope, by least squares of logarithms, for each
/// participant with at least two trials of positive values.
struct LearningCurve {
  std::string group;
  std::vector<double> mean_by_trial;   ///< Mean of all participants, from trial 1 on.
  std::vector<double> slopes;          ///< One for each participant with a curve.
  std::optional<RankTest> slope_test;  ///< Signed ranks against 0.
};

struct MetricAnalysis {
  std::string exercise;
  MetricKey metric;
  std::vector<GroupValues> groups;  ///< In the order of the study; those without values are empty.
  std::optional<Comparison> comparison;  ///< With two groups that have values.
  std::vector<LearningCurve> learning;   ///< One for each group with values.
  /// Trials as columns, over participants that did all of them; nothing with fewer than two of
  /// either.
  std::optional<IntraclassCorrelation> reliability;
};

struct ItemAnalysis {
  QuestionItem item;
  std::vector<std::optional<Description>> groups;  ///< In the order of the study.
  std::vector<int> counts;                         ///< Number of each answer, over all groups.
};

struct QuestionnaireAnalysis {
  Questionnaire questionnaire;
  std::vector<ItemAnalysis> items;
  std::optional<double> alpha;  ///< Over participants that answered all items.
  int complete = 0;             ///< Their number.
};

struct StudyAnalysis {
  std::vector<MetricAnalysis> metrics;  ///< By exercise, then by name.
  std::vector<QuestionnaireAnalysis> questionnaires;
};

/// Depends on the data and Study::seed only.
StudyAnalysis Analyse(const Study& study, std::span<const TrialRecord> trials,
                      std::span<const Answer> answers);

}  // namespace acus::study
