#include "acus/patient/fitting/fit_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/forces/laws/force_table.h"

namespace acus::fitting {
namespace {

using nlohmann::json;

json RangeJson(const ForceCurve& curve, const SampleRange& range) {
  if (range.size() == 0) return nullptr;
  return {{"from_s", curve.time_s[range.begin]}, {"to_s", curve.time_s[range.end - 1]}};
}

std::string Padded(const std::string& text, std::size_t width) {
  return text.size() >= width ? text : text + std::string(width - text.size(), ' ');
}

std::string Cell(const std::optional<Estimate>& estimate, int digits) {
  if (!estimate) return Padded("-", 19);
  char text[64];
  std::snprintf(text, sizeof text, "%.*f +- %.*f", digits, estimate->value, digits,
                0.5 * (estimate->high - estimate->low));
  return Padded(text, 19);
}

double MedianOf(std::span<const PunctureCurveFit> fits,
                std::optional<Estimate> PunctureCurveFit::*member, const char* name) {
  std::vector<double> values;
  for (const PunctureCurveFit& fit : fits) {
    if (fit.*member) values.push_back((fit.*member)->value);
  }
  if (values.empty()) {
    throw NoAnswerError(
        Message("no recording determines the ", name, " that a row of a force table needs"));
  }
  return math::Median(values);
}

/// The capsule's polynomial and puncture force in `row`: medians of the recordings in which the
/// needle comes in from outside. Without one they stay what they were: punctures of structures
/// inside are something else.
void AddCapsule(std::span<const PunctureCurveFit> fits, double ratio, const json& before,
                json& row) {
  std::vector<PunctureCurveFit> entries;
  std::ranges::copy_if(fits, std::back_inserter(entries),
                       [](const PunctureCurveFit& fit) { return fit.converged && fit.is_entry; });
  std::string source = row.at("source");
  if (entries.empty()) {
    for (const char* key : {"a1_n_per_mm", "a2_n_per_mm2", "puncture_n"}) {
      if (before.contains(key)) row[key] = before[key];
    }
    row["source"] = source +
                    "; a1, a2 and puncture_n are not from them: the needle is in the "
                    "tissue from the start, and what it punctures is inside";
    return;
  }
  row["a1_n_per_mm"] = ratio * MedianOf(entries, &PunctureCurveFit::a1_n_per_mm, "a1");
  row["a2_n_per_mm2"] = ratio * MedianOf(entries, &PunctureCurveFit::a2_n_per_mm2, "a2");
  row["puncture_n"] = ratio * MedianOf(entries, &PunctureCurveFit::puncture_n, "puncture force");
  row["source"] = Message(source, "; entries of ", entries.size());
}

/// What remains of the plateau's force when the friction of the buried shaft is taken off.
double MedianCuttingN(std::span<const PunctureCurveFit> fits, double friction_n_per_mm) {
  std::vector<double> values;
  for (const PunctureCurveFit& fit : fits) {
    if (!fit.converged || !fit.plateau_n) continue;
    const double buried_mm =
        fit.puncture_depth_mm->value + (fit.starts_in_tissue ? fit.contact_depth_mm->value : 0.0);
    values.push_back(fit.plateau_n->value - friction_n_per_mm * buried_mm);
  }
  if (values.empty()) throw NoAnswerError("no recording has a plateau behind a fitted puncture");
  return std::max(0.0, math::Median(values));
}

}  // namespace

json FitJson(const ForceCurve& curve, const PunctureCurveFit& fit) {
  json parameters = json::object();
  const auto estimates = fit.Estimates();
  for (const auto& [name, estimate] : estimates) {
    const Estimate joint = estimate.AmongSeveral(static_cast<int>(estimates.size()));
    parameters[name] = {{"value", estimate.value},   {"standard_error", estimate.standard_error},
                        {"low_95", estimate.low},    {"high_95", estimate.high},
                        {"joint_low_95", joint.low}, {"joint_high_95", joint.high}};
  }
  json punctures = json::array();
  for (std::size_t i = 0; i < fit.phases.punctures.size(); ++i) {
    const PunctureEvent& event = fit.phases.punctures[i];
    punctures.push_back({{"time_s", curve.time_s[event.peak]},
                         {"depth_mm", curve.depth_mm[event.peak]},
                         {"force_n", fit.phases.smooth_n[event.peak]},
                         {"drop_n", event.drop_n},
                         {"sharp", event.sharp},
                         {"fitted", i == fit.main}});
  }
  return {{"name", fit.name},
          {"converged", fit.converged},
          {"message", fit.message},
          {"starts_in_tissue", fit.starts_in_tissue},
          {"puncture_is_entry", fit.converged && fit.is_entry},
          {"parameters", parameters},
          {"noise_n", fit.phases.noise_n},
          {"rms_n",
           {{"rise", fit.rise_rms_n},
            {"plateau", fit.plateau_rms_n},
            {"friction", fit.friction_rms_n},
            {"relaxation", fit.relaxation_rms_n}}},
          {"phases",
           {{"rest", RangeJson(curve, fit.phases.rest)},
            {"advance", RangeJson(curve, fit.phases.advance)},
            {"hold", RangeJson(curve, fit.phases.hold)},
            {"retract", RangeJson(curve, fit.phases.retract)}}},
          {"advance_mm_per_s", fit.phases.advance_mm_per_s},
          {"punctures", punctures}};
}

json SummaryJson(std::span<const PunctureCurveFit> fits) {
  std::map<std::string, std::vector<double>> values;
  for (const PunctureCurveFit& fit : fits) {
    for (const auto& [name, estimate] : fit.Estimates()) values[name].push_back(estimate.value);
  }
  json summary = json::object();
  for (const auto& [name, column] : values) {
    summary[name] = {{"median", math::Median(column)},
                     {"quartile_1", math::Quantile(column, 0.25)},
                     {"quartile_3", math::Quantile(column, 0.75)},
                     {"count", column.size()},
                     {"of", fits.size()}};
  }
  return summary;
}

std::string FitTable(std::span<const PunctureCurveFit> fits) {
  std::size_t width = 6;
  for (const PunctureCurveFit& fit : fits) width = std::max(width, fit.name.size() + 2);
  std::string text = Padded("curve", width);
  for (const char* head : {"puncture [N]", "at [mm]", "a1 [N/mm]", "a2 [N/mm^2]", "plateau [N]",
                           "slope [N/mm]", "friction [N/mm]"}) {
    text += Padded(head, 19);
  }
  text += "rms [N]\n";
  for (const PunctureCurveFit& fit : fits) {
    text += Padded(fit.name, width);
    if (!fit.converged) {
      text += "no answer: " + fit.message + "\n";
      continue;
    }
    text += Cell(fit.puncture_n, 3) + Cell(fit.puncture_depth_mm, 2) + Cell(fit.a1_n_per_mm, 4) +
            Cell(fit.a2_n_per_mm2, 4) + Cell(fit.plateau_n, 3) +
            Cell(fit.plateau_slope_n_per_mm, 4) + Cell(fit.friction_n_per_mm, 4);
    char rms[32];
    std::snprintf(rms, sizeof rms, "%.3f\n", fit.rise_rms_n);
    text += rms;
  }
  return text + "+- is half of the 95 % interval; rms is that of the rise before the puncture.\n";
}

json TableWithFittedTissue(json base, const std::string& tissue,
                           std::span<const PunctureCurveFit> fits, const json& relaxation,
                           double measured_diameter_mm) {
  const double ratio = base.value("reference_diameter_mm", 1.27) / measured_diameter_mm;
  const double out_n_per_mm = MedianOf(fits, &PunctureCurveFit::friction_n_per_mm, "friction");
  // Behind the puncture the force grows with the buried shaft: its slope is the friction of the
  // insertion. One that falls is something else (a layer that ends); then there is only the
  // withdrawal.
  const double slope_n_per_mm =
      MedianOf(fits, &PunctureCurveFit::plateau_slope_n_per_mm, "slope of the plateau");
  const double in_n_per_mm = slope_n_per_mm > 0.0 ? slope_n_per_mm : out_n_per_mm;
  json row = {{"tissue", tissue},
              {"cutting_n", ratio * MedianCuttingN(fits, in_n_per_mm)},
              {"friction_n_per_mm", ratio * in_n_per_mm},
              {"withdrawal_friction_n_per_mm", ratio * std::max(0.0, out_n_per_mm)},
              {"relaxation", relaxation}};
  row["source"] = Message("acus-fit: medians of ", fits.size(), " recordings, needle of ",
                          measured_diameter_mm, " mm");
  json& rows = base.at("tissues");
  const auto known = std::ranges::find_if(
      rows, [&](const json& other) { return other.value("tissue", "") == tissue; });
  AddCapsule(fits, ratio, known == rows.end() ? json::object() : *known, row);
  if (known == rows.end()) {
    rows.push_back(row);
  } else {
    for (const char* key : {"no_membrane_from", "friction_rate", "friction_dwell"}) {
      if (known->contains(key)) row[key] = (*known)[key];
    }
    *known = row;
  }
  try {
    forces::ForceTableFromJson(base, "the fitted table");
  } catch (const InputError& error) {
    throw NoAnswerError(error.what());
  }
  return base;
}

}  // namespace acus::fitting
