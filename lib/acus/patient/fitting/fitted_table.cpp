#include "acus/patient/fitting/fitted_table.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/fitting/fit_report.h"
#include "acus/patient/fitting/fitted_relaxation.h"
#include "acus/physics/forces/models/needle_force.h"

namespace acus::fitting {
namespace {

using nlohmann::json;

constexpr int kRelaxationRounds = 3;
constexpr double kLeastLeft = 0.02;  // Least share of a hold's first force.

/// The recordings with the forces of their replays, offsets included.
std::vector<ForceCurve> Replayed(const forces::ForceTable& table, const std::string& tissue,
                                 std::span<const ForceCurve* const> curves,
                                 std::span<const PunctureCurveFit> fits,
                                 double needle_diameter_mm) {
  std::vector<ForceCurve> out;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    ForceCurve& curve = out.emplace_back(*curves[i]);
    const CurvePhases& phases = fits[i].phases;
    if (phases.advance.size() == 0 || phases.hold.size() == 0) continue;
    const auto force = ReplayThroughTable(table, tissue, curve, fits[i], needle_diameter_mm);
    const double offset_n = fits[i].offset_n ? fits[i].offset_n->value : 0.0;
    for (std::size_t k = 0; k < force.size(); ++k) {
      curve.force_n[phases.advance.begin + k] = force[k] + offset_n;
    }
  }
  return out;
}

constexpr std::size_t kLeastForScatter = 5;
constexpr double kLargestGsd = 3.0;  // The schema acus-forces allows no more.

}  // namespace

std::optional<double> ScatterOfMeanForce(std::span<const ForceCurve* const> curves,
                                         std::span<const PunctureCurveFit> fits) {
  if (curves.size() < kLeastForScatter) return std::nullopt;
  std::vector<double> logarithms;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const SampleRange& advance = fits[i].phases.advance;
    if (advance.size() == 0) return std::nullopt;
    const auto begin = curves[i]->force_n.begin() + static_cast<std::ptrdiff_t>(advance.begin);
    const double mean_n = math::Mean({begin, begin + static_cast<std::ptrdiff_t>(advance.size())}) -
                          (fits[i].offset_n ? fits[i].offset_n->value : 0.0);
    if (!(mean_n > 0.0)) return std::nullopt;
    logarithms.push_back(std::log(mean_n));
  }
  return std::min(kLargestGsd, std::exp(math::StandardDeviation(logarithms)));
}

std::vector<double> ReplayThroughTable(const forces::ForceTable& table, const std::string& tissue,
                                       const ForceCurve& curve, const PunctureCurveFit& fit,
                                       double needle_diameter_mm) {
  const volume::Label label = volume::LabelOf(tissue);
  const double deepest_mm = std::ranges::max(curve.depth_mm);
  const forces::NeedleForceModel model(table, {.name = "recorded",
                                               .gauge = 0,
                                               .length_mm = deepest_mm + 100.0,
                                               .beam = {.outer_diameter_mm = needle_diameter_mm}});
  forces::NeedleForceState state;
  std::vector<double> force_n;
  const std::size_t end = std::max(fit.phases.retract.end, fit.phases.hold.end);
  for (std::size_t i = fit.phases.advance.begin; i < end; ++i) {
    const double depth_mm = std::max(0.0, curve.depth_mm[i]);
    force_n.push_back(
        model
            .Step(state, {curve.time_s[i], {0, 0, depth_mm}, Eigen::Vector3d::UnitZ(), label, true})
            .AxialN());
  }
  return force_n;
}

json FittedTable(const json& base, const std::string& tissue,
                 std::span<const ForceCurve* const> curves, std::span<const PunctureCurveFit> fits,
                 double needle_diameter_mm) {
  const HoldCurve recorded = HoldCurve::MeanOf(curves, fits);
  HoldCurve aimed_at = recorded;
  json table = TableWithFittedTissue(base, tissue, fits, RelaxationRow(FitHold(aimed_at)),
                                     needle_diameter_mm);
  for (int round = 0; round < kRelaxationRounds && !recorded.left.empty(); ++round) {
    const auto replays = Replayed(forces::ForceTableFromJson(table, "the fitted table"), tissue,
                                  curves, fits, needle_diameter_mm);
    std::vector<const ForceCurve*> pointers;
    for (const ForceCurve& replay : replays) pointers.push_back(&replay);
    const HoldCurve replayed = HoldCurve::MeanOf(pointers, fits);
    if (replayed.left.size() != recorded.left.size()) break;
    for (std::size_t n = 0; n < recorded.left.size(); ++n) {
      aimed_at.left[n] =
          std::max(kLeastLeft, aimed_at.left[n] + recorded.left[n] - replayed.left[n]);
    }
    table = TableWithFittedTissue(base, tissue, fits, RelaxationRow(FitHold(aimed_at)),
                                  needle_diameter_mm);
  }
  if (const auto gsd = ScatterOfMeanForce(curves, fits)) {
    const auto row = std::ranges::find_if(
        table.at("tissues"), [&](const json& other) { return other.at("tissue") == tissue; });
    (*row)["between_patients"] = {
        {"gsd", *gsd},
        {"source", Message("acus-fit: mean force of the advance in ", curves.size(),
                           " recordings; between patients if they are of as many")}};
  }
  return table;
}

}  // namespace acus::fitting
