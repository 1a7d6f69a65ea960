// A force table fitted to recordings of one tissue, and replays through it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/patient/fitting/curve_fit.h"
#include "acus/physics/forces/laws/force_table.h"

namespace acus::fitting {

/// Force of the model layered along the depths of a recording, from the begin of the advance to the
/// end of the retraction, in the tissue from depth 0 on. No offset. @pre the fit has both phases.
std::vector<double> ReplayThroughTable(const forces::ForceTable& table, const std::string& tissue,
                                       const ForceCurve& curve, const PunctureCurveFit& fit,
                                       double needle_diameter_mm);

/// Geometric standard deviation of the recordings' mean forces while the needle advances, at most
/// 3; nothing from fewer than five recordings, or if a mean is not positive.
std::optional<double> ScatterOfMeanForce(std::span<const ForceCurve* const> curves,
                                         std::span<const PunctureCurveFit> fits);

/// TableWithFittedTissue with the relaxation of the holds and ScatterOfMeanForce. A drive that
/// slows down moves on while a hold begins, which strains the tissue again: the relaxation is that
/// with which replays through the table fall as the recordings do.
/// @throws NoAnswerError as TableWithFittedTissue.
nlohmann::json FittedTable(const nlohmann::json& base, const std::string& tissue,
                           std::span<const ForceCurve* const> curves,
                           std::span<const PunctureCurveFit> fits, double needle_diameter_mm);

}  // namespace acus::fitting
