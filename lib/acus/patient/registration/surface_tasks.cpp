// Tasks on surfaces: the swept skin, and the CT in the mannequin's shape.
#include <algorithm>
#include <cmath>

#include "acus/base/config/pose_json.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/svg_plot.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/data/volume/displacement_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/registration/error_bound.h"
#include "acus/patient/registration/pose_log.h"
#include "acus/patient/registration/result_folder.h"
#include "acus/patient/registration/tasks.h"
#include "acus/patient/registration/warp_volume.h"

namespace acus::registration {
namespace {

namespace fs = std::filesystem;
using config::MatrixRows;
using config::Row;
using nlohmann::json;

transforms::Landmarks PointsFrom(const SurfaceTask& task, RunContext& context) {
  if (!IsPoseLog(task.points)) return ReadPoints(task.points, context);
  LogTool pointer = task.pointer;
  pointer.log = task.points;
  return SweptPoints(ReadTool(pointer, context), TipFrom(task.tip_mm), task.spacing_mm,
                     task.points.string());
}

/// How many points are how far from the surface.
report::Plot DistancePlot(const Eigen::VectorXd& distance_mm) {
  report::Plot plot;
  plot.title = "Distances of the points from the surface";
  plot.x_label = "distance, outside positive [mm]";
  plot.y_label = "points";
  const double low = distance_mm.minCoeff();
  const double width = std::max(1e-6, (distance_mm.maxCoeff() - low) / 40.0);
  report::Series bars{.style = report::Style::kBars};
  for (int bin = 0; bin < 40; ++bin) {
    bars.x.push_back(low + (bin + 0.5) * width);
    bars.y.push_back(0.0);
  }
  for (const double d : distance_mm) {
    bars.y[static_cast<std::size_t>(std::min(39.0, std::floor((d - low) / width)))] += 1.0;
  }
  plot.series.push_back(std::move(bars));
  return plot;
}

json ToJson(const SurfaceFit& fit) {
  json motions = json::array();
  for (const FreeMotion& motion : fit.motions) {
    motions.push_back({{"motion", motion.text},
                       {"hold", motion.hold},
                       {"turn_deg", Row(motion.turn_deg)},
                       {"shift_mm", Row(motion.shift_mm)}});
  }
  json document = {{"format", "acus-surface-registration/1"},
                   {"ct_from_reference", MatrixRows(fit.ct_from_reference)},
                   {"rms_mm", fit.rms_mm},
                   {"num_points", fit.used.size()},
                   {"num_used", std::ranges::count(fit.used, true)},
                   {"num_iterations", fit.num_iterations},
                   {"motions", motions}};
  if (fit.rival_mm) document["rival_mm"] = *fit.rival_mm;
  return document;
}

std::string TargetText(const fs::path& target, const SurfaceFit& fit, json& document,
                       RunContext& context) {
  if (target.empty()) return "";
  const transforms::Landmarks targets = ReadPoints(target, context);
  std::vector<std::vector<std::string>> rows;
  for (Eigen::Index i = 0; i < targets.points_mm.cols(); ++i) {
    const TreEstimate tre = fit.error.At(targets.points_mm.col(i));
    const double bound_mm = LengthBoundMm(tre.covariance_mm2, 0.95);
    const std::string& name = targets.names[static_cast<std::size_t>(i)];
    rows.push_back({name, FixedText(tre.rms_mm, 3), FixedText(bound_mm, 3)});
    document["targets"].push_back(
        {{"name", name}, {"tre_rms_mm", tre.rms_mm}, {"tre_bound_mm", bound_mm}});
  }
  return "\n" + TextTable({"target", "expected TRE mm (RMS)", "95 % below mm"}, rows);
}

json ToJson(const WarpQuality& q) {
  return {{"format", "acus-warp/1"},
          {"before_rms_mm", q.before_rms_mm},
          {"after_rms_mm", q.after_rms_mm},
          {"after_p95_mm", q.after_p95_mm},
          {"after_largest_mm", q.after_largest_mm},
          {"num_points", q.num_points},
          {"num_left_out", q.num_left_out},
          {"largest_mm", q.largest_mm},
          {"smallest_volume", q.smallest_volume},
          {"largest_volume", q.largest_volume},
          {"bone_rms_mm", q.bone_rms_mm},
          {"bone_strain", q.bone_strain}};
}

MannequinSkin MannequinFrom(const WarpTask& task, RunContext& context) {
  Eigen::Isometry3d ct_from_reference = Eigen::Isometry3d::Identity();
  if (!task.transform.empty()) {
    context.provenance.AddInput(task.transform);
    ct_from_reference = transforms::ReadTransform(task.transform);
  }
  const std::string name = task.mannequin.filename().string();
  if (name.ends_with(".csv") || name.ends_with(".json") || name.ends_with(".fcsv")) {
    const transforms::Landmarks points = ReadPoints(task.mannequin, context);
    return {.points_mm = ct_from_reference * points.points_mm, .normals = Eigen::Matrix3Xd(3, 0)};
  }
  context.provenance.AddInput(task.mannequin);
  return PointsOf(mesh::ReadSurface(task.mannequin), ct_from_reference);
}

std::string QualityText(const WarpQuality& q) {
  return Message("skin to mannequin   ", FixedText(q.before_rms_mm, 2), " mm RMS before, ",
                 FixedText(q.after_rms_mm, 2), " after (95 % ", FixedText(q.after_p95_mm, 2),
                 ", largest ", FixedText(q.after_largest_mm, 2), ")\n", "points              ",
                 q.num_points, " used, ", q.num_left_out, " excluded\n",
                 "displacement        up to ", FixedText(q.largest_mm, 1), " mm\n",
                 "volume of tissue    ", FixedText(q.smallest_volume, 2), " to ",
                 FixedText(q.largest_volume, 2), " of before (Jacobian; no folding)\n",
                 "bone                off one rigid motion by ", FixedText(q.bone_rms_mm, 2),
                 " mm RMS, strain ", FixedText(100.0 * q.bone_strain, 2), " % (95 %)\n");
}

}  // namespace

std::string Run(const SurfaceTask& task, const fs::path& folder, RunContext& context) {
  const transforms::Landmarks points = PointsFrom(task, context);
  context.provenance.AddInput(task.surface);
  const mesh::Surface surface = mesh::ReadSurface(task.surface);
  std::optional<Eigen::Isometry3d> start;
  if (!task.start.empty()) {
    context.provenance.AddInput(task.start);
    start = transforms::ReadTransform(task.start);
  }
  const SurfaceFit fit =
      RegisterToSurface(points.points_mm, surface, start, task.settings, context);
  if (fit.rival_mm) {
    context.Warn(Message("another pose, up to ", FixedText(*fit.rival_mm, 1),
                         " mm away, fits about as well; give a start (--start, from a few "
                         "landmarks) or sweep more of the skin"));
  }
  json document = ToJson(fit);
  std::string text =
      Message("distance ", FixedText(fit.rms_mm, 3), " mm RMS over ",
              std::ranges::count(fit.used, true), " of ", fit.used.size(), " points, ",
              fit.num_iterations, " iterations\nheld least: ", fit.motions.front().text, ", ",
              FixedText(fit.motions.front().hold, 2), " mm off the surface per mm\n");
  text += TargetText(task.target, fit, document, context);
  AtomicFolder output(folder, context.overwrite);
  WriteResult(output.path(), document, context);
  transforms::WriteTransform(
      output.path() / "ct_from_reference.tfm", fit.ct_from_reference,
      "ct_from_reference: takes points of the reference frame to CT (LPS, mm)");
  report::WriteSvg(output.path() / "distances.svg", DistancePlot(fit.distance_mm));
  output.Commit();
  return text;
}

std::string Run(const WarpTask& task, const fs::path& folder, RunContext& context) {
  context.provenance.AddInput(task.ct);
  const volume::CtVolume ct = volume::ReadCt(task.ct, "", context);
  context.provenance.AddInput(task.labels);
  const volume::LabelMap labels = volume::ReadTissues(task.labels);
  context.provenance.AddInput(task.skin);
  const auto warp = WarpToMannequin(labels, mesh::ReadSurface(task.skin),
                                    MannequinFrom(task, context), task.settings, context);
  AtomicFolder output(folder, context.overwrite);
  volume::WriteCt(output.path() / "ct.nrrd", WarpCt(ct, warp.field, context));
  volume::WriteLabelMap(output.path() / "labels.seg.nrrd", WarpLabels(labels, warp.field, context));
  volume::WriteDisplacementField(output.path() / "displacement.nrrd",
                                 ToDisplacementField(warp.field));
  WriteResult(output.path(), ToJson(warp.quality), context);
  output.Commit();
  return QualityText(warp.quality);
}

}  // namespace acus::registration
