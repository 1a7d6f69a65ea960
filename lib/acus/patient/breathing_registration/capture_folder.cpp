#include "acus/patient/breathing_registration/capture_folder.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/math/statistics.h"
#include "acus/base/report/html_report.h"
#include "acus/data/image/png.h"

namespace acus::breathing_registration {
namespace {

namespace fs = std::filesystem;
using breathing::ModelError;

constexpr double kNearWallMm = 10.0;
constexpr float kWhiteBoundMm = 8.0F;    // In the map of the bound.
constexpr double kWorthSaying = 0.0005;  // Share of the tissue.

std::string Fixed(double value, int digits) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(digits) << value;
  return out.str();
}

std::string Text(const std::optional<ModelError>& error) {
  return error ? Fixed(error->mean_mm, 2) + " / " + Fixed(error->p95_mm, 2) : "-";
}

/// Errors of the registration at landmarks, by where they are. All phases but the deeper one.
struct LandmarkGroup {
  std::string name;
  std::vector<double> errors_mm;
  int kept = 0;  ///< How many keep to their bound.
};

std::vector<LandmarkGroup> Groups(const Capture& capture) {
  std::vector<LandmarkGroup> groups = {
      {.name = "all", .errors_mm = {}},
      {.name = "within 10 mm of the sliding wall", .errors_mm = {}},
      {.name = "farther from it", .errors_mm = {}},
      {.name = "lung", .errors_mm = {}},
      {.name = "liver", .errors_mm = {}}};
  const auto& points = capture.landmarks.points;
  for (const PhaseResult& phase : capture.phases) {
    if (phase.deeper || phase.landmark_error_mm.size() != points.size()) continue;
    for (std::size_t n = 0; n < points.size(); ++n) {
      const double error = phase.landmark_error_mm[n];
      const auto add = [&](LandmarkGroup& group) {
        group.errors_mm.push_back(error);
        group.kept += error <= phase.landmark_bound_mm[n] ? 1 : 0;
      };
      add(groups[0]);
      add(groups[points[n].wall_mm < kNearWallMm ? 1 : 2]);
      if (points[n].tissue == "lung") add(groups[3]);
      if (points[n].tissue == "liver") add(groups[4]);
    }
  }
  std::erase_if(groups, [](const LandmarkGroup& group) { return group.errors_mm.empty(); });
  return groups;
}

using Rows = std::vector<std::vector<std::string>>;

const std::vector<std::string> kLandmarkHeader = {"landmarks", "number",     "mean mm",
                                                  "95 % mm",   "largest mm", "in bound %"};

Rows LandmarkRows(const Capture& capture) {
  Rows rows;
  for (const LandmarkGroup& group : Groups(capture)) {
    rows.push_back({group.name, std::to_string(group.errors_mm.size()),
                    Fixed(math::Mean(group.errors_mm), 2),
                    Fixed(math::Quantile(group.errors_mm, 0.95), 2),
                    Fixed(std::ranges::max(group.errors_mm), 2),
                    Fixed(100.0 * group.kept / static_cast<double>(group.errors_mm.size()), 1)});
  }
  return rows;
}

const std::vector<std::string> kModelHeader = {"model", "in sample", "leave one out",
                                               "deeper breath", "at landmarks"};

Rows ModelRows(const Capture& capture) {
  Rows rows;
  for (const ModelRow& row : capture.models) {
    rows.push_back({std::string(breathing::NameOf(row.kind)), Text(row.in_sample),
                    Text(row.leave_one_out), Text(row.deeper), Text(row.landmarks)});
  }
  return rows;
}

const std::vector<std::string> kPhaseHeader = {
    "phase",     "cycle",        "level",       "largest mm", "difference before",
    "and after", "smallest det", "landmarks mm"};

Rows PhaseRows(const Capture& capture) {
  Rows rows;
  for (const PhaseResult& phase : capture.phases) {
    const auto& errors = phase.landmark_error_mm;
    rows.push_back({phase.file.name, Fixed(phase.file.breath.cycle, 2),
                    Fixed(phase.file.breath.level, 2), Fixed(phase.largest_mm, 1),
                    Fixed(phase.residual.before, 1), Fixed(phase.residual.after, 1),
                    phase.smallest_determinant ? Fixed(*phase.smallest_determinant, 2) : "-",
                    errors.empty() ? "-"
                                   : Fixed(math::Mean(errors), 2) + " / " +
                                         Fixed(math::Quantile(errors, 0.95), 2)});
  }
  return rows;
}

std::string CsvText(const std::vector<std::string>& header, const Rows& rows) {
  std::string text;
  const auto line = [&](const std::vector<std::string>& cells) {
    for (std::size_t n = 0; n < cells.size(); ++n) text += (n > 0 ? "," : "") + cells[n];
    text += "\n";
  };
  line(header);
  for (const auto& row : rows) line(row);
  return text;
}

void WriteTables(const fs::path& folder, const Capture& capture) {
  Rows phases;
  for (const PhaseResult& p : capture.phases) {
    const auto& errors = p.landmark_error_mm;
    phases.push_back({p.file.name, NumberText(p.file.breath.cycle), NumberText(p.file.breath.level),
                      NumberText(p.file.breath.level_per_s), NumberText(p.largest_mm),
                      NumberText(p.residual.before), NumberText(p.residual.after),
                      p.smallest_determinant ? NumberText(*p.smallest_determinant) : "",
                      errors.empty() ? "" : NumberText(math::Mean(errors))});
  }
  WriteTextFile(
      folder / "phases.csv",
      CsvText({"phase", "cycle", "level", "level_per_s", "largest_mm", "difference_before",
               "difference_after", "smallest_determinant", "landmark_mean_mm"},
              phases));
  Rows models;
  const auto cells = [](const std::optional<ModelError>& error, std::vector<std::string>& row) {
    row.push_back(error ? NumberText(error->mean_mm) : "");
    row.push_back(error ? NumberText(error->p95_mm) : "");
  };
  for (const ModelRow& m : capture.models) {
    std::vector<std::string> row = {std::string(breathing::NameOf(m.kind))};
    for (const auto& error : {std::optional(m.in_sample), m.leave_one_out, m.deeper, m.landmarks}) {
      cells(error, row);
    }
    models.push_back(std::move(row));
  }
  WriteTextFile(folder / "models.csv",
                CsvText({"model", "in_sample_mean_mm", "in_sample_p95_mm", "leave_one_out_mean_mm",
                         "leave_one_out_p95_mm", "deeper_mean_mm", "deeper_p95_mm",
                         "landmarks_mean_mm", "landmarks_p95_mm"},
                        models));
}

/// Error of the registration at each landmark, and the bound that it should keep.
void WriteLandmarkErrors(const fs::path& path, const Capture& capture) {
  Rows rows;
  const auto& points = capture.landmarks.points;
  for (const PhaseResult& phase : capture.phases) {
    if (phase.landmark_error_mm.size() != points.size()) continue;
    for (std::size_t n = 0; n < points.size(); ++n) {
      rows.push_back({phase.file.name, points[n].name, points[n].tissue,
                      NumberText(points[n].wall_mm), NumberText(phase.landmark_error_mm[n]),
                      NumberText(phase.landmark_bound_mm[n])});
    }
  }
  if (rows.empty()) return;
  WriteTextFile(path,
                CsvText({"phase", "name", "tissue", "wall_mm", "error_mm", "bound_mm"}, rows));
}

/// Before and after side by side, black where they are equal, three pixels for each.
void WriteDifference(const fs::path& path, const DifferenceImage& difference) {
  constexpr int kZoom = 3;
  constexpr float kWhite = 150.0F;
  image::GrayImage image;
  image.Resize(kZoom * (2 * difference.width + 2), kZoom * difference.height);
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const int x = column / kZoom;
      const bool left = x < difference.width;
      const int i = left ? x : x - difference.width - 2;
      float value = kWhite;
      if (i >= 0) {
        const std::size_t n =
            static_cast<std::size_t>(row / kZoom) * static_cast<std::size_t>(difference.width) +
            static_cast<std::size_t>(i);
        value = std::abs((left ? difference.before : difference.after)[n]);
      }
      image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                   static_cast<std::size_t>(column)] =
          static_cast<std::uint8_t>(255.0F * std::min(value / kWhite, 1.0F));
    }
  }
  image::WritePng(path, image);
}

