#include "registration/registration_report.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/json_file.h"
#include "core/error.h"
#include "core/text_table.h"
#include "math/distributions.h"
#include "registration/transform_file.h"

namespace acus::registration {
namespace {

using nlohmann::json;

/// Markers whose spread across the line is below this share of that along it give a poor rotation.
constexpr double kThinSpreadRatio = 0.1;

json Row(const Eigen::Ref<const Eigen::Vector3d>& v) {
  return {v.x(), v.y(), v.z()};
}

json MatrixRows(const Eigen::Isometry3d& transform) {
  json rows = json::array();
  for (int i = 0; i < 4; ++i) {
    const Eigen::RowVector4d row = transform.matrix().row(i);
    rows.push_back({row[0], row[1], row[2], row[3]});
  }
  return rows;
}

/// Standard deviations along the principal axes of a covariance, largest first.
Eigen::Vector3d PrincipalDeviations(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().reverse();
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
  for (const Outlier& outlier : report.outliers) {
    warnings.push_back(Message(
        "point '", report.pairs.names[static_cast<std::size_t>(outlier.marker)],
        "' does not fit the others: it is ", FixedText(outlier.evidence.predicted_error_mm, 2),
        " mm from where they put it; without it FRE is ",
        FixedText(outlier.evidence.fre_without_mm, 3), " mm (p = ", outlier.evidence.p_value,
        "); measure it again, or add --leave-out"));
  }
  if (report.fre_p_value && *report.fre_p_value < 0.01) {
    warnings.push_back(
        Message("FRE is larger than the given FLE explains (p = ", *report.fre_p_value, ")"));
  }
  for (const std::string& mistake : CommonMistakes(report.pairs)) warnings.push_back(mistake);
}

json LeaveOneOutJson(const LeaveOneOut& result) {
  return {{"predicted_error_mm", result.predicted_error_mm},
          {"fre_without_mm", result.fre_without_mm},
          {"p_value", result.p_value}};
}

}  // namespace

RegistrationReport Register(const MarkerPairs& pairs, const std::optional<Landmarks>& targets_ct,
                            std::optional<double> fle_rms_mm) {
  RegistrationReport report;
  report.pairs = pairs;
  report.warnings = pairs.warnings;
  report.fit = FitMarkers(pairs.reference_mm, pairs.ct_mm);
  report.spread_mm = SpreadMm(pairs.ct_mm);
  const auto count = static_cast<int>(pairs.ct_mm.cols());
  report.fle_is_given = fle_rms_mm.has_value();
  report.fle_rms_mm = FleFromFreMm(report.fit.fre_rms_mm, count);
  if (fle_rms_mm) {
    ACUS_REQUIRE(std::isfinite(*fle_rms_mm) && *fle_rms_mm > 0.0,
                 "the localisation error must be above 0 mm, got ", *fle_rms_mm);
    report.fle_rms_mm = *fle_rms_mm;
    const double variance_mm2 = *fle_rms_mm * *fle_rms_mm / 3.0;
    report.fre_p_value = math::ChiSquareUpperTail(
        report.fit.residual_mm.squaredNorm() / variance_mm2, 3.0 * count - 6.0);
  }
  if (count >= 4) {
    report.leave_one_out = LeaveEachOut(pairs.reference_mm, pairs.ct_mm);
    report.outliers = FindOutliers(pairs.reference_mm, pairs.ct_mm);
  }
  if (targets_ct) {
    for (Eigen::Index i = 0; i < targets_ct->points_mm.cols(); ++i) {
      const Eigen::Vector3d ct_mm = targets_ct->points_mm.col(i);
      const std::string& name = targets_ct->names[static_cast<std::size_t>(i)];
      report.targets.push_back({name.empty() ? Message("#", i + 1) : name, ct_mm,
                                ExpectedTre(pairs.ct_mm, report.fle_rms_mm, ct_mm)});
    }
  }
  AddWarnings(report);
  return report;
}

std::vector<double> ResidualsMm(const RegistrationReport& report) {
  const Eigen::VectorXd length_mm = report.fit.residual_mm.colwise().norm();
  return {length_mm.begin(), length_mm.end()};
}

std::vector<std::optional<double>> ErrorsByOthersMm(const RegistrationReport& report) {
  std::vector<std::optional<double>> errors_mm;
  for (const auto& result : report.leave_one_out) {
    errors_mm.push_back(result ? std::optional(result->predicted_error_mm) : std::nullopt);
  }
  return errors_mm;
}

std::string TableText(const RegistrationReport& report) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < report.pairs.names.size(); ++i) {
    const Eigen::Vector3d residual_mm = report.fit.residual_mm.col(static_cast<Eigen::Index>(i));
    std::vector<std::string> row{report.pairs.names[i], FixedText(residual_mm.norm(), 3), "-", "-"};
    if (!report.leave_one_out.empty() && report.leave_one_out[i]) {
      row[2] = FixedText(report.leave_one_out[i]->predicted_error_mm, 3);
      row[3] = FixedText(report.leave_one_out[i]->fre_without_mm, 3);
    }
    rows.push_back(std::move(row));
  }
  std::string text =
      TextTable({"point", "residual mm", "error by the others mm", "FRE without it mm"}, rows);
  text += Message("\nFRE ", FixedText(report.fit.fre_rms_mm, 3), " mm over ", rows.size(),
                  " points; FLE ", FixedText(report.fle_rms_mm, 3), " mm (",
                  report.fle_is_given ? "given" : "from FRE", ")\n");
  if (report.targets.empty()) return text;
  rows.clear();
  for (const TargetError& target : report.targets) {
    const Eigen::Vector3d sd_mm = PrincipalDeviations(target.tre.covariance_mm2);
    rows.push_back({target.name, FixedText(target.tre.rms_mm, 3), FixedText(sd_mm[0], 3)});
  }
  return text + "\n" +
         TextTable({"target", "expected TRE mm (RMS)", "SD in its worst direction mm"}, rows);
}

