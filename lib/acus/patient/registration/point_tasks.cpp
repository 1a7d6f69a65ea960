// Tasks on points: landmarks, pivots, touches, facets.
#include <algorithm>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/residual_plot.h"
#include "acus/patient/registration/pose_log.h"
#include "acus/patient/registration/registration_report.h"
#include "acus/patient/registration/result_folder.h"
#include "acus/patient/registration/rigid_registration.h"
#include "acus/patient/registration/tasks.h"

namespace acus::registration {
namespace {

namespace fs = std::filesystem;
using config::MatrixRows;

std::optional<transforms::Landmarks> Targets(const fs::path& target, RunContext& context) {
  if (target.empty()) return std::nullopt;
  return ReadPoints(target, context);
}

/// The folder of a registration of points; `more` writes what else belongs into it.
template <class More>
std::string WriteRegistration(const RegistrationReport& report, const fs::path& folder,
                              RunContext& context, const More& more) {
  RequireSameShape(report.pairs);
  for (const std::string& warning : report.warnings) context.Warn(warning);
  const auto plot = report::ResidualPlot("Residuals after registration", report.pairs.names,
                                         ResidualsMm(report), ErrorsByOthersMm(report));
  AtomicFolder output(folder, context.overwrite);
  WriteResult(output.path(), report, context);
  report::WriteSvg(output.path() / "residuals.svg", plot);
  more(output.path());
  output.Commit();
  return TableText(report);
}

void WritePointsCsv(const fs::path& path, const transforms::Landmarks& points,
                    const std::vector<Touch>& touches) {
  std::string text = "name,x_mm,y_mm,z_mm,rms_mm,samples,from_s,to_s\n";
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Touch& touch = touches[i];
    std::string name = points.names[i].empty() ? Message(i + 1) : points.names[i];
    std::erase_if(name, [](char c) { return c == '#' || c == ','; });  // CSV has comments.
    text += Message(name, ",", NumberText(touch.reference_mm.x()), ",",
                    NumberText(touch.reference_mm.y()), ",", NumberText(touch.reference_mm.z()),
                    ",", NumberText(touch.rms_mm), ",", touch.num_samples, ",",
                    NumberText(static_cast<double>(touch.start_ns) * 1e-9), ",",
                    NumberText(static_cast<double>(touch.end_ns) * 1e-9), "\n");
  }
  WriteTextFile(path, text);
}

/// The markers of all facets in one frame, as landmarks "facet/point".
struct FacetMarkers {
  transforms::Landmarks landmarks;
  std::vector<std::size_t> facet_of;
};

FacetMarkers MarkersOf(const std::vector<Facet>& facets,
                       const std::vector<transforms::Markers>& points_mm,
                       const std::string& source) {
  FacetMarkers markers;
  markers.landmarks.source = source;
  markers.landmarks.points_mm.resize(3, 0);
  for (std::size_t f = 0; f < facets.size(); ++f) {
    for (std::size_t i = 0; i < facets[f].point_names.size(); ++i) {
      markers.landmarks.names.push_back(facets[f].name + "/" + facets[f].point_names[i]);
      markers.facet_of.push_back(f);
    }
    transforms::Markers& all = markers.landmarks.points_mm;
    all.conservativeResize(3, all.cols() + points_mm[f].cols());
    all.rightCols(points_mm[f].cols()) = points_mm[f];
  }
  return markers;
}

std::string FacetTable(const FacetModel& model) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t f = 0; f < model.facets.size(); ++f) {
    rows.push_back({model.facets[f].name, VectorText(model.object_from_facet[f].translation(), 2),
                    FixedText(model.facet_rms_mm[f], 3), Message(model.num_seen[f])});
  }
  return TextTable({"facet", "place on the object mm", "noise mm RMS", "seen with others"}, rows) +
         Message(model.num_moments, " moments with several facets; ", model.num_rejected,
                 " readings did not fit and were excluded\n\n");
}

nlohmann::json ToJson(const FacetModel& model) {
  nlohmann::json facets = nlohmann::json::array();
  for (std::size_t f = 0; f < model.facets.size(); ++f) {
    facets.push_back({{"name", model.facets[f].name},
                      {"object_from_facet", MatrixRows(model.object_from_facet[f])},
                      {"rms_mm", model.facet_rms_mm[f]},
                      {"num_seen", model.num_seen[f]}});
  }
  return {{"format", "acus-facet-object/1"},
          {"facets", facets},
          {"num_moments", model.num_moments},
          {"num_rejected", model.num_rejected}};
}

