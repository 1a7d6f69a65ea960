#include "acus/patient/fitting/measured_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/distributions.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/shared_fit.h"

namespace acus::fitting {
namespace {

using nlohmann::json;

constexpr std::size_t kFewestForBounds = 4;
constexpr double kDepthBinMm = 2.0;
constexpr double kHoldBin = 0.25;       // Of the logarithm of the time.
constexpr double kHoldBeginS = 0.1;     // Added to the time, so that the hold's begin has a place.
constexpr double kLeastSpreadN = 1e-3;  // A sensor is not better.
constexpr double kCovered = 0.95;

enum Phase { kIn, kHold, kOut, kPhases };

/// What one recording leaves of a law, by phase, over the phase's own coordinate.
struct PhaseResiduals {
  std::array<std::vector<double>, kPhases> x;
  std::array<std::vector<double>, kPhases> left_n;
};

/// The coordinate of a sample in its phase.
double PlaceOf(Phase phase, const ForceCurve& curve, std::size_t i, double origin_mm,
               double hold_s) {
  if (phase != kHold) return curve.depth_mm[i] - origin_mm;
  return std::log(kHoldBeginS + std::max(0.0, curve.time_s[i] - hold_s));
}

std::array<SampleRange, kPhases> RangesOf(const CurvePhases& phases) {
  return {phases.advance, HoldRange(phases), phases.retract};
}

PhaseResiduals PhaseResidualsOf(const MechanicalModel& law, const JointRecording& recording) {
  MechanicalModel model = law;
  model.offset_n = recording.fit->constant.offset_n;
  model.start_s = recording.fit->constant.start_s;
  const ForceCurve& curve = *recording.curve;
  const CurvePhases& phases = *recording.phases;
  const std::vector<double> force_n = ReplayPhases(model, curve, phases);
  const double origin_mm = recording.fit->constant.in.depth_mm.front();
  const double hold_s = curve.time_s[phases.advance.end - 1];
  PhaseResiduals residuals;
  const auto ranges = RangesOf(phases);
  for (const Phase phase : {kIn, kHold, kOut}) {
    for (std::size_t i = ranges[phase].begin; i < ranges[phase].end; ++i) {
      residuals.x[phase].push_back(PlaceOf(phase, curve, i, origin_mm, hold_s));
      residuals.left_n[phase].push_back(force_n[i - phases.advance.begin] - curve.force_n[i]);
    }
  }
  return residuals;
}

/// Root of the recordings' mean square, each with the same weight, over bins of x.
ResidualSpread SpreadOf(std::span<const PhaseResiduals> all, Phase phase, std::size_t without) {
  const double step = phase == kHold ? kHoldBin : kDepthBinMm;
  double low = 1e300;
  double high = -1e300;
  for (const PhaseResiduals& r : all) {
    if (r.x[phase].empty()) continue;
    const auto [least, most] = std::ranges::minmax(r.x[phase]);
    low = std::min(low, least);
    high = std::max(high, most);
  }
  if (!(high >= low)) return {{0.0}, {kLeastSpreadN}};
  const auto bins = 1 + static_cast<std::size_t>(std::min(1000.0, (high - low) / step));
  std::vector<double> squares(bins, 0.0);
  std::vector<double> weight(bins, 0.0);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k == without) continue;
    std::vector<double> own(bins, 0.0);
    std::vector<double> count(bins, 0.0);
    for (std::size_t i = 0; i < all[k].x[phase].size(); ++i) {
      const auto bin =
          std::min(bins - 1, static_cast<std::size_t>((all[k].x[phase][i] - low) / step));
      own[bin] += all[k].left_n[phase][i] * all[k].left_n[phase][i];
      count[bin] += 1.0;
    }
    for (std::size_t b = 0; b < bins; ++b) {
      if (count[b] > 0.0) squares[b] += own[b] / count[b], weight[b] += 1.0;
    }
  }
  ResidualSpread spread;
  for (std::size_t b = 0; b < bins; ++b) {
    if (weight[b] == 0.0) continue;
    spread.x.push_back(low + (static_cast<double>(b) + 0.5) * step);
    spread.sd_n.push_back(std::max(kLeastSpreadN, std::sqrt(squares[b] / weight[b])));
  }
  if (spread.x.empty()) return {{0.0}, {kLeastSpreadN}};
  return spread;
}

