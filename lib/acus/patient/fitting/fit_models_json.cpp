#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/patient/fitting/fit_models.h"
#include "acus/patient/fitting/fit_report.h"

namespace acus::fitting {
namespace {

using nlohmann::json;

json RmsJson(const PhaseRms& rms) {
  return {{"insertion", rms.insertion_n}, {"hold", rms.hold_n}, {"retraction", rms.retraction_n}};
}

json ProfileJson(const ResistanceProfile& profile) {
  return {{"depth_mm", profile.depth_mm}, {"force_n", profile.force_n}};
}

json SlipsJson(const MechanicalModel& model) {
  json slips = json::array();
  for (const Slip& slip : model.slips) {
    slips.push_back({{"after_s", slip.after_s}, {"share", slip.share}});
  }
  return slips;
}

json ModelJson(const MechanicalModel& model) {
  return {{"in", ProfileJson(model.in)},
          {"out", ProfileJson(model.out)},
          {"buildup_in_mm", model.buildup_in_mm},
          {"buildup_out_mm", model.buildup_out_mm},
          {"reference_mm_per_s", model.reference_mm_per_s},
          {"relaxing_share", model.relaxing_share},
          {"relaxation_s", model.relaxation_s},
          {"slips", SlipsJson(model)},
          {"offset_n", model.offset_n},
          {"drift_n_per_s", model.drift_n_per_s}};
}

json GaussiansJson(const GaussianFit& fit) {
  json terms = json::array();
  for (std::size_t k = 0; k < fit.terms.size(); ++k) {
    json term = {{"height_n", fit.terms[k].height_n},
                 {"centre_mm", fit.terms[k].centre_mm},
                 {"width_mm", fit.terms[k].width_mm}};
    if (!fit.height_n.empty()) {
      term["standard_error"] = {{"height_n", fit.height_n[k].standard_error},
                                {"centre_mm", fit.centre_mm[k].standard_error},
                                {"width_mm", fit.width_mm[k].standard_error}};
    }
    terms.push_back(term);
  }
  return {{"converged", fit.converged},
          {"message", fit.message},
          {"rms_n", fit.rms_n},
          {"terms", terms}};
}

json EventsJson(const MechanicalFit& fit) {
  json punctures = json::array();
  for (const FoundPuncture& p : fit.punctures) {
    // What stays after it distinguishes a membrane from a change of tissue.
    const double drop_n = p.law.PeakN() - p.law.step_n;
    punctures.push_back({{"kind", drop_n > 0.05 ? "puncture" : "interface"},
                         {"contact_mm", EstimateJson(p.contact_mm)},
                         {"indentation_mm", EstimateJson(p.puncture_mm)},
                         {"peak_n", EstimateJson(p.peak_n)},
                         {"determined", p.peak_n.standard_error < 0.5 * p.law.PeakN()},
                         {"drop_n", drop_n},
                         {"step_n", EstimateJson(p.step_n)},
                         {"a1_n_per_mm", p.law.a1_n_per_mm},
                         {"a2_n_per_mm2", p.law.a2_n_per_mm2},
                         {"recovery_mm", p.law.recovery_mm}});
  }
  json releases = json::array();
  for (const FoundRelease& r : fit.releases) {
    releases.push_back({{"at_mm", EstimateJson(r.at_mm)},
                        {"step_n", EstimateJson(r.step_n)},
                        {"width_mm", r.law.width_mm}});
  }
  return {{"punctures", punctures}, {"releases", releases}};
}

json MechanicalJson(const MechanicalFit& fit) {
  json estimates = json::object();
  for (const auto& [name, estimate] : fit.estimates) estimates[name] = EstimateJson(estimate);
  return {{"converged", fit.converged},
          {"message", fit.message},
          {"warnings", fit.warnings},
          {"undetermined", fit.undetermined},
          {"parameters", estimates},
          {"cutting_n", fit.cutting_n ? EstimateJson(*fit.cutting_n) : json()},
          {"relaxing_branches", fit.relaxing_branches},
          {"one_friction_is_enough", fit.one_friction_is_enough},
          {"constant", ModelJson(fit.constant)},
          {"with_events", ModelJson(fit.eventful)},
          {"events", EventsJson(fit)},
          {"rms_n",
           {{"line", RmsJson(fit.line)},
            {"constant", RmsJson(fit.constant_rms)},
            {"with_events", RmsJson(fit.eventful_rms)}}}};
}

json LuGreJson(const LuGreFit& fit) {
  json estimates = json::object();
  for (const auto& [name, estimate] : fit.estimates) estimates[name] = EstimateJson(estimate);
  json result = {{"converged", fit.converged}, {"message", fit.message},
                 {"warnings", fit.warnings},   {"undetermined", fit.undetermined},
                 {"parameters", estimates},    {"rms_n", fit.rms_n}};
  if (fit.converged) {
    // The whole law: with it, ReplayLuGre repeats the fit.
    const LuGreParameters& p = fit.parameters;
    result["law"] = {{"sigma0_n_per_mm", p.sigma0_n_per_mm},
                     {"sigma1_n_s_per_mm", p.sigma1_n_s_per_mm},
                     {"sigma2_n_s_per_mm", p.sigma2_n_s_per_mm},
                     {"coulomb_n", p.coulomb_n},
                     {"static_n", p.static_n},
                     {"stribeck_mm_per_s", p.stribeck_mm_per_s},
                     {"growth_per_mm", p.growth_per_mm},
                     {"middle_mm", p.middle_mm},
                     {"offset_n", p.offset_n}};
    // As the block "alamilla" of a force table has it, for a normal force of 1 N: at middle_mm, and
    // without the offset.
    result["friction"] = {{"sigma0_per_mm", fit.parameters.sigma0_n_per_mm},
                          {"sigma1_s_per_mm", fit.parameters.sigma1_n_s_per_mm},
                          {"sigma2_s_per_mm", fit.parameters.sigma2_n_s_per_mm},
                          {"mu_coulomb", fit.parameters.coulomb_n},
                          {"mu_static", fit.parameters.static_n},
                          {"beta_s_per_mm", 1.0 / fit.parameters.stribeck_mm_per_s}};
  }
  return result;
}

json HuTableJson(const HuTableFit& fit) {
  if (!fit.converged) return {{"converged", false}, {"message", fit.message}};
  json errors = json::array();
  json high = json::array();
  for (const Estimate& e : fit.n_s_per_mm) {
    errors.push_back(e.standard_error);
    high.push_back(e.high);
  }
  return {{"converged", true},
          {"warnings", fit.warnings},
          {"vidal", VidalBlock(fit.table)},
          {"n_s_per_mm_standard_error", errors},
          {"n_s_per_mm_high_95", high},
          {"friction_n_per_mm", EstimateJson(fit.friction_n_per_mm)},
          {"edge_factor", EstimateJson(fit.edge_factor)},
          {"smoothing", fit.smoothing},
          {"rms_n", fit.rms_n}};
}

/// What the recordings share, and how well each is predicted; why not, if there is no such model.
void AddJoint(const std::vector<JointRecording>& recordings, json& result) {
  try {
    const JointModel joint = FitJoint(recordings);
    result["joint"] = {{"recordings", recordings.size()},
                       {"knots_in", joint.knots_in},
                       {"knots_out", joint.knots_out},
                       {"model", ModelJson(joint.model)}};
    json predictions = json::array();
    for (const Prediction& p : LeaveOneOut(recordings)) {
      predictions.push_back({{"name", p.name},
                             {"model_rms_n", RmsJson(p.model)},
                             {"two_constants_rms_n", RmsJson(p.two_knots)},
                             {"mean_curve_rms_n", RmsJson(p.mean_curve)}});
    }
    result["leave_one_out_predictions"] = predictions;
  } catch (const NoAnswerError& error) {
    result["joint"] = {{"recordings", recordings.size()}, {"why_not", error.what()}};
  }
}

}  // namespace

json CurveJson(const FittedCurve& fitted) {
  json result = FitJson(fitted.curve, fitted.puncture);
  for (const ModelAnswer& answer : AnswersOf(fitted)) {
    json& block = result["answers"][answer.model] = {{"answered", answer.has_answer}};
    if (!answer.has_answer) block["why_not"] = answer.why_not;
  }
  if (fitted.gaussians) result["gaussians"] = GaussiansJson(*fitted.gaussians);
  if (fitted.mechanical) result["mechanical"] = MechanicalJson(*fitted.mechanical);
  if (fitted.lugre) result["lugre"] = LuGreJson(*fitted.lugre);
  if (const auto f = Fortmeier(fitted)) {
    json& block = result["fortmeier"] = {
        {"cut_n", EstimateJson(f->cut_n)},
        {"friction_per_node_n", EstimateJson(f->friction_n)},
        {"stiffness_per_node_n_per_mm", EstimateJson(f->stiffness_n_per_mm)},
        {"tissue_stiffness_n_per_mm", EstimateJson(f->tissue_stiffness_n_per_mm)},
        {"node_spacing_mm", f->node_spacing_mm}};
    if (f->a1_n_per_mm) block["a1_n_per_mm"] = EstimateJson(*f->a1_n_per_mm);
    if (f->a2_n_per_mm2) block["a2_n_per_mm2"] = EstimateJson(*f->a2_n_per_mm2);
    if (f->capsule_cut_n) block["capsule_cut_n"] = EstimateJson(*f->capsule_cut_n);
  }
  json scores = json::array();
  for (const ModelScore& s : ScoreInsertion(fitted)) {
    scores.push_back(
        {{"model", s.name}, {"parameters", s.parameters}, {"rms_n", s.rms_n}, {"aic", s.aic}});
  }
  result["insertion_models"] = scores;
  return result;
}

json TogetherJson(std::span<const FittedCurve> fitted, const FitModels& models) {
  json result = json::object();
  std::vector<PunctureCurveFit> punctures;
  std::vector<JointRecording> recordings;
  for (const FittedCurve& f : fitted) {
    punctures.push_back(f.puncture);
    if (!f.mechanical) continue;
    const JointRecording recording{&f.curve, &f.puncture.phases, &*f.mechanical};
    if (recording.IsUsable()) recordings.push_back(recording);
  }
  result["median"] = SummaryJson(punctures);
  if (recordings.size() >= 2) AddJoint(recordings, result);
  if (models.hu_table) {
    std::vector<ForceCurve> curves;
    std::vector<CurvePhases> phases;
    std::vector<double> offsets;
    for (const FittedCurve& f : fitted) {
      curves.push_back(f.curve);
      phases.push_back(f.puncture.phases);
      offsets.push_back(f.puncture.offset_n ? f.puncture.offset_n->value : 0.0);
    }
    result["hu_table"] = HuTableJson(FitHuTable(curves, phases, offsets));
  }
  return result;
}

}  // namespace acus::fitting
