#include "acus/run/replay/run_folder.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/config/shown_document.h"
#include "acus/base/core/shown_path.h"
#include "acus/base/core/text_table.h"
#include "acus/run/replay/event_log.h"
#include "acus/run/replay/markups.h"
#include "acus/run/replay/run_report.h"
#include "acus/scene/simulation/plan_json.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using simulation::Scene;

std::vector<std::string> ShownWarnings(const Run& run) {
  std::vector<std::string> warnings = run.warnings;
  for (std::string& warning : warnings) warning = ShownText(std::move(warning));
  return warnings;
}

void WriteRunJson(const fs::path& path, const scenario::Scenario& scenario, const Scene& scene,
                  const Run& run, const RunContext& context) {
  nlohmann::json document = {{"format", "acus-run/1"},
                             {"provenance", context.provenance.ToJson()},
                             {"scenario", config::ShownDocument(scenario.effective)},
                             {"session",
                              {{"name", run.session.name},
                               {"needle_samples", run.session.needle.size()},
                               {"probe_samples", run.session.probe.size()},
                               {"seconds", SpanSeconds(run.session)}}},
                             {"images", run.images.num_images},
                             {"effect_plan", simulation::PlanJson(scene.plan, run.times)},
                             {"events", EventsJson(EventsOf(scene, run.steps))},
                             {"warnings", ShownWarnings(run)}};
  if (run.cpu_s) {
    document["cpu_seconds"] = *run.cpu_s;
  } else {
    for (auto& stage : document["effect_plan"]) stage.erase("seconds");
  }
  for (const auto& [key, log] : run.effects) document[key + "_images"] = log.num_images;
  if (run.cost) document["cost_check"] = ToJson(*run.cost);
  config::WriteJson(path, document);
}

}  // namespace

double SpanSeconds(const session::Session& session) {
  double span_s = 0.0;
  for (const auto* stream : {&session.needle, &session.probe}) {
    if (stream->empty()) continue;
    span_s = std::max(span_s,
                      1e-9 * static_cast<double>(stream->back().time_ns - stream->front().time_ns));
  }
  return span_s;
}

void WriteRunFolder(const fs::path& folder, const scenario::Scenario& scenario, const Scene& scene,
                    const transforms::Landmarks& targets, const Run& run,
                    const RunContext& context) {
  WriteTargets(folder, targets);
  if (scene.plan.Writes(effects::ports::kForce)) {
    WriteForces(folder / "forces.csv", run.steps, scene);
    const std::vector<LoggedEvent> events = EventsOf(scene, run.steps);
    WriteEvents(folder / "events.csv", events);
    WriteEventMarkups(folder, events);
  }
  if (scene.plan.Writes(effects::ports::kProbeForce)) {
    WriteProbeForces(folder / "probe_forces.csv", run.steps, scene);
  }
  WriteListedEffects(folder, run.steps, scene);
  if (run.others) WriteRange(folder, *run.others, run.steps);
  WriteMetrics(folder / "metrics.json", run.metrics);
  if (run.assessment) {
    config::WriteJson(folder / "training.json", training::ToJson(*run.assessment));
  }
  WriteRunJson(folder / "run.json", scenario, scene, run, context);
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
  ReportContent content;
  content.title = scenario.name.empty() ? "Replay" : scenario.name;
  content.facts = {{"session", run.session.name},
                   {"length of the session", RoundedText(SpanSeconds(run.session), 3) + " s"},
                   {"needle samples", std::to_string(run.session.needle.size())},
                   {"probe samples", std::to_string(run.session.probe.size())},
                   {"images", std::to_string(run.images.num_images)}};
  if (run.cpu_s)
    content.facts.emplace_back("CPU time of the run", RoundedText(*run.cpu_s, 3) + " s");
  if (run.cost) {
    const auto facts = FactsOf(*run.cost);
    content.facts.insert(content.facts.end(), facts.begin(), facts.end());
  }
  content.warnings = ShownWarnings(run);
  content.metrics = run.metrics;
  content.assessment = run.assessment;
  content.others = run.others;
  const auto add = [&content](const ImageLog& log) {
    content.films.insert(content.films.end(), log.films.begin(), log.films.end());
    content.images.insert(content.images.end(), log.pngs.begin(), log.pngs.end());
  };
  add(run.images);
  for (const EffectImageLog& effect : run.effects) add(effect.log);
  content.times = run.times;
  WriteReport(folder, content, run.steps, scene, context.provenance);
}

}  // namespace acus::replay
