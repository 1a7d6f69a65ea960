#include "acus/run/replay/run_report.h"

#include <nlohmann/json.hpp>

#include "acus/base/core/text_table.h"
#include "acus/base/report/html_report.h"
#include "acus/base/report/svg_plot.h"
#include "acus/run/replay/effect_meters.h"
#include "acus/run/replay/event_log.h"
#include "acus/run/replay/plan_diagram.h"
#include "acus/run/replay/plan_table.h"

namespace acus::replay {
namespace {

using forces::NeedleEvent;
using simulation::StepOutput;

std::string FourDigits(double value) {
  return RoundedText(value, 4);
}

/// Seconds since the first step.
double SecondsOf(const StepLog& log, std::int64_t time_ns) {
  return 1e-9 * static_cast<double>(time_ns - log.steps.front().time_ns);
}
double SecondsOf(const StepLog& log, const StepOutput& step) {
  return SecondsOf(log, step.time_ns);
}

report::Series SeriesOf(const StepLog& log, std::string name, double (*value)(const StepOutput&)) {
  report::Series series;
  series.name = std::move(name);
  for (const StepOutput& step : log.steps) {
    series.x.push_back(SecondsOf(log, step));
    series.y.push_back(value(step));
  }
  return series;
}

/// Interfaces are many and small: only what a hand feels is marked.
bool IsMarked(NeedleEvent event) {
  return event == NeedleEvent::kContact || event == NeedleEvent::kPuncture ||
         event == NeedleEvent::kBoneContact || event == NeedleEvent::kWithdrawal;
}

std::vector<report::Plot> ForcePlots(const StepLog& log) {
  report::Plot axial;
  axial.title = "Force along the needle (positive pushes it out)";
  axial.x_label = "time [s]";
  axial.y_label = "force [N]";
  axial.series = {SeriesOf(log, "total", [](const StepOutput& s) { return s.force.AxialN(); }),
                  SeriesOf(log, "puncture", [](const StepOutput& s) { return s.force.puncture_n; }),
                  SeriesOf(log, "cutting", [](const StepOutput& s) { return s.force.cutting_n; }),
                  SeriesOf(log, "friction", [](const StepOutput& s) { return s.force.friction_n; }),
                  SeriesOf(log, "bone", [](const StepOutput& s) { return s.force.bone_n; })};
  for (const StepOutput& step : log.steps) {
    if (!IsMarked(step.force.event)) continue;
    axial.marks.push_back({SecondsOf(log, step), EventWords(forces::NameOf(step.force.event))});
  }
  report::Plot lateral;
  lateral.title = "Force across the needle";
  lateral.x_label = "time [s]";
  lateral.y_label = "force [N]";
  lateral.height_px = 180;
  lateral.series = {SeriesOf(log, "", [](const StepOutput& s) { return s.force.lateral_n; })};
  report::Plot depth = lateral;
  depth.title = "Depth of the tip along its path";
  depth.y_label = "depth [mm]";
  depth.series = {SeriesOf(log, "", [](const StepOutput& s) { return s.force.depth_mm; })};
  return {axial, lateral, depth};
}

std::vector<report::Plot> ProbePlots(const StepLog& log) {
  report::Plot force;
  force.title = "Force on the probe";
  force.x_label = "time [s]";
  force.y_label = "force [N]";
  force.height_px = 220;
  force.series = {
      SeriesOf(log, "", [](const StepOutput& s) { return s.probe.force_in_ct_n.norm(); })};
  report::Plot depth = force;
  depth.title = "How deep the probe is beyond skin and bone at rest";
  depth.y_label = "depth [mm]";
  depth.series = {SeriesOf(log, "skin", [](const StepOutput& s) { return s.probe.skin_mm; }),
                  SeriesOf(log, "bone", [](const StepOutput& s) { return s.probe.bone_mm; })};
  return {force, depth};
}

report::Plot ForceOverDepth(const StepLog& log) {
  report::Plot plot;
  plot.title = "Force over depth";
  plot.x_label = "depth [mm]";
  plot.y_label = "force along the needle [N]";
  report::Series series;
  for (const StepOutput& step : log.steps) {
    if (step.force.depth_mm <= 0.0) continue;
    series.x.push_back(step.force.depth_mm);
    series.y.push_back(step.force.AxialN());
  }
  plot.series = {std::move(series)};
  return plot;
}

report::Plot DeflectionPlot(const StepLog& log) {
  report::Plot plot;
  plot.title = "Deflection of the needle's tip";
  plot.x_label = "time [s]";
  plot.y_label = "deflection [mm]";
  plot.height_px = 220;
  plot.y_from_zero = true;
  plot.series = {SeriesOf(log, "", [](const StepOutput& s) { return s.shape.tip_deflection_mm; })};
  if (!log.most_bent.empty()) {
    plot.marks.push_back({SecondsOf(log, log.steps[log.most_bent_step]), "most bent"});
  }
  return plot;
}

/// The needle in the plane in which its tip is bent, the hub on the left, at its largest
/// deflection.
report::Plot ShapePlot(const StepLog& log) {
  const math::Polyline& line = log.most_bent;
  const int hub = line.num_points - 1;
  const auto at = [&](int i) -> Eigen::Vector3d { return line.At(hub - i) - line.At(hub); };
  // The hub's direction from its first two pieces; exact for a circle.
  const Eigen::Vector3d axis =
      (1.5 * at(1).normalized() - 0.5 * (at(2) - at(1)).normalized()).normalized();
  Eigen::Vector3d side = at(hub) - at(hub).dot(axis) * axis;
  if (side.norm() > 0.0) side.normalize();
  report::Series bent{.name = "needle"};
  for (int i = 0; i <= hub; ++i) {
    bent.x.push_back(at(i).dot(axis));
    bent.y.push_back(at(i).dot(side));
  }
  report::Series straight{.name = "line of the hub", .x = {0.0, bent.x.back()}, .y = {0.0, 0.0}};
  report::Plot plot;
  const StepOutput& step = log.steps[log.most_bent_step];
  plot.title = Message(
      "Shape at the largest deflection, ", FourDigits(step.shape.tip_deflection_mm), " mm at ",
      FourDigits(SecondsOf(log, step)), " s, ", FourDigits(step.force.depth_mm), " mm deep");
  plot.x_label = "along the hub's line [mm]";
  plot.y_label = "off it [mm]";
  plot.series = {std::move(bent), std::move(straight)};
  return plot;
}

void AddEvents(report::HtmlReport& html, const StepLog& log,
               const std::vector<LoggedEvent>& events) {
  std::vector<std::vector<std::string>> rows;
  for (const LoggedEvent& event : events) {
    rows.push_back({FourDigits(SecondsOf(log, event.time_ns)), EventWords(event.name), event.tissue,
                    FourDigits(event.depth_mm), FourDigits(event.force_before_n),
                    FourDigits(event.force_axial_n)});
  }
  html.Section("Events");
  html.Table(
      {"time [s]", "event", "tissue at the tip", "depth [mm]", "force before [N]", "force [N]"},
      rows);
}

/// Lines at the limits that the exercise sets for a metric: the largest value of the plot, or with
/// `of_magnitude` the largest magnitude.
void AddGoalLines(report::Plot& plot, const ReportContent& content, std::string_view metric,
                  bool of_magnitude = false) {
  if (!content.assessment) return;
  for (const training::GoalResult& result : content.assessment->goals) {
    if (result.goal.metric != metric) continue;
    for (const auto& [words, limit] :
         {std::pair{"at most ", result.goal.at_most}, {"at least ", result.goal.at_least}}) {
      if (!limit) continue;
      const std::string text = Message("goal: ", words, RoundedText(*limit, 4), " ", result.unit);
      plot.limits.push_back({*limit, text});
      if (of_magnitude) plot.limits.push_back({-*limit, text});
    }
  }
}

void AddExercise(report::HtmlReport& html, const training::Assessment& assessment) {
  html.Section("Outcome");
  html.Paragraph(training::OutcomeText(assessment) + ' ' + training::VerdictText(assessment));
  html.Paragraph(Message(assessment.exercise, assessment.trainee.empty() ? "" : ", trainee ",
                         assessment.trainee, ": ", assessment.NumMet(), " of ",
                         assessment.goals.size(), " goals met."));
  std::vector<std::vector<std::string>> goals;
  for (const training::GoalResult& result : assessment.goals) {
    const char* state = !IsJudged(assessment, result) ? "not judged"
                        : result.met                  ? "met"
                                                      : "not met";
    goals.push_back({Message(state, result.goal.must ? " (must)" : ""), result.goal.metric,
                     result.value ? FourDigits(*result.value) : "-", result.unit,
                     GoalText(result.goal, result.unit), result.goal.why});
  }
  html.Table({"", "goal", "value", "unit", "required", "why"}, goals);
  std::vector<std::vector<std::string>> steps;
  for (const training::StepResult& step : assessment.checklist) {
    const bool open = step.state == training::StepState::kOpen;
    steps.push_back({std::string(NameOf(step.state)), step.text,
                     open ? "-" : FourDigits(1e-9 * static_cast<double>(step.time_ns))});
  }
  if (!steps.empty()) html.Table({"", "step", "time [s]"}, steps, "Checklist");
  std::vector<std::vector<std::string>> structures;
  for (const training::NamedStructure& structure : assessment.structures) {
    structures.push_back({structure.name, std::to_string(structure.entered.num_entries),
                          FourDigits(structure.entered.path_mm)});
  }
  html.Table({"tissue", "entries of the tip", "path of the tip [mm]"}, structures,
             "What the tip went through");
}

/// @pre content.others
void AddOthers(report::HtmlReport& html, const ReportContent& content, const StepLog& log) {
  html.Section("Other patients");
  html.Paragraph(Message(
      "The same motion in ", content.others->patients.size(),
      " other patients whose tissues are softer or stiffer, as between_patients of the tables of "
      "forces and moduli says. What a hand would do otherwise there is not in it."));
  html.Plots(std::vector{RangePlot(*content.others, log)});
  const RangeTable table = TableOf(*content.others, content.metrics);
  html.Table(table.header, table.rows,
             "other_patients.csv has each of them, with the seed that "
             "replays it (/patient/stiffness/seed).");
}

void AddPlan(report::HtmlReport& html, const simulation::EffectPlan& plan,
             const simulation::StageTimes& times) {
  html.Drawing(PlanSvg(plan, times),
               "What the scenario's effects call for, from inputs to outputs. Place the mouse on a "
               "stage for its reasons.");
  for (const std::string& line : SleepLines(plan, times)) html.Paragraph("Asleep - " + line + ".");
  const PlanTable table = TableOfPlan(plan, &times);
  html.Table(table.header, table.rows, "The stages, and the CPU time that they took in this run.");
  const PlanTable flow = FlowOfPlan(plan);
  html.Table(flow.header, flow.rows, "What they read and write. They touch nothing else.");
}

/// A column over the depth of the needle, with the tissues on its way.
report::Plot OverDepth(const StepLog& log, const simulation::ListedEffect& effect, std::size_t n,
                       const simulation::Scene& scene) {
  const effects::Column& column = effect.columns[n];
  report::Plot plot;
  plot.title = column.title + " over depth";
  plot.x_label = "depth [mm]";
  plot.y_label = Message(column.name, " [", column.unit, "]");
  plot.height_px = 220;
  report::Series series;
  double deepest_mm = 0.0;
  volume::Label tissue = 0;
  for (const StepOutput& step : log.steps) {
    if (step.force.depth_mm <= 0.0) continue;
    series.x.push_back(step.force.depth_mm);
    series.y.push_back(step.effect[effect.first_column + n]);
    if (step.force.depth_mm <= deepest_mm) continue;
    deepest_mm = step.force.depth_mm;
    if (step.tissue_at_tip != tissue) {
      plot.marks.push_back({deepest_mm, TissueName(scene, step.tissue_at_tip)});
    }
    tissue = step.tissue_at_tip;
  }
  plot.series = {std::move(series)};
  return plot;
}

/// What effects of the list found, and what they wrote down over time.
void AddListedEffects(report::HtmlReport& html, const StepLog& log, const simulation::Scene& scene,
                      const std::vector<LoggedEvent>& events) {
  EffectMeters meters(scene);
  for (const StepOutput& step : log.steps) meters.Add(step);
  for (const simulation::ListedEffect& other : scene.listed.all()) {
    if (other.columns.empty() || log.steps.empty()) continue;
    std::vector<report::Plot> plots;
    for (std::size_t n = 0; n < other.columns.size(); ++n) {
      const effects::Column& column = other.columns[n];
      report::Series series;
      for (const StepOutput& step : log.steps) {
        series.x.push_back(SecondsOf(log, step));
        series.y.push_back(step.effect[other.first_column + n]);
      }
      report::Plot plot;
      plot.title = column.title;
      plot.x_label = "time [s]";
      plot.y_label =
          column.unit.empty() ? column.name : Message(column.name, " [", column.unit, "]");
      plot.height_px = 180;
      plot.series = {std::move(series)};
      for (const LoggedEvent& event : events) {
        if (!plots.empty() || event.effect != other.key) continue;
        plot.marks.push_back({SecondsOf(log, event.time_ns), EventWords(event.name)});
      }
      plots.push_back(std::move(plot));
      if (column.over_depth && scene.plan.Writes(effects::ports::kForce)) {
        plots.push_back(OverDepth(log, other, n, scene));
      }
    }
    html.Section(std::string(other.title));
    for (const std::string& finding : meters.FindingsOf(other.key)) html.Paragraph(finding);
    html.Plots(plots);
  }
}

}  // namespace

void WriteReport(const std::filesystem::path& folder, const ReportContent& content,
                 const StepLog& log, const simulation::Scene& scene, const Provenance& provenance) {
  report::HtmlReport html(content.title, "Replay of a recorded session");
  html.Warnings(content.warnings);
  if (content.assessment) AddExercise(html, *content.assessment);
  const std::vector<LoggedEvent> events = EventsOf(scene, log);
  html.Section("Summary");
  html.KeyValues(content.facts);
  if (!content.films.empty() || !content.images.empty()) html.Section("Images");
  for (const WrittenFilm& film : content.films) html.Film(film.file, film.title);
  for (const WrittenPng& image : content.images) {
    html.Image(folder / image.file, image.caption, image.caption);
  }
  const bool has_forces = scene.plan.Writes(effects::ports::kForce) && !log.steps.empty();
  if (has_forces) {
    html.Section("Forces");
    auto plots = ForcePlots(log);
    AddGoalLines(plots[0], content, "largest axial force", true);
    AddGoalLines(plots[1], content, "largest lateral force");
    AddGoalLines(plots[2], content, "greatest depth");
    report::WriteSvg(folder / "forces.svg", plots);
    html.Plots(plots);
    html.Plots(std::vector{ForceOverDepth(log)});
    if (scene.shape && scene.shape->bendable()) {
      html.Section("Shape of the needle");
      html.Plots(std::vector{DeflectionPlot(log)});
      if (!log.most_bent.empty()) html.Plots(std::vector{ShapePlot(log)});
    }
    AddEvents(html, log, events);
    if (content.others) AddOthers(html, content, log);
  }
  if (scene.plan.Writes(effects::ports::kProbeForce) && !log.steps.empty()) {
    html.Section("Probe");
    auto plots = ProbePlots(log);
    AddGoalLines(plots[0], content, "largest probe force");
    AddGoalLines(plots[1], content, "greatest depth of the probe");
    report::WriteSvg(folder / "probe_forces.svg", plots);
    html.Plots(plots);
  }
  AddListedEffects(html, log, scene, events);
  html.Section("Metrics");
  std::vector<std::vector<std::string>> rows;
  for (const Metric& metric : content.metrics) {
    rows.push_back({metric.name, FourDigits(metric.value), metric.unit});
  }
  html.Table({"metric", "value", "unit"}, rows);
  html.Section("Effect plan");
  AddPlan(html, scene.plan, content.times);
  html.SetProvenance(provenance.ToJson());
  html.Write(folder / "report.html");
}

}  // namespace acus::replay