json SpreadJson(const ResidualSpread& spread, const char* x) {
  return {{x, spread.x}, {"sd_n", spread.sd_n}};
}

ResidualSpread SpreadFrom(const json& block, const char* x, const std::string& where) {
  ResidualSpread spread{block.at(x).get<std::vector<double>>(),
                        block.at("sd_n").get<std::vector<double>>()};
  ACUS_REQUIRE(!spread.x.empty() && spread.x.size() == spread.sd_n.size() &&
                   std::ranges::is_sorted(spread.x),
               where, ": must have as many rising ", x, " as sd_n, at least one");
  return spread;
}

const ResidualSpread& OfPhase(const PredictionBand& band, Phase phase) {
  return phase == kIn ? band.in : phase == kHold ? band.hold : band.out;
}

/// The quantile of |residual| / spread that covers `kCovered` in every phase.
double FactorOf(std::span<const PhaseResiduals> all) {
  double factor = 0.0;
  for (const Phase phase : {kIn, kHold, kOut}) {
    std::vector<double> standardised;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const ResidualSpread others = SpreadOf(all, phase, k);
      // Each recording with the same weight: the same number of samples.
      const std::size_t n = all[k].x[phase].size();
      for (std::size_t i = 0; n > 0 && i < 500; ++i) {
        const std::size_t at = i * n / 500;
        standardised.push_back(std::abs(all[k].left_n[phase][at]) / others.At(all[k].x[phase][at]));
      }
    }
    if (!standardised.empty()) factor = std::max(factor, math::Quantile(standardised, kCovered));
  }
  // As a t interval is wider than a normal one: so few recordings may be alike by chance.
  const double degrees = static_cast<double>(all.size()) - 1.0;
  return factor * math::StudentQuantile(0.975, degrees) / math::NormalQuantile(0.975);
}

std::vector<JointRecording> UsableOf(std::span<const FittedCurve> fitted) {
  std::vector<JointRecording> recordings;
  for (const FittedCurve& f : fitted) {
    if (!f.mechanical || !f.mechanical->converged) continue;
    const JointRecording recording{&f.curve, &f.puncture.phases, &*f.mechanical};
    if (recording.IsUsable()) recordings.push_back(recording);
  }
  return recordings;
}

json ByPhase(const PhaseRms& values) {
  return {{"insertion", values.insertion_n},
          {"hold", values.hold_n},
          {"retraction", values.retraction_n}};
}

}  // namespace

double ResidualSpread::At(double place) const {
  const auto above = std::ranges::upper_bound(x, place);
  if (above == x.begin()) return sd_n.front();
  if (above == x.end()) return sd_n.back();
  const auto k = static_cast<std::size_t>(above - x.begin());
  const double along = (place - x[k - 1]) / (x[k] - x[k - 1]);
  return sd_n[k - 1] + along * (sd_n[k] - sd_n[k - 1]);
}

PredictionBand FitPredictionBand(std::span<const JointRecording> recordings) {
  if (recordings.size() < kFewestForBounds) {
    throw NoAnswerError(Message("bounds for other recordings need ", kFewestForBounds,
                                " recordings with insertion and retraction; there are ",
                                recordings.size()));
  }
  std::vector<PhaseResiduals> residuals;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    std::vector<JointRecording> others(recordings.begin(), recordings.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    residuals.push_back(PhaseResidualsOf(FitJoint(others).model, recordings[k]));
  }
  return {static_cast<int>(recordings.size()), FactorOf(residuals),
          SpreadOf(residuals, kIn, residuals.size()), SpreadOf(residuals, kHold, residuals.size()),
          SpreadOf(residuals, kOut, residuals.size())};
}