/// White at kWhiteBoundMm, three pixels for each.
void WriteBoundMap(const fs::path& path, const BoundImage& bound) {
  constexpr int kZoom = 3;
  image::GrayImage image;
  image.Resize(kZoom * bound.width, kZoom * bound.height);
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const std::size_t n =
          static_cast<std::size_t>(row / kZoom) * static_cast<std::size_t>(bound.width) +
          static_cast<std::size_t>(column / kZoom);
      image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                   static_cast<std::size_t>(column)] =
          static_cast<std::uint8_t>(255.0F * std::min(bound.mm[n] / kWhiteBoundMm, 1.0F));
    }
  }
  image::WritePng(path, image);
}

std::string BoundText(const BoundSummary& bound) {
  std::string text =
      Message("Bound on the error that 95 of 100 places keep, at full inspiration: median ",
              Fixed(bound.median_mm, 1), " mm, 95 % of the tissue ", Fixed(bound.p95_mm, 1),
              " mm, largest ", Fixed(bound.largest_mm, 1), " mm.");
  if (bound.unseen_share > kWorthSaying) {
    text +=
        Message(" ", Fixed(100.0 * bound.unseen_share, 1),
                " % of the tissue has no match in the images there: it left the volume, or lies "
                "where other tissue came in over the border. Its motion is only extrapolated from "
                "the surroundings.");
  }
  if (bound.kept_share) {
    text += Message(" Landmarks where the model keeps to the bound: ",
                    Fixed(100.0 * *bound.kept_share, 1), " %.");
  }
  return text;
}

