#include "acus/assess/study/study_tables.h"

#include <algorithm>

#include "acus/assess/study/csv_cell.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::study {
namespace {

std::string Head(const MetricAnalysis& a) {
  return CsvCell(a.exercise) + "," + a.metric.name + "," + a.metric.unit;
}

std::string Numbers(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += "," + NumberText(value);
  return text;
}

std::string DescriptionCells(const Description& d) {
  return Message(",", d.n) +
         Numbers({d.mean, d.sd, d.median, d.quartile_1, d.quartile_3, d.least, d.greatest});
}

}  // namespace

std::string DescriptiveCsv(const StudyAnalysis& analysis) {
  std::string csv =
      "exercise,metric,unit,group,n,mean,sd,median,quartile_1,quartile_3,least,greatest\n";
  for (const MetricAnalysis& a : analysis.metrics) {
    for (const GroupValues& group : a.groups) {
      if (group.values.empty()) continue;
      csv += Head(a) + "," + CsvCell(group.group) + DescriptionCells(Describe(group.values)) + "\n";
    }
  }
  return csv;
}

std::string ComparisonCsv(const StudyAnalysis& analysis) {
  std::string csv =
      "exercise,metric,unit,mann_whitney_u,exact,p,p_holm,auc,separates,cliffs_delta,delta_low,"
      "delta_high,hedges_g,g_low,g_high,next_n_t_test,next_n_mann_whitney\n";
  for (const MetricAnalysis& a : analysis.metrics) {
    if (!a.comparison) continue;
    const Comparison& c = *a.comparison;
    csv += Head(a) + "," + NumberText(c.test.statistic) + (c.test.exact ? ",1" : ",0") +
           Numbers({c.test.p, c.p_holm, c.auc}) + (c.separates ? ",1" : ",0") +
           Numbers({c.cliffs_delta});
    csv += c.delta_interval ? Numbers({c.delta_interval->low, c.delta_interval->high}) : ",,";
    csv += c.hedges_g ? Numbers({*c.hedges_g, c.g_interval->low, c.g_interval->high}) : ",,,";
    csv += c.next_study.t_test > 0
               ? Message(",", c.next_study.t_test, ",", c.next_study.mann_whitney)
               : ",,";
    csv += "\n";
  }
  return csv;
}

std::string LearningCsv(const StudyAnalysis& analysis) {
  std::string csv = "exercise,metric,unit,group,trial,mean,median_slope,slopes,p_slope\n";
  for (const MetricAnalysis& a : analysis.metrics) {
    for (const LearningCurve& curve : a.learning) {
      for (std::size_t trial = 0; trial < curve.mean_by_trial.size(); ++trial) {
        csv += Head(a) + "," + CsvCell(curve.group) + Message(",", trial + 1) +
               Numbers({curve.mean_by_trial[trial]});
        csv += curve.slopes.empty() ? "," : Numbers({math::Median(curve.slopes)});
        csv += Message(",", curve.slopes.size());
        csv += curve.slope_test ? Numbers({curve.slope_test->p}) : ",";
        csv += "\n";
      }
    }
  }
  return csv;
}

std::string ReliabilityCsv(const StudyAnalysis& analysis) {
  std::string csv = "exercise,metric,unit,icc_1_1,icc_2_1,icc_3_1,icc_1_k,icc_2_k,icc_3_k\n";
  for (const MetricAnalysis& a : analysis.metrics) {
    if (!a.reliability) continue;
    const IntraclassCorrelation& r = *a.reliability;
    csv += Head(a) + Numbers({r.icc_1_1, r.icc_2_1, r.icc_3_1, r.icc_1_k, r.icc_2_k, r.icc_3_k}) +
           "\n";
  }
  return csv;
}

std::string ItemsCsv(const Study& study, const StudyAnalysis& analysis) {
  std::string csv =
      "questionnaire,item,group,n,mean,sd,median,quartile_1,quartile_3,least,greatest\n";
  for (const QuestionnaireAnalysis& q : analysis.questionnaires) {
    for (const ItemAnalysis& item : q.items) {
      for (std::size_t g = 0; g < item.groups.size(); ++g) {
        if (!item.groups[g]) continue;
        csv += q.questionnaire.key + "," + item.item.key + "," + CsvCell(study.groups[g]) +
               DescriptionCells(*item.groups[g]) + "\n";
      }
    }
  }
  return csv;
}

std::string AnswersCsv(std::span<const Answer> answers) {
  std::string csv = "code,questionnaire,item,answer\n";
  for (const Answer& a : answers) {
    csv += Message(a.code, ",", a.questionnaire, ",", a.item, ",", a.answer, "\n");
  }
  return csv;
}

}  // namespace acus::study