json MeasuredJson(std::span<const FittedCurve> fitted, double needle_diameter_mm) {
  json document = {{"format", "acus-measured-force/1"},
                   {"needle_diameter_mm", needle_diameter_mm},
                   {"recordings", json::array()}};
  for (const FittedCurve& f : fitted) {
    if (!f.mechanical || !f.mechanical->converged) continue;
    document["recordings"].push_back(
        {{"name", f.curve.name}, {"law", forces::LawJson(f.mechanical->eventful)}});
  }
  if (document["recordings"].empty()) {
    throw NoAnswerError("no recording has a mechanical model, which the file of forces needs");
  }
  document["description"] =
      Message("acus-fit: ", document["recordings"].size(),
              " recordings; the mean of those with "
              "insertion and retraction, without punctures, and each with its own");
  const std::vector<JointRecording> usable = UsableOf(fitted);
  document["mean"] = document["recordings"][0]["law"];
  if (usable.size() < 2) return document;
  try {
    document["mean"] = forces::LawJson(FitJoint(usable).model);
    const PredictionBand band = FitPredictionBand(usable);
    document["prediction"] = {{"recordings", band.recordings},
                              {"factor", band.factor},
                              {"in", SpreadJson(band.in, "depth_mm")},
                              {"hold", SpreadJson(band.hold, "log_s")},
                              {"out", SpreadJson(band.out, "depth_mm")}};
  } catch (const NoAnswerError& error) {
    document["prediction"] = {{"why_not", error.what()}};
  }
  return document;
}

SavedFit ReadSavedFit(const std::filesystem::path& path) {
  const std::filesystem::path file =
      std::filesystem::is_directory(path) ? path / "measured.json" : path;
  const json document = config::ReadJson(file);
  SavedFit fit;
  fit.forces = forces::MeasuredForcesFromJson(document, file.string());
  const json band = document.value("prediction", json::object());
  const std::string where = file.string() + ": /prediction";
  ACUS_REQUIRE(band.contains("factor"), where,
               ": there are no bounds: ", band.value("why_not", "the fit is of too few recordings"),
               "; fit four or more recordings together");
  try {
    fit.band = {band.at("recordings"), band.at("factor"),
                SpreadFrom(band.at("in"), "depth_mm", where + "/in"),
                SpreadFrom(band.at("hold"), "log_s", where + "/hold"),
                SpreadFrom(band.at("out"), "depth_mm", where + "/out")};
  } catch (const json::exception& error) {
    throw InputError(Message(where, ": is not what acus-fit writes (", error.what(),
                             "); fit the recordings again"));
  }
  return fit;
}

