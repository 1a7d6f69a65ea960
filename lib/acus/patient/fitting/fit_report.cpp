#include "acus/patient/fitting/fit_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
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

double ValueOf(const Estimate& estimate) {
  return estimate.value;
}
double ValueOf(double value) {
  return value;
}

template <typename T>
double MedianOf(std::span<const PunctureCurveFit> fits, std::optional<T> PunctureCurveFit::*member,
                const char* name) {
  std::vector<double> values;
  for (const PunctureCurveFit& fit : fits) {
    if (fit.*member) values.push_back(ValueOf(*(fit.*member)));
  }
  if (values.empty()) {
    throw NoAnswerError(
        Message("no recording determines the ", name, " that a row of a force table needs"));
  }
  return math::Median(values);
}

/// The membrane's polynomial and puncture force in `row`: medians of the recordings in which the
/// needle comes in from outside. Without one, of the largest puncture inside each recording: the
/// capsule of another table would belong to another tissue.
void AddMembrane(std::span<const PunctureCurveFit> fits, double ratio, json& row) {
  std::vector<PunctureCurveFit> entries, inside;
  for (const PunctureCurveFit& fit : fits) {
    if (fit.converged) (fit.is_entry ? entries : inside).push_back(fit);
  }
  const std::vector<PunctureCurveFit>& from = entries.empty() ? inside : entries;
  row["a1_n_per_mm"] = ratio * MedianOf<Estimate>(from, &PunctureCurveFit::a1_n_per_mm, "a1");
  row["a2_n_per_mm2"] = ratio * MedianOf<Estimate>(from, &PunctureCurveFit::a2_n_per_mm2, "a2");
  row["puncture_n"] =
      ratio * MedianOf<Estimate>(from, &PunctureCurveFit::puncture_n, "puncture force");
  const std::string source = row.at("source");
  row["source"] =
      entries.empty()
          ? Message(source, "; a1, a2 and puncture_n: largest puncture inside each of ",
                    inside.size(), ", as no needle comes in from outside (no capsule is measured)")
          : Message(source, "; entries of ", entries.size());
}

/// Force at the tip and along the shaft of a needle that is pushed in, of the reference needle.
struct InsertionForce {
  double cutting_n = 0.0;
  double friction_n_per_mm = 0.0;
};

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

/// Mean of two slopes: of the line of the advance, and from its begin to the force with which the
/// hold begins. The one describes the way, the other what a hold relaxes from.
double MedianSlopeOf(std::span<const PunctureCurveFit> fits) {
  std::vector<double> slopes;
  for (const PunctureCurveFit& fit : fits) {
    if (!fit.advance_slope_n_per_mm) continue;
    const double line = fit.advance_slope_n_per_mm->value;
    const bool has_hold = fit.hold_begin_n && fit.advance_travel_mm > 0.0;
    const double to_hold =
        has_hold ? (*fit.hold_begin_n - *fit.advance_tip_n) / fit.advance_travel_mm : line;
    slopes.push_back(0.5 * (line + to_hold));
  }
  return math::Median(slopes);
}

/// A needle that is in the tissue from the start: the line of the whole advance. Otherwise the
/// force behind the puncture, which grows with the buried shaft. One that falls is something else
/// (a layer that ends); then there is only the withdrawal.
InsertionForce InsertionOf(std::span<const PunctureCurveFit> fits, double out_n_per_mm) {
  const auto inside = std::ranges::count_if(
      fits, [](const PunctureCurveFit& fit) { return fit.advance_tip_n.has_value(); });
  if (2 * inside > std::ssize(fits)) {
    const double tip_n = MedianOf(fits, &PunctureCurveFit::advance_tip_n, "force at the tip");
    const double slope_n_per_mm = MedianSlopeOf(fits);
    if (slope_n_per_mm > 0.0) return {std::max(0.0, tip_n), slope_n_per_mm};
  }
  const double slope_n_per_mm =
      MedianOf(fits, &PunctureCurveFit::plateau_slope_n_per_mm, "slope of the plateau");
  const double in_n_per_mm = slope_n_per_mm > 0.0 ? slope_n_per_mm : out_n_per_mm;
  return {MedianCuttingN(fits, in_n_per_mm), in_n_per_mm};
}

}  // namespace

json FitJson(const ForceCurve& curve, const PunctureCurveFit& fit) {
  json parameters = json::object();
  const auto estimates = fit.Estimates();
  for (const auto& [name, estimate] : estimates) {
    const Estimate joint = estimate.AmongSeveral(static_cast<int>(estimates.size()));
    parameters[name] = EstimateJson(estimate);
    parameters[name].update({{"joint_low_95", joint.low}, {"joint_high_95", joint.high}});
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
  const InsertionForce in = InsertionOf(fits, out_n_per_mm);
  const double tip_n =
      MedianOf(fits, &PunctureCurveFit::withdrawal_tip_n, "pull on the tip of a withdrawn needle");
  json row = {{"tissue", tissue},
              {"cutting_n", ratio * in.cutting_n},
              {"friction_n_per_mm", ratio * in.friction_n_per_mm},
              {"withdrawal_friction_n_per_mm", ratio * std::max(0.0, out_n_per_mm)},
              {"withdrawal_tip_n", ratio * std::max(0.0, tip_n)},
              {"relaxation", relaxation}};
  row["source"] = Message("acus-fit: medians of ", fits.size(), " recordings, needle of ",
                          measured_diameter_mm, " mm");
  json& rows = base.at("tissues");
  const auto known = std::ranges::find_if(
      rows, [&](const json& other) { return other.value("tissue", "") == tissue; });
  AddMembrane(fits, ratio, row);
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
