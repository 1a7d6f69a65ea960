#include "acus/assess/study/analysis.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "acus/assess/study/trial_values.h"
#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::study {
namespace {

std::vector<GroupValues> GroupsOf(const Study& study, const ByCode& values) {
  std::vector<GroupValues> groups;
  for (const std::string& name : study.groups) {
    GroupValues group{name, {}, {}};
    for (const Participant& person : study.participants) {
      const auto found = values.find(person.code);
      if (person.group != name || found == values.end()) continue;
      group.codes.push_back(person.code);
      group.values.push_back(MeanOf(found->second));
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

Comparison Compare(const GroupValues& first, const GroupValues& second, const Study& study,
                   const std::string& name) {
  const AnalysisSettings& settings = study.analysis;
  Comparison comparison;
  comparison.test = MannWhitney(second.values, first.values);
  comparison.auc = AreaUnderCurve(second.values, first.values);
  comparison.cliffs_delta = 2.0 * comparison.auc - 1.0;
  if (std::min(first.values.size(), second.values.size()) >= kLeastToDrawAgain) {
    comparison.delta_interval =
        BootstrapInterval(second.values, first.values, CliffsDelta, settings.confidence,
                          settings.bootstrap_draws, study.seed, "delta " + name);
  }
  const bool has_pairs = first.values.size() >= 2 && second.values.size() >= 2;
  const double g = has_pairs ? HedgesG(second.values, first.values) : NAN;
  if (!std::isnan(g)) {
    comparison.hedges_g = g;
    comparison.g_interval =
        IntervalOfG(g, second.values.size(), first.values.size(), settings.confidence);
    comparison.next_study = SizeForPower(*comparison.hedges_g, settings.power, settings.alpha);
  }
  return comparison;
}

/// Least squares of log value over log trial.
std::optional<double> SlopeOf(const TrialValues& trials) {
  std::vector<std::pair<double, double>> points;
  for (const auto& [trial, value] : trials) {
    if (value > 0.0) points.emplace_back(std::log(trial), std::log(value));
  }
  if (points.size() < 2) return std::nullopt;
  double x_mean = 0.0, y_mean = 0.0;
  for (const auto& [x, y] : points) {
    x_mean += x / static_cast<double>(points.size());
    y_mean += y / static_cast<double>(points.size());
  }
  double xy = 0.0, xx = 0.0;
  for (const auto& [x, y] : points) {
    xy += (x - x_mean) * (y - y_mean);
    xx += (x - x_mean) * (x - x_mean);
  }
  return xy / xx;
}

LearningCurve LearningOf(const GroupValues& group, const ByCode& values) {
  LearningCurve curve;
  curve.group = group.group;
  std::map<int, std::vector<double>> by_trial;
  for (const std::string& code : group.codes) {
    const TrialValues& trials = values.at(code);
    for (const auto& [trial, value] : trials) by_trial[trial].push_back(value);
    if (const auto slope = SlopeOf(trials)) curve.slopes.push_back(*slope);
  }
  for (int trial = 1; by_trial.contains(trial); ++trial) {
    curve.mean_by_trial.push_back(math::Mean(by_trial.at(trial)));
  }
  if (curve.slopes.size() >= 2) curve.slope_test = WilcoxonSignedRank(curve.slopes);
  return curve;
}

std::optional<IntraclassCorrelation> ReliabilityOf(const ByCode& values, int num_trials) {
  std::vector<const TrialValues*> complete;
  for (const auto& [code, trials] : values) {
    bool all = true;
    for (int trial = 1; trial <= num_trials; ++trial) all = all && trials.contains(trial);
    if (all) complete.push_back(&trials);
  }
  if (complete.size() < 2 || num_trials < 2) return std::nullopt;
  Eigen::MatrixXd ratings(static_cast<Eigen::Index>(complete.size()), num_trials);
  for (Eigen::Index row = 0; row < ratings.rows(); ++row) {
    for (int trial = 1; trial <= num_trials; ++trial) {
      ratings(row, trial - 1) = complete[static_cast<std::size_t>(row)]->at(trial);
    }
  }
  return ComputeIcc(ratings);
}

MetricAnalysis AnalyseMetric(const Study& study, std::span<const TrialRecord> trials,
                             const std::string& exercise, const MetricKey& metric) {
  const ByCode values = ValuesOf(trials, exercise, metric);
  MetricAnalysis analysis{exercise, metric, GroupsOf(study, values), {}, {}, {}};
  if (analysis.groups.size() >= 2 && !analysis.groups[0].values.empty() &&
      !analysis.groups[1].values.empty()) {
    analysis.comparison = Compare(analysis.groups[0], analysis.groups[1], study,
                                  Message(exercise, " ", metric.name, " ", metric.unit));
  }
  for (const GroupValues& group : analysis.groups) {
    if (!group.values.empty()) analysis.learning.push_back(LearningOf(group, values));
  }
  analysis.reliability = ReliabilityOf(values, study.trials);
  return analysis;
}

/// Corrects the p values of one exercise for their number, and decides by them.
void CorrectForNumber(std::span<MetricAnalysis> metrics, const AnalysisSettings& settings) {
  std::vector<double> p;
  for (const MetricAnalysis& metric : metrics) {
    if (metric.comparison) p.push_back(metric.comparison->test.p);
  }
  const std::vector<double> corrected = HolmCorrected(p);
  auto next = corrected.begin();
  for (MetricAnalysis& metric : metrics) {
    if (!metric.comparison) continue;
    metric.comparison->p_holm = *next++;
    metric.comparison->separates = metric.comparison->DirectedAuc() >= settings.separating_auc &&
                                   metric.comparison->p_holm < settings.alpha;
  }
}

QuestionnaireAnalysis AnalyseAnswers(const Study& study, const Questionnaire& questionnaire,
                                     std::span<const Answer> answers) {
  QuestionnaireAnalysis analysis;
  analysis.questionnaire = questionnaire;
  const int top = static_cast<int>(questionnaire.scale.size());
  std::map<std::string, std::vector<double>> by_code;  // In the order of the items, if complete.
  for (const QuestionItem& item : questionnaire.items) {
    ItemAnalysis of_item{item, {}, std::vector<int>(questionnaire.scale.size(), 0)};
    std::map<std::string, std::vector<double>> by_group;
    for (const Answer& answer : answers) {
      if (answer.questionnaire != questionnaire.key || answer.item != item.key) continue;
      const int value = item.reversed ? top + 1 - answer.answer : answer.answer;
      by_group[study.Find(answer.code)->group].push_back(value);
      by_code[answer.code].push_back(value);
      ++of_item.counts[static_cast<std::size_t>(answer.answer - 1)];
    }
    for (const std::string& group : study.groups) {
      of_item.groups.push_back(
          by_group.contains(group) ? std::optional(Describe(by_group.at(group))) : std::nullopt);
    }
    analysis.items.push_back(std::move(of_item));
  }
  std::erase_if(by_code, [&](const auto& entry) {
    return entry.second.size() != questionnaire.items.size();
  });
  analysis.complete = static_cast<int>(by_code.size());
  if (by_code.size() < 2 || questionnaire.items.size() < 2) return analysis;
  Eigen::MatrixXd matrix(analysis.complete, static_cast<Eigen::Index>(questionnaire.items.size()));
  Eigen::Index row = 0;
  for (const auto& [code, values] : by_code) {
    for (Eigen::Index item = 0; item < matrix.cols(); ++item) {
      matrix(row, item) = values[static_cast<std::size_t>(item)];
    }
    ++row;
  }
  analysis.alpha = CronbachAlpha(matrix);
  return analysis;
}

}  // namespace

Description Describe(std::span<const double> values) {
  const auto [least, greatest] = std::ranges::minmax(values);
  return {static_cast<int>(values.size()),
          math::Mean(values),
          values.size() >= 2 ? math::StandardDeviation(values) : 0.0,
          math::Median(values),
          math::Quantile(values, 0.25),
          math::Quantile(values, 0.75),
          least,
          greatest};
}

StudyAnalysis Analyse(const Study& study, std::span<const TrialRecord> trials,
                      std::span<const Answer> answers) {
  StudyAnalysis analysis;
  for (const std::string& exercise : study.exercises) {
    std::set<MetricKey> keys;
    for (const TrialRecord& trial : trials) {
      if (trial.exercise != exercise) continue;
      for (const auto& [key, value] : trial.metrics) keys.insert(key);
    }
    const std::size_t from = analysis.metrics.size();
    for (const MetricKey& key : keys) {
      analysis.metrics.push_back(AnalyseMetric(study, trials, exercise, key));
    }
    CorrectForNumber(std::span(analysis.metrics).subspan(from), study.analysis);
  }
  for (const Questionnaire& questionnaire : study.questionnaires) {
    analysis.questionnaires.push_back(AnalyseAnswers(study, questionnaire, answers));
  }
  return analysis;
}

}  // namespace acus::study
