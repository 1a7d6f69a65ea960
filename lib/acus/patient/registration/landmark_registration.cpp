#include "acus/patient/registration/landmark_registration.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/distributions.h"
#include "acus/patient/registration/correspondence.h"
#include "acus/patient/registration/error_bound.h"
#include "acus/patient/registration/outlier_search.h"

namespace acus::registration {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Markers whose spread across the line is below this share of that along it give a poor rotation.
constexpr double kThinSpreadRatio = 0.1;
constexpr double kSamePlaceMm = 0.1;

std::string NameOf(const transforms::MarkerPairs& pairs, Index i) {
  return Message("'", pairs.names[static_cast<std::size_t>(i)], "'");
}

std::vector<MarkerNoise> NoiseOf(const transforms::MarkerPairs& pairs) {
  std::vector<MarkerNoise> noise(pairs.names.size());
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const auto column = static_cast<Index>(i);
    if (pairs.reference_sd_mm.cols() > 0) {
      const Vector3d sd_mm = pairs.reference_sd_mm.col(column);
      noise[i].reference_mm2 = sd_mm.cwiseAbs2().asDiagonal();
    }
    if (pairs.ct_sd_mm.cols() > 0) {
      const Vector3d sd_mm = pairs.ct_sd_mm.col(column);
      noise[i].ct_mm2 = sd_mm.cwiseAbs2().asDiagonal();
    }
  }
  return noise;
}

bool HasNoise(const transforms::MarkerPairs& pairs) {
  return pairs.reference_sd_mm.cols() > 0 || pairs.ct_sd_mm.cols() > 0;
}

void WarnOfPointsAtOnePlace(RegistrationReport& report) {
  const transforms::MarkerPairs& pairs = report.pairs;
  for (Index i = 0; i < pairs.ct_mm.cols(); ++i) {
    for (Index j = i + 1; j < pairs.ct_mm.cols(); ++j) {
      const double reference_mm = (pairs.reference_mm.col(i) - pairs.reference_mm.col(j)).norm();
      const double ct_mm = (pairs.ct_mm.col(i) - pairs.ct_mm.col(j)).norm();
      if (std::min(reference_mm, ct_mm) > kSamePlaceMm) continue;
      report.warnings.push_back(
          Message(NameOf(pairs, i), " and ", NameOf(pairs, j), " are at the same place in the ",
                  reference_mm < ct_mm ? "reference frame" : "CT", "; was one recorded twice?"));
    }
  }
}

void AddWarnings(RegistrationReport& report) {
  auto& warnings = report.warnings;
  if (report.pairs.ct_mm.cols() == 3) {
    warnings.emplace_back(
        "with 3 points a wrong one cannot be found, and the errors are estimated "
        "from 3 degrees of freedom; use 4 or more");
  }
  if (report.spread_mm[1] < kThinSpreadRatio * report.spread_mm[0]) {
    warnings.push_back(Message("the points are nearly on a line (spread along it ",
                               FixedText(report.spread_mm[0], 1), " mm, across it ",
                               FixedText(report.spread_mm[1], 1),
                               " mm): the rotation about it is poorly determined"));
  }
  WarnOfPointsAtOnePlace(report);
  if (report.fre_p_value && *report.fre_p_value < 0.01) {
    warnings.push_back(
        Message("FRE is larger than the given FLE explains (p = ", *report.fre_p_value, ")"));
  }
  for (const std::string& mistake : CommonMistakes(report.pairs)) warnings.push_back(mistake);
}

/// Puts the points right where the order of another choice fits far better.
transforms::MarkerPairs Ordered(const transforms::MarkerPairs& pairs, bool find_order,
                                RegistrationReport& report) {
  if (pairs.ct_mm.cols() > kMostToOrder) {
    ACUS_REQUIRE(!find_order, "the order of at most ", kMostToOrder,
                 " points can be found, there are ", pairs.ct_mm.cols(),
                 "; name the same point alike in both files");
    return pairs;
  }
  const auto same = EquallyGoodOrders(pairs.reference_mm, pairs.ct_mm);
  if (!same.empty()) {
    report.notes.push_back(Message("the layout is so symmetrical that another order fits as well (",
                                   DescribeOrder(same.front(), pairs.names), ": FRE ",
                                   FixedText(same.front().fre_rms_mm, 3),
                                   " mm): a wrong order would not be noticed; move a marker"));
  }
  if (!find_order) return pairs;
  const auto order = BetterOrder(pairs.reference_mm, pairs.ct_mm);
  if (!order) return pairs;
  report.notes.push_back(
      Message("the points were put in another order: ", DescribeOrder(*order, pairs.names)));
  return Reordered(pairs, *order);
}

std::string Joined(const transforms::MarkerPairs& pairs, const std::vector<Index>& markers) {
  std::string text;
  for (const Index i : markers) text += (text.empty() ? "" : ", ") + NameOf(pairs, i);
  return text;
}

