#include "acus/patient/fitting/fit_models.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/curve_models.h"

namespace acus::fitting {
namespace {

const Estimate* Find(const std::vector<std::pair<std::string, Estimate>>& estimates,
                     const char* name) {
  const auto found =
      std::ranges::find_if(estimates, [&](const auto& entry) { return entry.first == name; });
  return found == estimates.end() ? nullptr : &found->second;
}

Estimate Scaled(const Estimate& e, double factor) {
  return {factor * e.value, factor * e.standard_error, factor * e.low,
          factor * e.high,  factor * e.least,          e.at_bound};
}

/// Residual of the insertion, model less measured.
template <typename Model>
std::vector<double> InsertionResidual(const FittedCurve& fitted, const Model& model) {
  std::vector<double> residual;
  const SampleRange& range = fitted.puncture.phases.advance;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    residual.push_back(model(i) - fitted.curve.force_n[i]);
  }
  return residual;
}

}  // namespace

FitModels FitModels::FromNames(const std::vector<std::string>& names) {
  FitModels models{.gaussians = false, .mechanical = false, .lugre = false, .hu_table = false};
  for (const std::string& name : names) {
    const bool all = name == "all";
    const std::vector<std::string> known = {"gaussians", "mechanical", "lugre",
                                            "hu-table",  "all",        "none"};
    ACUS_REQUIRE(std::ranges::find(known, name) != known.end(), "no model is named '", name,
                 "'; allowed: gaussians, mechanical, lugre, hu-table, all, none");
    models.gaussians = models.gaussians || all || name == "gaussians";
    models.mechanical = models.mechanical || all || name == "mechanical";
    models.lugre = models.lugre || all || name == "lugre";
    models.hu_table = models.hu_table || all || name == "hu-table";
  }
  return models;
}

FittedCurve FitModelsTo(ForceCurve curve, const FitModels& models) {
  FittedCurve fitted{std::move(curve), {}, {}, {}, {}};
  fitted.puncture = FitPunctureCurve(fitted.curve);
  // A model that cannot be fitted says why; the others do not depend on it.
  const auto attempt = [](auto& into, const auto& fit) {
    try {
      into = fit();
    } catch (const NoAnswerError& error) {
      into.emplace();
      into->message = error.what();
    }
  };
  if (models.gaussians) {
    attempt(fitted.gaussians, [&] {
      return FitGaussians(fitted.curve, fitted.puncture.phases, models.gaussian_count,
                          models.most_gaussians);
    });
  }
  if (models.mechanical) {
    attempt(fitted.mechanical, [&] { return FitMechanical(fitted.curve, fitted.puncture); });
  }
  if (models.lugre) attempt(fitted.lugre, [&] { return FitLuGre(fitted.curve); });
  return fitted;
}

std::vector<ModelAnswer> AnswersOf(const FittedCurve& fitted) {
  std::vector<ModelAnswer> answers;
  const auto add = [&](const char* model, bool has_answer, const std::string& why_not) {
    answers.push_back({model, has_answer, has_answer ? "" : why_not});
  };
  const PunctureCurveFit& puncture = fitted.puncture;
  add("puncture", puncture.converged, puncture.message);
  add("retraction", puncture.friction_n_per_mm.has_value(),
      "no retraction over 3 mm or more inside the tissue once friction has turned round");
  add("hold", puncture.relaxation_fraction.has_value(),
      "no hold of 1 s or more in which the force falls like an exponential");
  if (fitted.gaussians) add("gaussians", fitted.gaussians->converged, fitted.gaussians->message);
  if (fitted.mechanical) {
    add("mechanical", fitted.mechanical->converged, fitted.mechanical->message);
  }
  if (fitted.lugre) add("lugre", fitted.lugre->converged, fitted.lugre->message);
  return answers;
}

std::string MissingAnswers(const std::string& label, const FittedCurve& fitted) {
  std::string text;
  for (const ModelAnswer& answer : AnswersOf(fitted)) {
    if (!answer.has_answer)
      text += Message("\n  ", label, ": ", answer.model, ": ", answer.why_not);
  }
  return text;
}

