#include "acus/patient/registration/registration_report.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/covariance.h"
#include "acus/base/math/statistics.h"
#include "acus/data/transforms/transform_file.h"

namespace acus::registration {
namespace {

using config::MatrixRows;
using config::Row;
using nlohmann::json;

/// Standard deviations along the principal axes of a covariance, largest first.
json LeaveOneOutJson(const LeaveOneOut& result) {
  return {{"predicted_error_mm", result.predicted_error_mm},
          {"fre_without_mm", result.fre_without_mm},
          {"p_value", result.p_value}};
}

}  // namespace

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
  for (const std::string& name : report.left_out) text += "omitted: " + name + "\n";
  for (const std::string& note : report.notes) text += "note: " + note + "\n";
  if (report.targets.empty()) return text;
  rows.clear();
  for (const TargetError& target : report.targets) {
    const Eigen::Vector3d sd_mm = math::PrincipalDeviations(target.tre.covariance_mm2);
    rows.push_back({target.name, FixedText(target.tre.rms_mm, 3), FixedText(sd_mm[0], 3),
                    FixedText(target.bound_mm, 3)});
  }
  const std::string bound = Message(100.0 * report.confidence, " % below mm");
  return text + "\n" +
         TextTable({"target", "expected TRE mm (RMS)", "SD in its worst direction mm", bound},
                   rows);
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
  for (std::size_t i = 0; i < report.outliers.size(); ++i) {
    outliers.push_back({{"name", report.outlier_names[i]},
                        {"evidence", LeaveOneOutJson(report.outliers[i].evidence)}});
  }
  json targets = json::array();
  for (const TargetError& target : report.targets) {
    targets.push_back(
        {{"name", target.name},
         {"ct_mm", Row(target.ct_mm)},
         {"reference_mm", Row(report.fit.ct_from_reference.inverse() * target.ct_mm)},
         {"tre_rms_mm", target.tre.rms_mm},
         {"tre_bound_mm", target.bound_mm},
         {"principal_sd_mm", Row(math::PrincipalDeviations(target.tre.covariance_mm2))}});
  }
  json document = {{"format", "acus-registration/1"},
                   {"ct_from_reference", MatrixRows(report.fit.ct_from_reference)},
                   {"num_points", report.pairs.names.size()},
                   {"fre_rms_mm", report.fit.fre_rms_mm},
                   {"fle_rms_mm", report.fle_rms_mm},
                   {"fle_source", report.is_weighted    ? "points"
                                  : report.fle_is_given ? "given"
                                                        : "residuals"},
                   {"confidence", report.confidence},
                   {"left_out", report.left_out},
                   {"notes", report.notes},
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
  transforms::WriteTransform(
      folder / "ct_from_reference.tfm", report.fit.ct_from_reference,
      "ct_from_reference: takes points of the reference frame to CT (LPS, mm)");
  WriteJsonAndProvenance(folder, ToJson(report), context);
}

void WriteResult(const std::filesystem::path& folder, const PivotCalibration& calibration,
                 const RunContext& context) {
  WriteJsonAndProvenance(folder, ToJson(calibration), context);
}

}  // namespace acus::registration
