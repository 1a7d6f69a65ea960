// Fitted recordings as a file that the force model "measured" reads, and what it predicts of other
// recordings of the same tissue.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "acus/base/report/svg_plot.h"
#include "acus/patient/fitting/fit_models.h"
#include "acus/physics/forces/models/measured_forces.h"

namespace acus::fitting {

/// Standard deviation of what the mean law leaves of a recording that it does not come from:
/// differences between recordings and the variation within one. Linear in between, constant beyond.
struct ResidualSpread {
  std::vector<double> x;  ///< Depth since the contact, mm; in the hold logarithm of 0.1 s + time.
  std::vector<double> sd_n;

  double At(double x) const;
};

/// Bounds about the mean curve: +- factor * spread at each sample.
struct PredictionBand {
  int recordings = 0;
  double factor = 0.0;  ///< Such that 95 % of the samples of each phase, of recordings omitted in
                        ///< turn, are within, times Student's quantile over the normal one.
  ResidualSpread in;
  ResidualSpread hold;
  ResidualSpread out;
};

/// Leaves each recording out in turn: the law of the others replayed through its motion, its
/// residual in units of the others' spread.
/// @throws NoAnswerError with fewer than four usable recordings, or if they cannot be joined.
PredictionBand FitPredictionBand(std::span<const JointRecording> recordings);

/// A document of the format acus-measured-force/1: the law of each recording with a mechanical
/// model, their mean, and the band if there are enough of them.
/// @throws NoAnswerError if no recording has a mechanical model.
nlohmann::json MeasuredJson(std::span<const FittedCurve> fitted, double needle_diameter_mm);

/// One new recording beside what the fit says of it. Vectors by sample from `begin` on.
struct PredictedCurve {
  ForceCurve curve;
  SampleRange moving;  ///< From the begin of the insertion to the end of the retraction.
  std::vector<double> mean_n;
  std::vector<double> low_n;
  std::vector<double> high_n;
  PhaseRms rms;       ///< Of mean - measured.
  PhaseRms coverage;  ///< Share of samples within the bounds, by phase; 0 where there is none.
  double all_coverage = 0.0;
};

/// A saved fit, for predictions.
struct SavedFit {
  forces::MeasuredForces forces;
  PredictionBand band;
};
/// @param path  measured.json, or the folder that holds it.
/// @throws InputError; also if the fit has too few recordings for bounds.
SavedFit ReadSavedFit(const std::filesystem::path& path);

/// Replays the mean through the recording's own motion, from its own offset.
/// @throws NoAnswerError if the drive does not advance.
PredictedCurve Predict(const SavedFit& fit, ForceCurve curve);

nlohmann::json PredictionJson(const PredictedCurve& predicted);
report::Plot PredictionPlot(const PredictedCurve& predicted);
std::string PredictionTable(std::span<const PredictedCurve> predicted);

}  // namespace acus::fitting
