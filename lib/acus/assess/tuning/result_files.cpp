#include "acus/assess/tuning/result_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::tuning {
namespace {

using nlohmann::json;

struct Column {
  const char* name;
  Estimate SettingResult::*value;
};
constexpr Column kColumns[] = {
    {"step_us_median", &SettingResult::step_us_median},
    {"step_us_p999", &SettingResult::step_us_p999},
    {"image_ms_median", &SettingResult::image_ms_median},
    {"image_ms_p95", &SettingResult::image_ms_p95},
    {"preparation_s", &SettingResult::preparation_s},
    {"memory_mb", &SettingResult::memory_mb},
    {"force_felt_n", &SettingResult::force_felt_n},
    {"force_rms_n", &SettingResult::force_rms_n},
    {"force_largest_n", &SettingResult::force_largest_n},
    {"image_rms_grey", &SettingResult::image_rms_grey},
    {"image_psnr_db", &SettingResult::image_psnr_db},
    {"image_ssim", &SettingResult::image_ssim},
    {"step_us_over_scenario", &SettingResult::step_us_over_scenario},
    {"image_ms_over_scenario", &SettingResult::image_ms_over_scenario},
    {"force_rms_over_scenario_n", &SettingResult::force_rms_over_scenario_n}};

std::string Cell(double value) {
  return std::isfinite(value) ? NumberText(value) : std::string();
}

/// CSV has no quoting here.
std::string WithoutCommas(std::string text) {
  std::ranges::replace(text, ',', ';');
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::string Marks(const SettingResult& setting) {
  if (!setting.unusable.empty()) return "UNUSABLE: " + setting.unusable;
  std::string marks;
  const auto add = [&marks](bool is, const std::string& word) {
    if (is) marks += (marks.empty() ? "" : ", ") + word;
  };
  add(setting.is_scenario, "scenario");
  add(setting.is_default, "default");
  add(setting.is_paper, setting.paper);
  add(setting.is_reference, "reference");
  return marks;
}

json JsonOf(const Estimate& estimate) {
  if (std::isnan(estimate.mean)) return nullptr;
  if (std::isinf(estimate.mean)) return "infinite";
  json out = {{"mean", estimate.mean}, {"runs", estimate.count}};
  out["ci95"] = std::isfinite(estimate.half_width) ? json(estimate.half_width) : json();
  return out;
}

json JsonOf(const Knob& knob) {
  json papers = json::array();
  for (const PaperValue& paper : knob.papers) {
    papers.push_back({{"value", paper.value}, {"source", paper.source}});
  }
  return {{"knob", knob.name},
          {"title", knob.title},
          {"unit", knob.unit},
          {"pointers", knob.pointers},
          {"levels", knob.values},
          {"acts_on", NameOf(knob.acts_on)},
          {"papers", papers},
          {"default", knob.default_value},
          {"scenario", knob.scenario_value}};
}

json JsonOf(const SettingResult& setting) {
  json out = {{"knob", setting.knob},
              {"setting", setting.setting},
              {"is_scenario", setting.is_scenario},
              {"is_default", setting.is_default},
              {"is_paper", setting.is_paper},
              {"paper", setting.paper},
              {"is_reference", setting.is_reference},
              {"unusable", setting.unusable}};
  for (const Column& column : kColumns) out[column.name] = JsonOf(setting.*column.value);
  return out;
}

bool Any(const std::vector<const SettingResult*>& settings, Estimate SettingResult::*value) {
  return std::ranges::any_of(
      settings, [value](const SettingResult* s) { return !std::isnan((s->*value).mean); });
}

std::string WithInterval(const Estimate& estimate) {
  if (std::isnan(estimate.mean)) return "-";
  if (std::isinf(estimate.mean)) return "same";
  std::string text = RoundedText(estimate.mean, 3);
  if (std::isfinite(estimate.half_width) && estimate.half_width > 0.0) {
    text += " +-" + RoundedText(estimate.half_width, 2);
  }
  return text;
}

KnobTable TableOf(const std::vector<const SettingResult*>& settings) {
  constexpr Column kShown[] = {
      {"step us", &SettingResult::step_us_median},   {"p99.9", &SettingResult::step_us_p999},
      {"image ms", &SettingResult::image_ms_median}, {"p95", &SettingResult::image_ms_p95},
      {"load s", &SettingResult::preparation_s},     {"MB", &SettingResult::memory_mb},
      {"force N rms", &SettingResult::force_rms_n},  {"largest", &SettingResult::force_largest_n},
      {"PSNR dB", &SettingResult::image_psnr_db},    {"SSIM", &SettingResult::image_ssim}};
  std::vector<std::string> header = {settings.front()->knob};
  for (const Column& column : kShown) {
    if (Any(settings, column.value)) header.emplace_back(column.name);
  }
  header.emplace_back("");
  std::vector<std::vector<std::string>> rows;
  for (const SettingResult* setting : settings) {
    const bool one = setting->setting.size() == 1;
    std::vector<std::string> row = {one ? ValueText(setting->setting.begin()->second)
                                        : TextOf(setting->setting)};
    for (const Column& column : kShown) {
      if (Any(settings, column.value)) row.push_back(WithInterval(setting->*column.value));
    }
    row.push_back(Marks(*setting));
    rows.push_back(std::move(row));
  }
  return {settings.front()->knob, std::move(header), std::move(rows)};
}

/// Settings by knob, in their order.
std::vector<std::vector<const SettingResult*>> ByKnob(const SweepResult& result) {
  std::vector<std::vector<const SettingResult*>> groups;
  for (const SettingResult& setting : result.settings) {
    if (groups.empty() || groups.back().front()->knob != setting.knob) groups.emplace_back();
    groups.back().push_back(&setting);
  }
  return groups;
}

/// "step 4.1 us instead of 13.5 us"; "as before" if the intervals of both overlap.
std::string Instead(const char* what, const Estimate& now, const Estimate& before,
                    const char* unit) {
  const auto with_unit = [unit](double value) { return RoundedText(value, 3) + " " + unit; };
  const double noise = std::hypot(std::isfinite(now.half_width) ? now.half_width : 0.0,
                                  std::isfinite(before.half_width) ? before.half_width : 0.0);
  if (now.count > 1 && std::abs(now.mean - before.mean) <= noise) {
    return Message(what, " ", with_unit(now.mean), ", the same within the noise");
  }
  return Message(what, " ", with_unit(now.mean), " instead of ", with_unit(before.mean));
}

std::string SentenceOf(const SettingResult& now, const SettingResult& reference) {
  const bool one = now.setting.size() == 1;
  std::string text =
      one ? Message(now.knob, " ", ValueText(now.setting.begin()->second), " instead of ",
                    ValueText(reference.setting.begin()->second), ": ")
          : Message(TextOf(now.setting), " instead of the most expensive setting: ");
  if (!now.unusable.empty()) return text + "must not be used, " + now.unusable + ".\n";
  std::vector<std::string> parts;
  if (now.force_rms_n.count > 0) {
    const bool felt = std::max(now.force_felt_n.mean, reference.force_felt_n.mean) >= 1e-3;
    parts.push_back(!felt ? std::string("nothing was felt in these seconds")
                    : now.force_largest_n.mean == 0.0
                        ? std::string("the same forces")
                        : Message("force ", RoundedText(now.force_rms_n.mean, 2),
                                  " N RMS more error (", RoundedText(now.force_largest_n.mean, 2),
                                  " N at most)"));
    parts.push_back(Instead("step", now.step_us_median, reference.step_us_median, "us"));
  }
  if (now.image_rms_grey.count > 0) {
    parts.push_back(now.image_rms_grey.mean == 0.0
                        ? std::string("the same images")
                        : Message("images at ", RoundedText(now.image_psnr_db.mean, 3),
                                  " dB PSNR, SSIM ", RoundedText(now.image_ssim.mean, 3)));
    parts.push_back(Instead("image", now.image_ms_median, reference.image_ms_median, "ms"));
  }
  for (std::size_t i = 0; i < parts.size(); ++i) text += (i == 0 ? "" : "; ") + parts[i];
  return text + ".\n";
}

}  // namespace

std::string CsvText(const SweepResult& result) {
  std::string text = "knob,setting,repetitions,is_scenario,is_default,is_paper,is_reference";
  for (const Column& column : kColumns)
    text += Message(",", column.name, ",", column.name, "_ci95");
  text += ",unusable\n";
  for (const SettingResult& s : result.settings) {
    text += Message(s.knob, ",", WithoutCommas(TextOf(s.setting)), ",", result.repetitions, ",",
                    int{s.is_scenario}, ",", int{s.is_default}, ",", int{s.is_paper}, ",",
                    int{s.is_reference});
    for (const Column& column : kColumns) {
      const Estimate& estimate = s.*column.value;
      text += Message(",", Cell(estimate.mean), ",", Cell(estimate.half_width));
    }
    text += "," + WithoutCommas(s.unusable) + "\n";
  }
  return text;
}

json ToJson(const SweepResult& result) {
  json knobs = json::array();
  for (const Knob& knob : result.knobs) knobs.push_back(JsonOf(knob));
  json settings = json::array();
  for (const SettingResult& setting : result.settings) settings.push_back(JsonOf(setting));
  json runs = json::array();
  for (const Measured& run : result.runs) runs.push_back(ToJson(run));
  return {{"format", "acus-tradeoff-scene/1"},
          {"scenario", result.scenario},
          {"scenario_file", result.scenario_file.string()},
          {"session", result.session.string()},
          {"seconds", result.seconds},
          {"step_period_ms", result.step_period_ms},
          {"image_period_ms", result.image_period_ms},
          {"machine", result.machine},
          {"jointly", result.jointly},
          {"is_subset", result.is_subset},
          {"repetitions", result.repetitions},
          {"knobs", knobs},
          {"settings", settings},
          {"runs", runs}};
}

std::vector<KnobTable> TablesOf(const SweepResult& result) {
  std::vector<KnobTable> tables;
  for (const auto& settings : ByKnob(result)) tables.push_back(TableOf(settings));
  return tables;
}

std::string TableText(const SweepResult& result) {
  std::string text;
  for (const KnobTable& table : TablesOf(result)) {
    text += TextTable(table.header, table.rows) + "\n";
  }
  return text;
}

std::string Sentences(const SweepResult& result) {
  std::string text;
  for (const auto& settings : ByKnob(result)) {
    const auto reference = std::ranges::find_if(settings, &SettingResult::is_reference);
    ACUS_ASSERT(reference != settings.end());
    auto now = std::ranges::find_if(settings, &SettingResult::is_scenario);
    if (settings.size() == 2 || now == settings.end() || now == reference) now = settings.begin();
    text += SentenceOf(**now, **reference);
  }
  return text;
}

std::string LeftOutText(const SweepPlan& plan) {
  std::string text;
  for (const LeftOut& left : plan.left_out) {
    text += Message("Omitted: ", left.knob, "=", left.value, ": ", left.why, "\n");
  }
  if (plan.is_subset) {
    text += Message("Of ", plan.combinations, " combinations, ", plan.request.most_combinations,
                    " are run: every value as often as any other, seed ", plan.request.seed, ".\n");
  }
  return text;
}

void WriteResult(const std::filesystem::path& folder, const SweepResult& result,
                 const RunContext& context) {
  WriteTextFile(folder / "tradeoff.csv", CsvText(result));
  config::WriteJson(folder / "tradeoff.json", ToJson(result));
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

}  // namespace acus::tuning
