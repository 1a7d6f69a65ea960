#include "benchmarks/tradeoff_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/html_report.h"

namespace acus::benchmarks {
namespace {

constexpr const char* kHeader =
    "knob,value,model,error,error_unit,reference,step_us_median,step_us_p999,preparation_s,"
    "memory_mb,is_default,is_paper,unusable\n";

/// Commas would make new cells: texts of rows are ours, and keep their sense without.
std::string Cell(std::string text) {
  std::ranges::replace(text, ',', ';');
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::string Cell(double value) {
  return std::isfinite(value) ? NumberText(value) : std::string();
}

std::string TradeoffReportShown(double value, int digits) {
  return std::isfinite(value) ? RoundedText(value, digits) : "-";
}

std::vector<std::string> Knobs(const std::vector<Row>& rows) {
  std::vector<std::string> out;
  for (const Row& row : rows) {
    if (std::ranges::find(out, row.knob) == out.end()) out.push_back(row.knob);
  }
  return out;
}

const std::vector<std::string> kShownHeader = {
    "value", "error", "", "against", "step [us]", "p99.9 [us]", "prep. [s]", "memory [MB]", ""};

std::vector<std::vector<std::string>> ShownRows(const std::vector<Row>& rows,
                                                const std::string& knob) {
  std::vector<std::vector<std::string>> out;
  for (const Row& row : rows) {
    if (row.knob != knob) continue;
    std::string remark = row.is_default ? "default" : row.is_paper ? "paper" : "";
    if (!row.unusable.empty()) remark = "UNUSABLE: " + row.unusable;
    out.push_back(
        {row.value, TradeoffReportShown(row.error, 3), row.error_unit, row.reference,
         TradeoffReportShown(row.step_us_median, 3), TradeoffReportShown(row.step_us_p999, 3),
         TradeoffReportShown(row.preparation_s, 3), TradeoffReportShown(row.memory_mb, 3), remark});
  }
  return out;
}

/// Below this share of the largest an error is rounding: it would stretch the axis over many
/// decades in which nothing is. Tables have it.
constexpr double kShownShare = 1e-4;

double LargestError(const std::vector<Row>& rows, const std::string& unit) {
  double out = 0.0;
  for (const Row& row : rows) {
    if (row.error_unit == unit && row.unusable.empty()) out = std::max(out, row.error);
  }
  return out;
}

/// Error over a cost, both on logarithmic axes; what is 0 or unusable has no place there.
report::Plot ErrorOver(const std::vector<Row>& rows, const std::string& unit, double Row::*cost,
                       const std::string& cost_label) {
  report::Plot plot;
  plot.x_label = cost_label;
  plot.y_label = "error [" + unit + "]";
  plot.log_x = plot.log_y = true;
  plot.height_px = 360;
  const double largest = LargestError(rows, unit);
  report::Series ours{.name = "default", .style = report::Style::kPoints};
  report::Series papers{.name = "paper", .style = report::Style::kPoints};
  for (const std::string& knob : Knobs(rows)) {
    report::Series series{.name = knob};
    if (knob == "model" || knob == "element" || knob == "storage") {
      series.style = report::Style::kPoints;  // No order to join them in.
    }
    for (const Row& row : rows) {
      if (row.knob != knob || row.error_unit != unit || !row.unusable.empty()) continue;
      if (!(row.error > kShownShare * largest) || !(row.*cost > 0.0)) continue;
      series.x.push_back(row.*cost);
      series.y.push_back(row.error);
      if (row.is_default || row.is_paper) {
        report::Series& marked = row.is_default ? ours : papers;
        marked.x.push_back(row.*cost);
        marked.y.push_back(row.error);
      }
    }
    if (!series.x.empty()) plot.series.push_back(std::move(series));
  }
  for (report::Series* series : {&ours, &papers}) {
    if (!series->x.empty()) plot.series.push_back(std::move(*series));
  }
  return plot;
}

std::vector<report::Plot> PlotsOf(const std::vector<Row>& rows) {
  std::vector<std::string> units;
  for (const Row& row : rows) {
    if (std::ranges::find(units, row.error_unit) == units.end()) units.push_back(row.error_unit);
  }
  std::vector<report::Plot> out;
  for (const std::string& unit : units) {
    out.push_back(ErrorOver(rows, unit, &Row::step_us_median, "median CPU time of a step [us]"));
    out.back().title = "error against the time of a step";
    out.push_back(ErrorOver(rows, unit, &Row::preparation_s, "preparation [s of CPU]"));
    out.back().title = "error against preparation";
    out.push_back(ErrorOver(rows, unit, &Row::memory_mb, "memory that steps read [MB]"));
    out.back().title = "error against memory";
  }
  return out;
}

nlohmann::json ToJson(const Sweep& sweep, const std::vector<Row>& rows) {
  const auto known = [](double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
  };
  nlohmann::json out = {{"format", "acus-tradeoff/1"}, {"sweep", sweep.name}, {"rows", {}}};
  for (const Row& row : rows) {
    out["rows"].push_back({{"knob", row.knob},
                           {"value", row.value},
                           {"model", row.model},
                           {"error", known(row.error)},
                           {"error_unit", row.error_unit},
                           {"reference", row.reference},
                           {"step_us_median", known(row.step_us_median)},
                           {"step_us_p999", known(row.step_us_p999)},
                           {"preparation_s", known(row.preparation_s)},
                           {"memory_mb", known(row.memory_mb)},
                           {"is_default", row.is_default},
                           {"is_paper", row.is_paper},
                           {"unusable", row.unusable}});
  }
  return out;
}

void WriteHtml(const std::filesystem::path& path, const Sweep& sweep, const std::vector<Row>& rows,
               const std::vector<report::Plot>& plots, const RunContext& context) {
  report::HtmlReport html(std::string(sweep.title), "accuracy and its price");
  html.Paragraph(std::string(sweep.about));
  html.Paragraph(
      "Times are CPU time of one thread on the machine that made this page, so they compare "
      "settings, not machines. Error and time of a row come from the same run.");
  std::vector<std::string> warnings;
  for (const Row& row : rows) {
    if (!row.unusable.empty()) {
      warnings.push_back(row.knob + " " + row.value + " must not be used: " + row.unusable);
    }
  }
  html.Warnings(warnings);
  html.Section("Error against time");
  for (const report::Plot& plot : plots) {
    if (!plot.series.empty()) html.Plots(std::vector<report::Plot>{plot});
  }
  for (const std::string& knob : Knobs(rows)) {
    html.Section(knob);
    html.Table(kShownHeader, ShownRows(rows, knob));
  }
  html.SetProvenance(context.provenance.ToJson());
  html.Write(path);
}

}  // namespace

std::string CsvText(const std::vector<Row>& rows) {
  std::string out = kHeader;
  for (const Row& row : rows) {
    for (const std::string& cell :
         {Cell(row.knob), Cell(row.value), Cell(row.model), Cell(row.error), Cell(row.error_unit),
          Cell(row.reference), Cell(row.step_us_median), Cell(row.step_us_p999),
          Cell(row.preparation_s), Cell(row.memory_mb)}) {
      out += cell + ",";
    }
    out +=
        Message(row.is_default ? 1 : 0, ",", row.is_paper ? 1 : 0, ",", Cell(row.unusable), "\n");
  }
  return out;
}

std::string TableText(const std::vector<Row>& rows) {
  std::string out;
  for (const std::string& knob : Knobs(rows)) {
    out += knob + "\n" + TextTable(kShownHeader, ShownRows(rows, knob)) + "\n";
  }
  return out;
}

std::vector<Row> SweepToFolder(const Sweep& sweep, bool quick, const std::filesystem::path& folder,
                               const RunContext& context) {
  AtomicFolder out(folder, context.overwrite);  // First: minutes would be lost if it is in the way.
  std::vector<Row> rows = sweep.run(quick, context);
  const auto is_usable = [](const Row& row) { return row.unusable.empty(); };
  if (std::ranges::none_of(rows, is_usable)) {
    throw NoAnswerError(Message("no setting can be used, first: ", rows.front().unusable));
  }
  const std::vector<report::Plot> plots = PlotsOf(rows);
  WriteTextFile(out.path() / "tradeoff.csv", CsvText(rows));
  config::WriteJson(out.path() / "tradeoff.json", ToJson(sweep, rows));
  report::WriteSvg(out.path() / "tradeoff.svg", plots[0]);
  report::WriteSvg(out.path() / "tradeoff_preparation.svg", plots[1]);
  report::WriteSvg(out.path() / "tradeoff_memory.svg", plots[2]);
  WriteHtml(out.path() / "tradeoff.html", sweep, rows, plots, context);
  config::WriteJson(out.path() / "provenance.json", context.provenance.ToJson());
  out.Commit();
  return rows;
}

}  // namespace acus::benchmarks
