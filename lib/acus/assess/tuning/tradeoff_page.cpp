#include "acus/assess/tuning/tradeoff_page.h"

#include <algorithm>

#include "acus/assess/tuning/result_files.h"
#include "acus/assess/tuning/savings.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/html_report.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;

std::string Milliseconds(double ms) {
  return ms > 0.0 ? RoundedText(ms, 4) + " ms" : std::string("none");
}

std::vector<std::pair<std::string, std::string>> Facts(const SweepResult& result) {
  return {{"scenario", result.scenario},
          {"scenario file", result.scenario_file.string()},
          {"session", result.session.string()},
          {"played", RoundedText(result.seconds, 4) + " s"},
          {"time between samples", Milliseconds(result.step_period_ms)},
          {"time between images", Milliseconds(result.image_period_ms)},
          {"machine", result.machine},
          {"runs of each setting", std::to_string(result.repetitions)}};
}

std::vector<std::string> Unusable(const SweepResult& result) {
  std::vector<std::string> warnings;
  for (const SettingResult& setting : result.settings) {
    if (setting.unusable.empty()) continue;
    warnings.push_back(TextOf(setting.setting) + " must not be used: " + setting.unusable);
  }
  return warnings;
}

const Knob* FindKnob(const SweepResult& result, const std::string& name) {
  const auto found = std::ranges::find(result.knobs, name, &Knob::name);
  return found == result.knobs.end() ? nullptr : &*found;
}

void AddPlots(const std::vector<report::Plot>& plots, report::HtmlReport& page) {
  for (const report::Plot& plot : plots) page.Plots(std::vector<report::Plot>{plot});
}

void AddSavings(const std::vector<Saving>& savings, const report::Plot& overview,
                report::HtmlReport& page) {
  if (savings.empty()) return;
  page.Section("What cheaper settings save and lose");
  if (!overview.series.empty()) page.Plots(std::vector<report::Plot>{overview});
  const SavingsTable losses = TableOf(savings, /*differences=*/false);
  const auto add = [&page](const SavingsTable& table, const char* caption) {
    if (!table.rows.empty()) page.Table(table.header, table.rows, caption);
  };
  add(losses,
      "Against the most expensive value of each parameter, \u00B1 95 % intervals; not "
      "distinguishable: the interval of the difference holds 0, run more --repetitions. "
      "What is noticed is a rule of thumb: 10 % of a force, one grey level of 255");
  const SavingsTable others = TableOf(savings, /*differences=*/true);
  add(others,
      "Other models and other speckle: differences between two images of the tissue, no "
      "errors. Which is closer to a real tissue these numbers do not say");
}

void AddKnob(const SweepResult& result, const PageContent& content, const KnobTable& table,
             report::HtmlReport& page) {
  page.Section(table.knob);
  if (const Knob* knob = FindKnob(result, table.knob)) {
    std::string text =
        "What it is: " + knob->title + ". It acts on: " + std::string(NameOf(knob->acts_on)) + ".";
    for (const PaperValue& paper : knob->papers) {
      text += " " + ValueText(paper.value) + ": " + paper.source + ".";
    }
    page.Paragraph(text);
  }
  page.Table(table.header, table.rows);
  const std::vector<Saving> savings = SavingsOf(result);
  const bool is_difference = std::ranges::any_of(savings, [&table](const Saving& saving) {
    return saving.is_difference && saving.setting->knob == table.knob;
  });
  if (is_difference) {
    page.Paragraph(
        "These give another image of the tissue: PSNR and SSIM compare two images, and are no "
        "accuracy.");
    return;
  }
  PlotRemarks remarks = content.plots;
  remarks.knob = table.knob;
  AddPlots(TradeoffPlots(result, remarks), page);
}

}  // namespace

void WritePage(const fs::path& folder, const SweepResult& result, const PageContent& content,
               const RunContext& context) {
  report::HtmlReport page("What accuracy costs: " + result.scenario,
                          "error and time of each setting, from the same run");
  page.Warnings(Unusable(result));
  if (!content.answer.empty()) {
    page.Section("Answer");
    for (const std::string& line : content.answer) page.Paragraph(line);
  }
  const std::vector<Saving> savings = SavingsOf(result);
  const report::Plot overview = SavingsPlot(savings);
  AddSavings(savings, overview, page);
  page.Section("What was measured");
  page.KeyValues(Facts(result));
  page.Paragraph(
      "Times are CPU time of one thread on the machine named. Values are means over the runs of a "
      "setting, \u00B1 and bars their 95 % confidence intervals. Errors are against the setting "
      "marked as the reference, in the same session with the same seed; those of the reference, "
      "which are zero, have no place on a logarithmic axis.");
  for (const std::string& line : content.remarks) page.Paragraph(line);
  // Settings that have one reference are one cloud; those of many knobs are shown knob by knob.
  std::vector<report::Plot> plots;
  if (result.jointly || content.plots.goal) plots = TradeoffPlots(result, content.plots);
  if (!plots.empty()) page.Section("Error against time");
  AddPlots(plots, page);
  const std::vector<KnobTable> tables = TablesOf(result);
  for (const KnobTable& table : tables) AddKnob(result, content, table, page);
  page.SetProvenance(context.provenance.ToJson());
  page.Write(folder / "tradeoff.html");
  if (!overview.series.empty()) report::WriteSvg(folder / "savings.svg", overview);
  for (const report::Plot& plot : plots) {
    const bool force = plot.title.starts_with("force");
    const char* name = force ? "force.svg" : plot.log_y ? "ssim.svg" : "psnr.svg";
    report::WriteSvg(folder / name, plot);
  }
}

}  // namespace acus::tuning
