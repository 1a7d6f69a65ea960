#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/assess/regression/comparison/run_comparison.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/html_report.h"
#include "acus/data/image/png.h"

namespace acus::comparison {
namespace {

constexpr std::size_t kMostForcePlots = 8;
constexpr double kIdenticalPsnrDb = 100.0;  ///< The position of identical frames in the plot.

report::Series LineOf(std::string name, const std::vector<double>& x, std::vector<double> y) {
  report::Series series{.name = std::move(name)};
  series.x = x;
  series.y = std::move(y);
  return series;
}

/// Both runs above their difference.
std::vector<report::Plot> ForcePlots(const ForcePair& pair, const std::vector<double>& time_s) {
  std::vector<double> difference_n(time_s.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) difference_n[i] = pair.b_n[i] - pair.a_n[i];
  report::Plot both;
  both.title = pair.column;
  both.y_label = "force [N]";
  both.height_px = 200;
  both.series = {LineOf("A", time_s, pair.a_n), LineOf("B", time_s, pair.b_n)};
  report::Plot difference;
  difference.y_label = "B \u2212 A [N]";
  difference.x_label = "time [s]";
  difference.height_px = 100;
  difference.series = {LineOf("", time_s, std::move(difference_n))};
  return {both, difference};
}

std::vector<report::Plot> ImagePlots(const std::vector<FrameDifference>& frames) {
  std::vector<double> time_s;
  std::vector<double> psnr_db;
  std::vector<double> ssim;
  for (const FrameDifference& frame : frames) {
    time_s.push_back(frame.time_s);
    psnr_db.push_back(std::min(frame.psnr_db.value_or(kIdenticalPsnrDb), kIdenticalPsnrDb));
    ssim.push_back(frame.ssim);
  }
  report::Plot psnr_plot;
  psnr_plot.y_label = "PSNR [dB]";
  psnr_plot.height_px = 140;
  psnr_plot.series = {LineOf("", time_s, psnr_db)};
  report::Plot ssim_plot;
  ssim_plot.y_label = "SSIM";
  ssim_plot.x_label = "time [s]";
  ssim_plot.height_px = 140;
  ssim_plot.series = {LineOf("", time_s, ssim)};
  return {psnr_plot, ssim_plot};
}

std::string Number(const std::optional<double>& value) {
  return value ? RoundedText(*value, 5) : "-";
}

void AddChecks(const std::string& heading, const std::vector<Check>& checks,
               report::HtmlReport& html) {
  std::vector<std::vector<std::string>> rows;
  for (const Check& check : checks) {
    const std::string relation = check.at_least ? "\u2265 " : "\u2264 ";
    rows.push_back({check.passed ? "ok" : "FAIL", check.quantity, Number(check.value),
                    check.limit ? relation + Number(check.limit) : "same", check.unit,
                    check.remark});
  }
  html.Section(heading);
  html.Table({"", "quantity", "value", "limit", "unit", "A | B"}, rows);
}

void AddOnlyInOne(const RunComparison& comparison, report::HtmlReport& html) {
  std::vector<std::vector<std::string>> rows;
  for (const Check& check : comparison.only_in_one) rows.push_back({check.quantity, check.remark});
  html.Section("Not compared");
  html.Table({"quantity", "where"}, rows);
}

void AddForces(const ForceComparison& forces, report::HtmlReport& html) {
  std::vector<const ForcePair*> shown;
  for (const ForcePair& pair : forces.forces) {
    // Columns that are zero in both runs are omitted.
    const auto is_zero = [](double value) { return value == 0.0; };
    if (std::ranges::all_of(pair.a_n, is_zero) && std::ranges::all_of(pair.b_n, is_zero)) continue;
    if (shown.size() < kMostForcePlots) shown.push_back(&pair);
  }
  if (shown.empty()) return;
  html.Section("Forces");
  for (const ForcePair* pair : shown) html.Plots(ForcePlots(*pair, forces.time_s));
}

void AddImages(const RunComparison& comparison, const std::filesystem::path& folder,
               const RunContext& context, report::HtmlReport& html) {
  const ImageComparison& images = comparison.images;
  if (!images.worst) return;
  const SideBySide shown = ShowFrame(comparison.run_a / "images.igs.mha",
                                     comparison.run_b / "images.igs.mha", *images.worst);
  image::GrayImage image;
  image.width = shown.width;
  image.height = shown.height;
  image.pixels = shown.pixels;
  const auto png = folder / "worst_frame.png";
  image::WritePng(png, image, context.provenance.OneLine());
  html.Section("Images");
  html.Paragraph(
      Message(images.num_identical, " of ", images.frames.size(), " frames are identical."));
  html.Plots(ImagePlots(images.frames), "Frame by frame; identical frames stand at 100 dB and 1.");
  const FrameDifference& worst = images.frames[*images.worst];
  html.Image(png, "The frame that differs most: run A, run B and their difference",
             Message("Frame ", *images.worst, " at ", FixedText(worst.time_s, 3), " s, SSIM ",
                     FixedText(worst.ssim, 4), ": A | B | difference (white is ",
                     shown.largest_difference, " grey levels)."));
}

}  // namespace

void WriteComparison(const std::filesystem::path& folder, const RunComparison& comparison,
                     const RunContext& context) {
  nlohmann::json document = ToJson(comparison);
  document["provenance"] = context.provenance.ToJson();
  config::WriteJson(folder / "comparison.json", document);
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
  report::HtmlReport html(
      comparison.passed() ? "The runs agree" : "The runs differ",
      comparison.run_a.string() + " (A) and " + comparison.run_b.string() + " (B)");
  std::vector<Check> failed;
  for (const Check& check : comparison.checks) {
    if (!check.passed) failed.push_back(check);
  }
  html.Paragraph(Message(comparison.checks.size() - failed.size(), " of ", comparison.checks.size(),
                         " checks passed."));
  if (!failed.empty()) AddChecks("What differs", failed, html);
  if (!comparison.only_in_one.empty()) AddOnlyInOne(comparison, html);
  AddImages(comparison, folder, context, html);
  AddForces(comparison.forces, html);
  AddChecks("All checks", comparison.checks, html);
  html.SetProvenance(context.provenance.ToJson());
  html.Write(folder / "comparison.html");
}

}  // namespace acus::comparison
