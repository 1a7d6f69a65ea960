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
  int gaussian_count = 8;   ///< As in Vidal-2008 fig. 5...
  int most_gaussians = 12;  ///< ...and more where these leave much, up to so many.

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

/// Each model by itself: one that has no answer, for whatever reason, leaves the others theirs.
FittedCurve FitModelsTo(ForceCurve curve, const FitModels& models);

/// What became of one model of a recording.
struct ModelAnswer {
  std::string model;  ///< "puncture", "retraction", "hold", "gaussians", "mechanical", "lugre".
  bool has_answer = false;
  std::string why_not;  ///< What the recording lacks; empty with an answer.
};
/// One per model that was called for, in this order; the three phases always.
std::vector<ModelAnswer> AnswersOf(const FittedCurve& fitted);

/// A line for every model without an answer, beginning with "\n  "; empty if there is none.
std::string MissingAnswers(const std::string& label, const FittedCurve& fitted);

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
  // The capsule: only from a recording in which the needle comes in from outside. A puncture of
  // a structure inside says nothing about the capsule.
  std::optional<Estimate> a1_n_per_mm;
  std::optional<Estimate> a2_n_per_mm2;
  std::optional<Estimate> capsule_cut_n;  ///< f_cut where it is met: force at the puncture.
  Estimate cut_n;       ///< f_cut inside: insertion less withdrawal where the shaft is as deep.
  Estimate friction_n;  ///< R per node.
  Estimate stiffness_n_per_mm;         ///< k per node.
  Estimate tissue_stiffness_n_per_mm;  ///< K_t: force per travel before anything slides.
  double node_spacing_mm = 1.0;
};

/// Empty if the recording has no retraction or no mechanical fit.
std::optional<FortmeierFit> Fortmeier(const FittedCurve& fitted, double node_spacing_mm = 1.0);

/// One recording's results: FitJson and a block for each model.
nlohmann::json CurveJson(const FittedCurve& fitted);

/// RMS by phase and the number of events, a line per curve; empty without models.
std::string ModelTable(std::span<const FittedCurve> fitted);

/// What several recordings say together: shared model, how well each is foretold by the others,
/// resistance by HU, medians.
nlohmann::json TogetherJson(std::span<const FittedCurve> fitted, const FitModels& models);

/// Measured force with the fit of the puncture over it, and what remains, over x.
std::vector<report::Plot> PuncturePlots(const FittedCurve& fitted, const std::vector<double>& x,
                                        const char* x_label);
/// Insertion and retraction over depth with all models, what they leave, and everything over time.
std::vector<report::Plot> DepthPlots(const FittedCurve& fitted);
std::vector<report::Plot> TimePlots(const FittedCurve& fitted);

}  // namespace acus::fitting