report::Plot LandmarkPlot(const Capture& capture) {
  report::Plot plot{.title = "Error at landmarks over the breath",
                    .x_label = "place in the breath",
                    .y_label = "error [mm]",
                    .y_from_zero = true};
  std::vector<std::pair<double, const PhaseResult*>> order;
  for (const PhaseResult& phase : capture.phases) {
    if (!phase.landmark_error_mm.empty() && !phase.deeper) {
      order.emplace_back(phase.file.breath.cycle, &phase);
    }
  }
  std::ranges::sort(order);
  report::Series mean{.name = "mean"}, p95{.name = "95 %"};
  for (const auto& [cycle, phase] : order) {
    mean.x.push_back(cycle);
    p95.x.push_back(cycle);
    mean.y.push_back(math::Mean(phase->landmark_error_mm));
    p95.y.push_back(math::Quantile(phase->landmark_error_mm, 0.95));
  }
  plot.series = {mean, p95};
  return plot;
}

report::Plot ModesPlot(const Capture& capture) {
  report::Plot plot{.title = "Principal components over time",
                    .x_label = "component",
                    .y_label = "share of variance",
                    .y_from_zero = true};
  report::Series bars{.name = "", .style = report::Style::kBars};
  for (std::size_t n = 0; n < capture.variance_of_modes.size(); ++n) {
    bars.x.push_back(static_cast<double>(n + 1));
    bars.y.push_back(capture.variance_of_modes[n]);
  }
  plot.series = {bars};
  return plot;
}

void WriteReport(const fs::path& folder, const Capture& capture, const RunContext& context) {
  report::HtmlReport html("How " + capture.motion.name + " breathes",
                          "Registered to " + capture.reference);
  html.Section("Models");
  html.Paragraph(
      "Mean / 95 % of the distance, in mm, between what a model says and the fields that it was "
      "made "
      "from: in all phases; in each phase by a model made without it; in a deeper breath; and, "
      "where "
      "landmarks are known, between where the model puts them and where they are.");
  html.Table(kModelHeader, ModelRows(capture));
  const report::Plot modes = ModesPlot(capture);
  html.Plots({&modes, 1}, "What filtering in time keeps of the fields");
  html.Section("Phases");
  html.Table(kPhaseHeader, PhaseRows(capture),
             "Differences are root mean squares over the tissue, in HU of soft tissue.");
  if (!Groups(capture).empty()) {
    html.Section("Landmarks");
    html.Table(kLandmarkHeader, LandmarkRows(capture), "Error of the registration");
    const report::Plot plot = LandmarkPlot(capture);
    html.Plots({&plot, 1});
  }
  if (capture.image.width > 0) {
    WriteDifference(folder / "difference.png", capture.image);
    html.Section("Before and after");
    html.Image(folder / "difference.png",
               "Two coronal slices: bright where phase and reference differ",
               "Difference of " + capture.shown +
                   " from the reference before (left) and after "
                   "registration (right); white is 150 HU");
  }
  if (capture.bound) {
    WriteBoundMap(folder / "bound.png", capture.bound_image);
    html.Section("How far it may be wrong");
    html.Paragraph(BoundText(*capture.bound));
    html.Image(folder / "bound.png", "A coronal slice: bright where the error may be large",
               "Bound on the error of registration in " + capture.bound_image.phase +
                   ", which 95 of 100 places keep; white is 8 mm and more");
  }
  html.SetProvenance(context.provenance.ToJson());
  html.Write(folder / "report.html");
}

}  // namespace

void WriteCapture(const fs::path& folder, const Capture& capture, const RunContext& context) {
  AtomicFolder out(folder, context.overwrite);
  breathing::WritePatientMotion(out.path(), capture.motion);
  WriteTables(out.path(), capture);
  WriteLandmarkErrors(out.path() / "landmark_errors.csv", capture);
  WriteReport(out.path(), capture, context);
  config::WriteJson(out.path() / "provenance.json", context.provenance.ToJson());
  out.Commit();
}

std::string CaptureText(const Capture& capture) {
  const auto table = [](const std::vector<std::string>& header, const Rows& rows) {
    std::ostringstream out;
    const auto line = [&](const std::vector<std::string>& cells) {
      for (std::size_t n = 0; n < cells.size(); ++n) {
        out << (n == 0 ? std::left : std::right) << std::setw(n == 0 ? 34 : 16) << cells[n];
      }
      out << "\n";
    };
    line(header);
    for (const auto& row : rows) line(row);
    return out.str();
  };
  std::string text = "errors in mm: mean / 95 %\n" + table(kModelHeader, ModelRows(capture));
  const Rows landmarks = LandmarkRows(capture);
  if (!landmarks.empty()) text += "\n" + table(kLandmarkHeader, landmarks);
  if (capture.bound) text += "\n" + BoundText(*capture.bound) + "\n";
  return text;
}

}  // namespace acus::breathing_registration