/// Looks for wrong points, and takes them out if requested.
void TreatOutliers(const RegistrationSettings& settings, RegistrationReport& report) {
  const transforms::MarkerPairs pairs = report.pairs;
  // In a wrong order several points are off; CommonMistakes says so.
  if (pairs.ct_mm.cols() < 4 || BetterOrder(pairs.reference_mm, pairs.ct_mm)) return;
  const auto found = SearchOutliers(pairs.reference_mm, pairs.ct_mm, settings.fle_rms_mm);
  const bool unclear = !found.instead.empty();
  if (unclear && settings.leave_out_outliers) {
    throw NoAnswerError(Message("some point is wrong (p = ", found.p_value,
                                "), but the others do not determine which: it may be ",
                                Joined(pairs, found.wrong), " or ", Joined(pairs, found.instead),
                                "; measure these again, or use more points"));
  }
  for (const Index marker : found.wrong) {
    const double error_mm = found.error_mm[static_cast<std::size_t>(marker)];
    report.outliers.push_back({marker,
                               {.predicted_error_mm = error_mm,
                                .fre_without_mm = found.fre_without_mm,
                                .p_value = found.p_value}});
    report.outlier_names.push_back(pairs.names[static_cast<std::size_t>(marker)]);
    report.warnings.push_back(
        Message("point ", NameOf(pairs, marker), " does not fit the others: it is ",
                FixedText(error_mm, 2), " mm from where they put it; without ",
                found.wrong.size() > 1 ? "the points that do not fit" : "it", " FRE is ",
                FixedText(found.fre_without_mm, 3), " mm (p = ", found.p_value, "); ",
                settings.leave_out_outliers ? "it was excluded"
                                            : "measure it again, or add --robust or --leave-out",
                unclear ? "; but it may be " + Joined(pairs, found.instead) + " instead" : ""));
  }
  if (!settings.leave_out_outliers) return;
  report.left_out = report.outlier_names;
  report.pairs = transforms::Without(pairs, report.left_out);
}

void Fit(const RegistrationSettings& settings, RegistrationReport& report) {
  const transforms::MarkerPairs& pairs = report.pairs;
  const Index count = pairs.ct_mm.cols();
  const double freedom = 3.0 * static_cast<double>(count) - 6.0;
  report.is_weighted = HasNoise(pairs);
  ACUS_REQUIRE(!(report.is_weighted && settings.fle_rms_mm),
               "the files give a localisation error for each point; omit the one for all");
  if (report.is_weighted) {
    const auto noise = NoiseOf(pairs);
    const WeightedFit weighted = FitMarkersWeighted(pairs.reference_mm, pairs.ct_mm, noise);
    report.fit = weighted.fit;
    report.pose_error = weighted.error;
    report.fle_is_given = true;
    double sum_mm2 = 0.0;
    for (const MarkerNoise& n : noise) sum_mm2 += n.reference_mm2.trace() + n.ct_mm2.trace();
    report.fle_rms_mm = std::sqrt(sum_mm2 / static_cast<double>(count));
    report.fre_p_value = math::ChiSquareUpperTail(weighted.chi_square, freedom);
    return;
  }
  report.fit = FitMarkers(pairs.reference_mm, pairs.ct_mm);
  report.fle_is_given = settings.fle_rms_mm.has_value();
  report.fle_rms_mm = FleFromFreMm(report.fit.fre_rms_mm, static_cast<int>(count));
  if (settings.fle_rms_mm) {
    report.fle_rms_mm = *settings.fle_rms_mm;
    const double variance_mm2 = report.fle_rms_mm * report.fle_rms_mm / 3.0;
    report.fre_p_value =
        math::ChiSquareUpperTail(report.fit.residual_mm.squaredNorm() / variance_mm2, freedom);
  }
  if (report.fle_rms_mm > 0.0) {
    report.pose_error = ErrorOfUnweightedFit(pairs.reference_mm, report.fit.ct_from_reference,
                                             IsotropicNoise(count, report.fle_rms_mm));
  }
}

TargetError ErrorAt(const std::string& name, const Vector3d& ct_mm,
                    const RegistrationReport& report) {
  TargetError target{
      .name = name, .ct_mm = ct_mm, .tre = report.pose_error.At(ct_mm), .bound_mm = 0.0};
  const double freedom = 3.0 * static_cast<double>(report.pairs.ct_mm.cols()) - 6.0;
  target.bound_mm = report.fle_is_given
                        ? LengthBoundMm(target.tre.covariance_mm2, report.confidence)
                        : LengthBoundMm(target.tre.covariance_mm2, report.confidence, freedom);
  return target;
}

}  // namespace

RegistrationReport Register(const transforms::MarkerPairs& pairs,
                            const std::optional<transforms::Landmarks>& targets_ct,
                            const RegistrationSettings& settings) {
  const auto& fle_mm = settings.fle_rms_mm;
  ACUS_REQUIRE(!fle_mm || (std::isfinite(*fle_mm) && *fle_mm > 0.0),
               "the localisation error must be above 0 mm, got ", fle_mm.value_or(0.0));
  ACUS_REQUIRE(settings.confidence >= 0.5 && settings.confidence <= 0.9999,
               "the confidence must lie in [0.5, 0.9999], got ", settings.confidence);
  FitMarkers(pairs.reference_mm, pairs.ct_mm);  // Refuses what determines no pose.
  RegistrationReport report;
  report.confidence = settings.confidence;
  report.warnings = pairs.warnings;
  report.pairs = Ordered(pairs, settings.find_order, report);
  TreatOutliers(settings, report);
  Fit(settings, report);
  report.spread_mm = SpreadMm(report.pairs.ct_mm);
  if (report.pairs.ct_mm.cols() >= 4) {
    report.leave_one_out = LeaveEachOut(report.pairs.reference_mm, report.pairs.ct_mm);
  }
  if (targets_ct) {
    for (Index i = 0; i < targets_ct->points_mm.cols(); ++i) {
      const std::string& name = targets_ct->names[static_cast<std::size_t>(i)];
      report.targets.push_back(
          ErrorAt(name.empty() ? Message("#", i + 1) : name, targets_ct->points_mm.col(i), report));
    }
  }
  AddWarnings(report);
  return report;
}

}  // namespace acus::registration