json ToJson(const RegistrationReport& report) {
  json points = json::array();
  for (std::size_t i = 0; i < report.pairs.names.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    points.push_back({{"name", report.pairs.names[i]},
                      {"reference_mm", Row(report.pairs.reference_mm.col(column))},
                      {"ct_mm", Row(report.pairs.ct_mm.col(column))},
                      {"residual_mm", report.fit.residual_mm.col(column).norm()},
                      {"residual_vector_mm", Row(report.fit.residual_mm.col(column))}});
    if (!report.leave_one_out.empty() && report.leave_one_out[i]) {
      points.back()["leave_one_out"] = LeaveOneOutJson(*report.leave_one_out[i]);
    }
  }
  json outliers = json::array();
  for (const Outlier& outlier : report.outliers) {
    outliers.push_back({{"name", report.pairs.names[static_cast<std::size_t>(outlier.marker)]},
                        {"evidence", LeaveOneOutJson(outlier.evidence)}});
  }
  json targets = json::array();
  for (const TargetError& target : report.targets) {
    targets.push_back({{"name", target.name},
                       {"ct_mm", Row(target.ct_mm)},
                       {"reference_mm", Row(report.fit.ct_from_reference.inverse() * target.ct_mm)},
                       {"tre_rms_mm", target.tre.rms_mm},
                       {"principal_sd_mm", Row(PrincipalDeviations(target.tre.covariance_mm2))}});
  }
  json document = {{"format", "acus-registration/1"},
                   {"ct_from_reference", MatrixRows(report.fit.ct_from_reference)},
                   {"num_points", report.pairs.names.size()},
                   {"fre_rms_mm", report.fit.fre_rms_mm},
                   {"fle_rms_mm", report.fle_rms_mm},
                   {"fle_source", report.fle_is_given ? "given" : "residuals"},
                   {"spread_mm", Row(report.spread_mm)},
                   {"points", points},
                   {"outliers", outliers},
                   {"targets", targets},
                   {"warnings", report.warnings}};
  if (report.fre_p_value) document["fre_p_value"] = *report.fre_p_value;
  return document;
}

std::string TableText(const PivotCalibration& calibration) {
  const auto vector = [](const Eigen::Vector3d& v) {
    return FixedText(v.x(), 3) + "  " + FixedText(v.y(), 3) + "  " + FixedText(v.z(), 3);
  };
  return Message("tip in the tool's frame    ", vector(calibration.tip_mm), " mm\n",
                 "pivot in the reference     ", vector(calibration.pivot_mm), " mm\n",
                 "residual per coordinate    ",
                 FixedText(calibration.residual_coordinate_rms_mm, 3),
                 " mm RMS\nresidual length            ", FixedText(calibration.residual_rms_mm, 3),
                 " mm RMS\nstandard error of the tip  ", vector(calibration.tip_sd_mm),
                 " mm along its principal directions\nturned by                  ",
                 FixedText(calibration.tilt_deg, 1),
                 " deg RMS in the weakest direction\nposes used ", "                ",
                 std::ranges::count(calibration.used, true), " of ", calibration.used.size(), "\n");
}

json ToJson(const PivotCalibration& calibration) {
  return {{"format", "acus-pivot/1"},
          {"tip_mm", Row(calibration.tip_mm)},
          {"pivot_mm", Row(calibration.pivot_mm)},
          {"residual_coordinate_rms_mm", calibration.residual_coordinate_rms_mm},
          {"residual_rms_mm", calibration.residual_rms_mm},
          {"tip_sd_mm", Row(calibration.tip_sd_mm)},
          {"tilt_deg", calibration.tilt_deg},
          {"num_poses", calibration.used.size()},
          {"num_used", std::ranges::count(calibration.used, true)},
          {"residual_mm", calibration.residual_mm},
          {"used", calibration.used}};
}

namespace {

void WriteJsonAndProvenance(const std::filesystem::path& folder, json document,
                            const RunContext& context) {
  document["provenance"] = context.provenance.ToJson();
  config::WriteJson(folder / "registration.json", document);
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

}  // namespace

void WriteResult(const std::filesystem::path& folder, const RegistrationReport& report,
                 const RunContext& context) {
  WriteTransform(folder / "ct_from_reference.tfm", report.fit.ct_from_reference,
                 "ct_from_reference: takes points of the reference frame to CT (LPS, mm)");
  WriteJsonAndProvenance(folder, ToJson(report), context);
}

void WriteResult(const std::filesystem::path& folder, const PivotCalibration& calibration,
                 const RunContext& context) {
  WriteJsonAndProvenance(folder, ToJson(calibration), context);
}

}  // namespace acus::registration