/// Facets that moved since the scan, as warnings.
void WarnOfMovedFacets(const FacetModel& model, const FacetMarkers& object,
                       const transforms::MarkerPairs& pairs, RunContext& context) {
  std::vector<std::size_t> facet_of;
  for (const std::string& name : pairs.names) {
    const auto found = std::ranges::find(object.landmarks.names, name);
    facet_of.push_back(
        object.facet_of[static_cast<std::size_t>(found - object.landmarks.names.begin())]);
  }
  std::vector<std::string> names;
  for (const Facet& facet : model.facets) names.push_back(facet.name);
  const auto all = FindMovedFacets(pairs.reference_mm, pairs.ct_mm, facet_of, names);
  if (names.size() == 2 && !all.empty()) {
    context.Warn(Message("facets '", names[0], "' and '", names[1],
                         "' do not lie as in CT: the points of "
                         "one are ",
                         FixedText(all.front().moved_mm, 2),
                         " mm from where the other puts "
                         "them (p = ",
                         all.front().p_value, "); one has moved, two do not determine which"));
    return;
  }
  for (const MovedFacet& moved : all) {
    context.Warn(Message("facet '", moved.name, "' does not fit the others: its points are ",
                         FixedText(moved.moved_mm, 2), " mm from where they put them (p = ",
                         moved.p_value, "); has it moved since the CT?"));
  }
}

}  // namespace

std::string Run(const LandmarkTask& task, const fs::path& folder, RunContext& context) {
  const auto pairs = transforms::Without(
      transforms::MatchLandmarks(ReadPoints(task.from, context), ReadPoints(task.to, context)),
      task.leave_out);
  const auto report = Register(pairs, Targets(task.target, context), task.settings);
  return WriteRegistration(report, folder, context, [](const fs::path&) {});
}

std::string Run(const PivotTask& task, const fs::path& folder, RunContext& context) {
  std::vector<Eigen::Isometry3d> poses;
  for (const fs::path& path : task.poses) {
    const std::string name = path.filename().string();
    if (name.ends_with(".mha") || name.ends_with(".mhd") || name.ends_with(".nrrd")) {
      LogTool tool = task.tool;
      tool.log = path;
      for (const auto& sample : ReadTool(tool, context)) {
        if (sample.valid) poses.push_back(sample.reference_from_tool);
      }
      continue;
    }
    context.provenance.AddInput(path);
    for (const Eigen::Isometry3d& pose : ReadPoses(path)) poses.push_back(pose);
  }
  const auto result = task.robust ? CalibratePivotRobustly(poses) : CalibratePivot(poses);
  RequirePivoted(result, poses, task.limit_mm);
  if (!task.as_it_is) RequireTipInMillimetres(result, poses);
  const auto plot = report::ResidualPlot("Residuals of the poses", {}, result.residual_mm);
  AtomicFolder output(folder, context.overwrite);
  WriteResult(output.path(), result, context);
  report::WriteSvg(output.path() / "residuals.svg", plot);
  output.Commit();
  return TableText(result);
}

std::string Run(const TouchTask& task, const fs::path& folder, RunContext& context) {
  const Eigen::Vector3d tip_mm =
      task.pivot.empty() ? TipFrom(task.tip_mm) : ReadTip(task.pivot, context);
  const transforms::Landmarks known = ReadPoints(task.known, context);
  const auto rests = FindTouches(ReadTool(task.pointer, context), tip_mm, task.touches);
  const auto touches = ChooseTouches(rests, known);
  const transforms::Landmarks touched = NamedTouches(touches, known, task.pointer.log.string());
  const auto report = Register(transforms::MatchLandmarks(touched, known),
                               Targets(task.target, context), task.settings);
  std::string text = WriteRegistration(report, folder, context, [&](const fs::path& path) {
    WritePointsCsv(path / "touched.csv", touched, touches);
  });
  if (touches.size() < rests.size()) {
    text +=
        Message("note: of ", rests.size(), " rests those were taken that lie like the points\n");
  }
  return text;
}

std::string Run(const FacetTask& task, const fs::path& folder, RunContext& context) {
  context.provenance.AddInput(task.points);
  const auto facets = ReadFacetPoints(task.points);
  context.provenance.AddInput(task.poses);
  const FacetModel model = CalibrateFacets(facets, ReadFacetPoses(task.poses, facets));
  std::vector<transforms::Markers> object_mm;
  for (std::size_t f = 0; f < facets.size(); ++f) object_mm.push_back(model.PointsInObjectMm(f));
  const FacetMarkers object = MarkersOf(facets, object_mm, task.points.string());
  if (task.ct.empty()) {
    AtomicFolder output(folder, context.overwrite);
    WriteResult(output.path(), ToJson(model), context);
    output.Commit();
    return FacetTable(model);
  }
  context.provenance.AddInput(task.ct);
  std::vector<transforms::Markers> ct_mm;
  const auto in_ct = ReadFacetPoints(task.ct);
  for (const Facet& facet : in_ct) ct_mm.push_back(facet.points_mm);
  const transforms::MarkerPairs pairs = transforms::MatchLandmarks(
      object.landmarks, MarkersOf(in_ct, ct_mm, task.ct.string()).landmarks);
  WarnOfMovedFacets(model, object, pairs, context);
  const auto report = Register(pairs, Targets(task.target, context), task.settings);
  return FacetTable(model) + WriteRegistration(report, folder, context, [&](const fs::path& path) {
           config::WriteJson(path / "object.json", ToJson(model));
         });
}

}  // namespace acus::registration
