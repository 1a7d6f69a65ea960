// All models that acus-fit can fit to recordings, together.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/base/report/svg_plot.h"
#include "acus/patient/fitting/curve_fit.h"
#include "acus/patient/fitting/gaussian_fit.h"
#include "acus/patient/fitting/hu_table_fit.h"
#include "acus/patient/fitting/joint_fit.h"
#include "acus/patient/fitting/lugre_fit.h"
#include "acus/patient/fitting/mechanical_fit.h"

namespace acus::fitting {

/// The puncture is always fitted; these beside it.
struct FitModels {
  bool gaussians = true;
  bool mechanical = true;
  bool lugre = false;
  bool hu_table = false;
  int gaussian_count = 8;

  /// Names as in "gaussians,mechanical", "all" or "none". @throws InputError for another name.
  static FitModels FromNames(const std::vector<std::string>& names);
};

struct FittedCurve {
  ForceCurve curve;
  PunctureCurveFit puncture;
  std::optional<GaussianFit> gaussians;
  std::optional<MechanicalFit> mechanical;
  std::optional<LuGreFit> lugre;
};

FittedCurve FitModelsTo(ForceCurve curve, const FitModels& models);

/// How well the insertion is described and at what price: for choosing a model. Akaike's criterion
/// with the number of independent samples of the best model's residual.
struct ModelScore {
  std::string name;
  int parameters = 0;
  double rms_n = 0.0;
  double aic = 0.0;
};
std::vector<ModelScore> ScoreInsertion(const FittedCurve& fitted);

/// Parameters of Fortmeier-2016 eq. 4-7 for path nodes of this spacing.
struct FortmeierFit {
  Estimate a1_n_per_mm;
  Estimate a2_n_per_mm2;
  Estimate capsule_cut_n;  ///< f_cut where a membrane is met: force at the puncture.
  Estimate cut_n;          ///< f_cut inside: insertion less withdrawal where the shaft is as deep.
  Estimate friction_n;     ///< R per node.
  Estimate stiffness_n_per_mm;         ///< k per node.
  Estimate tissue_stiffness_n_per_mm;  ///< K_t: force per travel before anything slides.
  double node_spacing_mm = 1.0;
};

/// Empty if the recording has no puncture, no retraction or no mechanical fit.
std::optional<FortmeierFit> Fortmeier(const FittedCurve& fitted, double node_spacing_mm = 1.0);

/// One recording's results: FitJson and a block for each model.
nlohmann::json CurveJson(const FittedCurve& fitted);

/// RMS by phase and the number of events, a line per curve; empty without models.
std::string ModelTable(std::span<const FittedCurve> fitted);

/// What several recordings say together: shared model, how well each is foretold by the others,
/// resistance by HU, medians.
nlohmann::json TogetherJson(std::span<const FittedCurve> fitted, const FitModels& models);

/// Measured force with the fit of the puncture over it, and what is left, over x.
std::vector<report::Plot> PuncturePlots(const FittedCurve& fitted, const std::vector<double>& x,
                                        const char* x_label);
/// Insertion and retraction over depth with all models, what they leave, and everything over time.
std::vector<report::Plot> DepthPlots(const FittedCurve& fitted);
std::vector<report::Plot> TimePlots(const FittedCurve& fitted);

}  // namespace acus::fitting