PredictedCurve Predict(const SavedFit& fit, ForceCurve recording) {
  PredictedCurve predicted;
  predicted.curve = std::move(recording);
  const ForceCurve& curve = predicted.curve;
  const PunctureCurveFit puncture = FitPunctureCurve(curve);
  const CurvePhases& phases = puncture.phases;
  if (phases.advance.size() < 10) throw NoAnswerError(curve.name + ": " + puncture.message);
  const double origin_mm = OriginMm(curve, puncture);
  const double offset_n = puncture.offset_n ? puncture.offset_n->value : 0.0;
  const auto ranges = RangesOf(phases);
  predicted.moving = {phases.advance.begin,
                      std::max({phases.advance.end, ranges[kHold].end, phases.retract.end})};
  std::vector<double> depth_mm;
  for (std::size_t i = predicted.moving.begin; i < predicted.moving.end; ++i) {
    depth_mm.push_back(curve.depth_mm[i] - origin_mm);
  }
  MechanicalModel law = fit.forces.mean;
  if (puncture.starts_in_tissue) law.surface_mm = -1e9;
  law.offset_n = offset_n;
  predicted.mean_n = forces::Replay(
      law, std::span(curve.time_s).subspan(predicted.moving.begin, depth_mm.size()), depth_mm);
  predicted.low_n = predicted.high_n = predicted.mean_n;
  const double hold_s = curve.time_s[phases.advance.end - 1];
  double* const rms[] = {&predicted.rms.insertion_n, &predicted.rms.hold_n,
                         &predicted.rms.retraction_n};
  double* const covered[] = {&predicted.coverage.insertion_n, &predicted.coverage.hold_n,
                             &predicted.coverage.retraction_n};
  double all = 0.0;
  double inside_all = 0.0;
  for (const Phase phase : {kIn, kHold, kOut}) {
    double squares = 0.0;
    double inside = 0.0;
    for (std::size_t i = ranges[phase].begin; i < ranges[phase].end; ++i) {
      const std::size_t k = i - predicted.moving.begin;
      const double half_n =
          fit.band.factor *
          OfPhase(fit.band, phase).At(PlaceOf(phase, curve, i, origin_mm, hold_s));
      predicted.low_n[k] -= half_n;
      predicted.high_n[k] += half_n;
      const double left_n = predicted.mean_n[k] - curve.force_n[i];
      squares += left_n * left_n;
      inside += std::abs(left_n) <= half_n ? 1.0 : 0.0;
    }
    const auto n = static_cast<double>(ranges[phase].size());
    if (n == 0.0) continue;
    *rms[phase] = std::sqrt(squares / n);
    *covered[phase] = inside / n;
    all += n;
    inside_all += inside;
  }
  predicted.all_coverage = all > 0.0 ? inside_all / all : 0.0;
  return predicted;
}

json PredictionJson(const PredictedCurve& p) {
  json rows = json::array();
  const std::size_t step = std::max<std::size_t>(1, p.mean_n.size() / 2000);
  for (std::size_t k = 0; k < p.mean_n.size(); k += step) {
    rows.push_back({p.curve.time_s[p.moving.begin + k], p.curve.depth_mm[p.moving.begin + k],
                    p.mean_n[k], p.low_n[k], p.high_n[k]});
  }
  return {{"name", p.curve.name},
          {"rms_n", ByPhase(p.rms)},
          {"coverage", ByPhase(p.coverage)},
          {"coverage_of_all_samples", p.all_coverage},
          {"columns", {"time_s", "depth_mm", "mean_n", "low_95_n", "high_95_n"}},
          {"rows", rows}};
}

report::Plot PredictionPlot(const PredictedCurve& p) {
  const auto begin = static_cast<std::ptrdiff_t>(p.moving.begin);
  const auto end = static_cast<std::ptrdiff_t>(p.moving.end);
  const std::vector<double> time_s(p.curve.time_s.begin() + begin, p.curve.time_s.begin() + end);
  const std::vector<double> force_n(p.curve.force_n.begin() + begin, p.curve.force_n.begin() + end);
  report::Plot plot{.title = p.curve.name, .x_label = "time [s]", .y_label = "force [N]"};
  plot.series.push_back({.name = "95 % bounds",
                         .x = time_s,
                         .style = report::Style::kBand,
                         .low = p.low_n,
                         .high = p.high_n});
  plot.series.push_back({.name = "measured", .x = time_s, .y = force_n});
  plot.series.push_back({.name = "predicted mean", .x = time_s, .y = p.mean_n});
  return plot;
}

std::string PredictionTable(std::span<const PredictedCurve> predicted) {
  std::vector<std::vector<std::string>> rows;
  for (const PredictedCurve& p : predicted) {
    rows.push_back({p.curve.name, FixedText(p.rms.insertion_n, 3), FixedText(p.rms.hold_n, 3),
                    FixedText(p.rms.retraction_n, 3), FixedText(p.coverage.insertion_n, 2),
                    FixedText(p.coverage.hold_n, 2), FixedText(p.coverage.retraction_n, 2),
                    FixedText(p.all_coverage, 2)});
  }
  return "RMS about the predicted mean [N], and share of samples within the 95 % bounds\n" +
         TextTable({"curve", "in", "hold", "out", "in", "hold", "out", "all"}, rows);
}

}  // namespace acus::fitting