std::vector<ModelScore> ScoreInsertion(const FittedCurve& fitted) {
  std::vector<ModelScore> scores;
  std::vector<double> best;
  const auto add = [&](const char* name, int parameters, std::vector<double> residual) {
    if (residual.empty()) return;
    const double rms = math::RootMeanSquare(residual);
    scores.push_back({name, parameters, rms, 0.0});
    if (best.empty() || rms < math::RootMeanSquare(best)) best = std::move(residual);
  };
  const SampleRange& range = fitted.puncture.phases.advance;
  if (range.size() < 60) return scores;
  Samples samples;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    samples.Add(i, fitted.curve.depth_mm[i], fitted.curve.force_n[i]);
  }
  const double middle_mm = math::Mean(samples.x);
  const ModelFit line = FitModel(Line(middle_mm), samples.x, samples.y, {0.0, 0.0}, false);
  add("line", 2, InsertionResidual(fitted, [&](std::size_t i) {
        return line.parameters[0] + line.parameters[1] * (fitted.curve.depth_mm[i] - middle_mm);
      }));
  if (fitted.mechanical && fitted.mechanical->converged) {
    const auto replayed = [&](const MechanicalModel& model) {
      const std::vector<double> force = ReplayPhases(model, fitted.curve, fitted.puncture.phases);
      return InsertionResidual(fitted, [&](std::size_t i) { return force[i - range.begin]; });
    };
    add("mechanical, two constants", 3, replayed(fitted.mechanical->constant));
    add("mechanical with punctures", 3 + 6 * static_cast<int>(fitted.mechanical->punctures.size()),
        replayed(fitted.mechanical->eventful));
  }
  if (fitted.gaussians && fitted.gaussians->converged) {
    add("gaussians", 3 * static_cast<int>(fitted.gaussians->terms.size()),
        InsertionResidual(fitted, [&](std::size_t i) {
          return SumN(fitted.gaussians->terms, fitted.curve.depth_mm[i]);
        }));
  }
  const double samples_worth = std::max(30.0, static_cast<double>(range.size()) / Inflation(best));
  for (ModelScore& score : scores) {
    score.aic = 2.0 * samples_worth * std::log(std::max(score.rms_n, 1e-9)) +
                2.0 * (score.parameters + 1.0);
  }
  return scores;
}

std::optional<FortmeierFit> Fortmeier(const FittedCurve& fitted, double node_spacing_mm) {
  if (!fitted.mechanical || !fitted.mechanical->converged) return {};
  const auto& estimates = fitted.mechanical->estimates;
  const Estimate* friction = Find(estimates, "withdrawal_n_per_mm");
  const Estimate* buildup = Find(estimates, "buildup_out_mm");
  const Estimate* stiffness = Find(estimates, "tissue_stiffness_n_per_mm");
  if (!fitted.mechanical->cutting_n || !friction || !buildup || !stiffness) return {};
  FortmeierFit fit;
  fit.node_spacing_mm = node_spacing_mm;
  const PunctureCurveFit& puncture = fitted.puncture;
  if (puncture.converged && puncture.is_entry) {
    fit.a1_n_per_mm = puncture.a1_n_per_mm;
    fit.a2_n_per_mm2 = puncture.a2_n_per_mm2;
    fit.capsule_cut_n = puncture.puncture_n;
  }
  fit.cut_n = *fitted.mechanical->cutting_n;
  fit.friction_n = Scaled(*friction, node_spacing_mm);
  fit.stiffness_n_per_mm = PositiveRatio(fit.friction_n, *buildup);
  fit.tissue_stiffness_n_per_mm = *stiffness;
  return fit;
}

std::string ModelTable(std::span<const FittedCurve> fitted) {
  std::vector<std::vector<std::string>> rows;
  for (const FittedCurve& f : fitted) {
    if (!f.gaussians && !f.mechanical) continue;
    std::vector<std::string>& row = rows.emplace_back();
    row = {f.curve.name,
           f.gaussians && f.gaussians->converged ? FixedText(f.gaussians->rms_n, 3) : "-"};
    if (!f.mechanical || !f.mechanical->converged) {
      row.insert(row.end(), 8, "-");
      continue;
    }
    const MechanicalFit& m = *f.mechanical;
    for (const double rms_n :
         {m.line.insertion_n, m.constant_rms.insertion_n, m.eventful_rms.insertion_n,
          m.eventful_rms.hold_n, m.line.retraction_n, m.constant_rms.retraction_n,
          m.eventful_rms.retraction_n}) {
      row.push_back(FixedText(rms_n, 3));
    }
    row.push_back(std::to_string(m.punctures.size()));
  }
  if (rows.empty()) return "";
  return "\nRMS of what the models leave, N\n" +
         TextTable({"curve", "gaussians", "in: line", "constant", "events", "hold", "out: line",
                    "constant", "events", "punctures"},
                   rows);
}

}  // namespace acus::fitting
