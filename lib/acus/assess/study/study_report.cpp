#include "acus/assess/study/study_report.h"

#include <algorithm>
#include <boost/math/special_functions/binomial.hpp>

#include "acus/assess/study/box_plot.h"
#include "acus/assess/study/study_tables.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/base/report/html_report.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;
using Rows = std::vector<std::vector<std::string>>;

std::string PText(double p) {
  return p < 0.001 ? "< 0.001" : FixedText(p, 3);
}

std::string MeanText(const GroupValues& group) {
  if (group.values.empty()) return "-";
  const Description d = Describe(group.values);
  return Message(RoundedText(d.mean, 3), " (", RoundedText(d.sd, 2), "); ",
                 RoundedText(d.median, 3), " [", RoundedText(d.quartile_1, 3), ", ",
                 RoundedText(d.quartile_3, 3), "]");
}

std::string WithInterval(double value, const std::optional<Interval>& interval) {
  return FixedText(value, 2) + (interval ? Message(" [", FixedText(interval->low, 2), ", ",
                                                   FixedText(interval->high, 2), "]")
                                         : "");
}

Rows MetricRows(std::span<const MetricAnalysis> metrics) {
  Rows rows;
  for (const MetricAnalysis& a : metrics) {
    std::vector<std::string> row = {WithUnit(a.metric)};
    for (const GroupValues& group : a.groups) row.push_back(MeanText(group));
    if (!a.comparison) {
      row.insert(row.end(), 6, "-");
    } else {
      const Comparison& c = *a.comparison;
      row.push_back(PText(c.test.p));
      row.push_back(PText(c.p_holm));
      row.push_back(FixedText(c.DirectedAuc(), 3));
      row.push_back(WithInterval(c.cliffs_delta, c.delta_interval));
      row.push_back(c.hedges_g ? WithInterval(*c.hedges_g, c.g_interval) : "-");
      row.push_back(c.next_study.t_test > 0 ? std::to_string(c.next_study.mann_whitney) : "-");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<std::string> MetricHeader(const Study& study) {
  std::vector<std::string> header = {"metric"};
  for (const std::string& group : study.groups) header.push_back(group);
  header.insert(header.end(),
                {"p", "p (Holm)", "AUC", "Cliff's delta", "Hedges' g", "n per group next time"});
  return header;
}

Rows LearningRows(std::span<const MetricAnalysis> metrics) {
  Rows rows;
  for (const MetricAnalysis& a : metrics) {
    for (const LearningCurve& curve : a.learning) {
      std::string means;
      for (const double mean : curve.mean_by_trial) {
        means += (means.empty() ? "" : " -> ") + RoundedText(mean, 3);
      }
      rows.push_back({WithUnit(a.metric), curve.group, means,
                      curve.slopes.empty() ? "-" : FixedText(math::Median(curve.slopes), 2),
                      curve.slope_test ? PText(curve.slope_test->p) : "-"});
    }
  }
  return rows;
}

Rows ReliabilityRows(std::span<const MetricAnalysis> metrics) {
  Rows rows;
  for (const MetricAnalysis& a : metrics) {
    if (!a.reliability) continue;
    rows.push_back({WithUnit(a.metric), FixedText(a.reliability->icc_2_1, 2),
                    FixedText(a.reliability->icc_3_1, 2), FixedText(a.reliability->icc_2_k, 2),
                    FixedText(a.reliability->icc_3_k, 2)});
  }
  return rows;
}

/// Each with its area, or where the groups are not distinguished with its corrected p.
std::string NamesWhere(std::span<const MetricAnalysis> metrics, bool separates) {
  std::string names;
  for (const MetricAnalysis& a : metrics) {
    if (!a.comparison || a.comparison->separates != separates) continue;
    names += Message(
        names.empty() ? "" : ", ", a.metric.name, " (",
        separates ? FixedText(a.comparison->DirectedAuc(), 2) : "p " + PText(a.comparison->p_holm),
        ")");
  }
  return names.empty() ? "none" : names;
}

/// Where so few participants cannot give a small p, whatever their values are: the sentence that
/// says so; else empty.
std::string TooFewText(std::span<const MetricAnalysis> metrics, const Study& study) {
  int compared = 0;
  double least_p = 1.0;
  std::string sizes;
  for (const MetricAnalysis& a : metrics) {
    if (!a.comparison) continue;
    ++compared;
    const auto m = static_cast<unsigned>(a.groups[0].values.size());
    const auto n = static_cast<unsigned>(a.groups[1].values.size());
    const double p = std::min(1.0, 2.0 / boost::math::binomial_coefficient<double>(m + n, m));
    if (p > least_p) continue;
    least_p = p;
    sizes = Message(m, " and ", n);
  }
  const double least_holm = std::min(1.0, least_p * compared);
  if (compared == 0 || least_holm < study.analysis.alpha) return "";
  return Message("Too few participants to distinguish the groups: with ", sizes, " and ",
                 Counted(compared, "metric"), " p (Holm) cannot be below ",
                 RoundedText(least_holm, 2), ", whatever their values are.");
}

std::string CriterionText(const Study& study) {
  return Message("area under the curve at least ", RoundedText(study.analysis.separating_auc, 3),
                 " and p (Holm) below ", RoundedText(study.analysis.alpha, 3));
}

/// Empty where people did all trials.
std::string VirtualText(std::span<const TrialRecord> trials) {
  const auto simulated = std::ranges::count_if(trials, &TrialRecord::by_virtual_trainee);
  if (simulated == 0) return "";
  const auto all = static_cast<std::ptrdiff_t>(trials.size());
  return Message(
      simulated == all ? "All" : std::to_string(simulated) + " of", " ", Counted(all, "trial"),
      " are of virtual trainees, whose skill is a setting: differences between the groups "
      "are those of the settings, and say nothing about people or about training.");
}

/// The metrics of one exercise.
std::span<const MetricAnalysis> Of(const StudyAnalysis& analysis, const std::string& exercise) {
  const auto first = std::ranges::find(analysis.metrics, exercise, &MetricAnalysis::exercise);
  auto last = first;
  while (last != analysis.metrics.end() && last->exercise == exercise) ++last;
  return {first, last};
}

std::string BoxPlots(std::span<const MetricAnalysis> metrics) {
  std::string svg;
  for (const MetricAnalysis& a : metrics) {
    std::vector<Box> boxes;
    for (const GroupValues& group : a.groups) {
      if (!group.values.empty()) boxes.push_back({group.group, group.values});
    }
    svg += BoxPlotSvg(a.metric.name, a.metric.unit, boxes);
  }
  return svg;
}

void AddExercise(report::HtmlReport& html, const Study& study, const StudyAnalysis& analysis,
                 const std::string& exercise) {
  const auto metrics = Of(analysis, exercise);
  if (metrics.empty()) return;
  html.Section(exercise);
  if (study.groups.size() >= 2) {
    if (const auto few = TooFewText(metrics, study); !few.empty()) html.Paragraph(few);
    html.Paragraph(Message("Metrics that distinguish ", study.groups[0], " from ", study.groups[1],
                           " (", CriterionText(study), "): ", NamesWhere(metrics, true), "."));
    html.Paragraph("Not distinguished by: " + NamesWhere(metrics, false) + ".");
  }
  html.Table(
      MetricHeader(study), MetricRows(metrics),
      "Mean (SD); median [quartiles] of the participants' means over their trials. "
      "p: Mann-Whitney, two-sided. Effects of the second group against the first, with "
      "intervals: of Cliff's delta by bootstrap, from five participants in each group on; of "
      "Hedges' g by the noncentral t distribution");
  html.Drawing(BoxPlots(metrics), "A dot for each participant");
  html.Table({"metric", "group", "mean by trial", "median slope", "p"}, LearningRows(metrics),
             "Learning: slope of the logarithm over the logarithm of the trial; p: signed ranks "
             "against 0");
  html.Table({"metric", "ICC(2,1)", "ICC(3,1)", "ICC(2,k)", "ICC(3,k)"}, ReliabilityRows(metrics),
             "Reliability over trials, Shrout & Fleiss 1979; all groups together");
}

void AddQuestionnaire(report::HtmlReport& html, const Study& study,
                      const QuestionnaireAnalysis& q) {
  html.Section(q.questionnaire.title);
  std::vector<std::string> header = {"statement"};
  for (const std::string& group : study.groups) header.push_back(group);
  for (std::size_t n = 0; n < q.questionnaire.scale.size(); ++n) {
    header.push_back(Message(n + 1, ": ", q.questionnaire.scale[n]));
  }
  Rows rows;
  for (const ItemAnalysis& item : q.items) {
    std::vector<std::string> row = {item.item.text + (item.item.reversed ? " (reversed)" : "")};
    for (const auto& d : item.groups) {
      row.push_back(d ? Message(FixedText(d->mean, 2), " (", FixedText(d->sd, 2), "), n = ", d->n)
                      : "-");
    }
    for (const int count : item.counts) row.push_back(std::to_string(count));
    rows.push_back(std::move(row));
  }
  html.Table(header, rows, "Mean (SD) by group; number of each answer over all groups");
  html.Paragraph(q.alpha ? Message("Cronbach's alpha: ", FixedText(*q.alpha, 2), " over ",
                                   q.complete, " complete sets of answers.")
                         : "Fewer than two complete sets of answers: no Cronbach's alpha.");
}

void WritePage(const fs::path& path, const Study& study, std::span<const TrialRecord> trials,
               std::span<const Answer> answers, const StudyAnalysis& analysis,
               const RunContext& context) {
  report::HtmlReport html(study.name, "Report of a study");
  if (const auto simulated = VirtualText(trials); !simulated.empty()) {
    html.Warnings(std::vector{simulated});
  }
  html.Section("Participants");
  Rows rows;
  for (const std::string& group : study.groups) {
    const auto in_group = [&](const Participant& p) { return p.group == group; };
    rows.push_back(
        {group, std::to_string(std::ranges::count_if(study.participants, in_group)),
         std::to_string(std::ranges::count_if(
             study.participants, [&](const Participant& p) { return in_group(p) && p.consent; })),
         std::to_string(std::ranges::count_if(
             trials, [&](const TrialRecord& t) { return study.Find(t.code)->group == group; }))});
  }
  html.Table({"group", "participants", "with consent", "trials"}, rows);
  for (const std::string& exercise : study.exercises) AddExercise(html, study, analysis, exercise);
  if (!answers.empty()) {
    for (const auto& q : analysis.questionnaires) AddQuestionnaire(html, study, q);
  }
  html.SetProvenance(context.provenance.ToJson());
  html.Write(path);
}

}  // namespace

void WriteStudyReport(const fs::path& folder, const Study& study,
                      std::span<const TrialRecord> trials, std::span<const Answer> answers,
                      const StudyAnalysis& analysis, const RunContext& context) {
  WriteTextFile(folder / "trials.csv", TrialsCsv(study, trials));
  WriteTextFile(folder / "descriptive.csv", DescriptiveCsv(analysis));
  WriteTextFile(folder / "comparison.csv", ComparisonCsv(analysis));
  WriteTextFile(folder / "learning.csv", LearningCsv(analysis));
  WriteTextFile(folder / "reliability.csv", ReliabilityCsv(analysis));
  if (!answers.empty()) {
    WriteTextFile(folder / "answers.csv", AnswersCsv(answers));
    WriteTextFile(folder / "items.csv", ItemsCsv(study, analysis));
  }
  WritePage(folder / "study.html", study, trials, answers, analysis, context);
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

std::string StudyText(const Study& study, std::span<const TrialRecord> trials,
                      const StudyAnalysis& analysis) {
  std::string text =
      Message(study.name, ": ", Counted(static_cast<std::int64_t>(trials.size()), "trial"), ".\n");
  if (const auto simulated = VirtualText(trials); !simulated.empty()) text += simulated + "\n";
  for (const std::string& exercise : study.exercises) {
    const auto metrics = Of(analysis, exercise);
    if (metrics.empty()) continue;
    text += exercise + "\n";
    if (study.groups.size() < 2) continue;
    if (const auto few = TooFewText(metrics, study); !few.empty()) text += "  " + few + "\n";
    text += Message("  distinguish ", study.groups[0], " from ", study.groups[1], ": ",
                    NamesWhere(metrics, true), "\n  do not: ", NamesWhere(metrics, false), "\n");
  }
  return text;
}

}  // namespace acus::study
