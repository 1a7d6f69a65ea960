#include "acus/patient/registration/pose_log.h"

#include <algorithm>
#include <map>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/session_import.h"
#include "acus/data/session/session_io.h"
#include "acus/data/transforms/transform_graph.h"

namespace acus::registration {
namespace {

namespace fs = std::filesystem;
using registration::Facet;
using registration::FacetPoses;

bool IsCsv(const fs::path& path) {
  return path.extension() == ".csv";
}

bool IsSessionFolder(const fs::path& path) {
  return fs::exists(path / "session.json");
}

std::string Joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text.empty() ? "none" : text;
}

std::size_t FacetNamed(const std::vector<Facet>& facets, const std::string& name,
                       const std::string& where) {
  const auto found = std::ranges::find(facets, name, &Facet::name);
  ACUS_REQUIRE(found != facets.end(), where, ": there is no facet '", name,
               "' in the list of facets");
  return static_cast<std::size_t>(found - facets.begin());
}

}  // namespace

session::PoseStream ReadTool(const LogTool& tool, RunContext& context) {
  context.provenance.AddInput(tool.log);
  if (IsCsv(tool.log)) return session::ReadPoseCsv(tool.log, context);
  if (IsSessionFolder(tool.log)) {
    const session::Session session = session::ReadSession(tool.log, context);
    const bool is_probe = tool.tool == "probe";
    ACUS_REQUIRE(is_probe || tool.tool == "needle", tool.log.string(),
                 ": a session folder has the tools "
                 "needle and probe, not '",
                 tool.tool, "'; choose one with --tool");
    const session::PoseStream& poses = is_probe ? session.probe : session.needle;
    ACUS_REQUIRE(!poses.empty(), tool.log.string(), ": has no poses of the ", tool.tool);
    return poses;
  }
  session::ImportOptions options;
  options.needle_frames = {tool.tool};
  options.probe_frames = {};
  options.reference_frame = tool.reference;
  return session::ReadAnySession(tool.log, options, context).session.needle;
}

std::vector<std::string> ToolsOf(const fs::path& log, const std::string& reference,
                                 RunContext& context) {
  if (IsCsv(log)) return {log.stem().string()};
  if (IsSessionFolder(log)) {
    const session::Session session = session::ReadSession(log, context);
    std::vector<std::string> tools;
    if (!session.needle.empty()) tools.emplace_back("needle");
    if (!session.probe.empty()) tools.emplace_back("probe");
    return tools;
  }
  const session::SequenceFile file(log);
  std::vector<std::string> tools, all;
  for (const std::string& field : file.header().frame_field_names()) {
    const auto name = transforms::ParseTransformName(field);
    if (!name) continue;
    all.push_back(name->from + "To" + name->to);
    if (name->to == reference) tools.push_back(name->from);
  }
  ACUS_REQUIRE(!tools.empty(), log.string(), ": no tool is given in the frame '", reference,
               "'; there are ", Joined(all));
  return tools;
}

bool IsPoseLog(const fs::path& path) {
  const std::string name = path.filename().string();
  if (fs::is_directory(path)) return true;
  for (const char* end : {".mha", ".mhd", ".nrrd", ".mrb", ".mrml"}) {
    if (name.ends_with(end)) return true;
  }
  return IsCsv(path) && CsvTable(path).Has("qw");
}

std::vector<Facet> ReadFacetPoints(const fs::path& path) {
  const CsvTable table(path);
  const auto facet = table.Texts("facet");
  const auto name = table.Texts("name");
  const auto x = table.Numbers("x_mm"), y = table.Numbers("y_mm"), z = table.Numbers("z_mm");
  std::vector<Facet> facets;
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    auto found = std::ranges::find(facets, facet[row], &Facet::name);
    if (found == facets.end()) {
      facets.push_back({.name = facet[row], .point_names = {}, .points_mm = {}});
      facets.back().points_mm.resize(3, 0);
      found = facets.end() - 1;
    }
    ACUS_REQUIRE(std::ranges::find(found->point_names, name[row]) == found->point_names.end(),
                 table.Where(row), ": facet '", facet[row], "' has the point '", name[row],
                 "' twice");
    const Eigen::Vector3d point_mm(x[row], y[row], z[row]);
    ACUS_REQUIRE(point_mm.cwiseAbs().maxCoeff() <= 1e6, table.Where(row),
                 ": the point is more than a kilometre away; is the unit mm?");
    found->point_names.push_back(name[row]);
    found->points_mm.conservativeResize(3, found->points_mm.cols() + 1);
    found->points_mm.rightCols<1>() = point_mm;
  }
  ACUS_REQUIRE(!facets.empty(), path.string(), ": holds no facet");
  return facets;
}

std::vector<FacetPoses> ReadFacetPoses(const fs::path& path, const std::vector<Facet>& facets) {
  const CsvTable table(path);
  const auto time_s = table.Texts("time_s");
  const auto facet = table.Texts("facet");
  std::vector<std::vector<double>> columns;
  for (const char* name : {"x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"}) {
    columns.push_back(table.Numbers(name));
  }
  std::vector<std::string> status(table.num_rows(), "OK");
  if (table.Has("status")) status = table.Texts("status");
  std::map<std::int64_t, FacetPoses> moments;
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    const std::size_t f = FacetNamed(facets, facet[row], table.Where(row));
    if (status[row] != "OK") continue;
    const auto time_ns = session::NanosecondsFromText(time_s[row]);
    ACUS_REQUIRE(time_ns, table.Where(row), ": time_s is '", time_s[row], "', not a time in s");
    const auto at = [&](std::size_t c) { return columns[c][row]; };
    const Eigen::Vector3d position_mm(at(0), at(1), at(2));
    const Eigen::Quaterniond q(at(3), at(4), at(5), at(6));
    ACUS_REQUIRE(std::abs(q.norm() - 1.0) <= 1e-3, table.Where(row),
                 ": the quaternion's length is ", q.norm(), ", not 1");
    ACUS_REQUIRE(position_mm.cwiseAbs().maxCoeff() <= 1e6, table.Where(row),
                 ": the position is more than a kilometre away; is the unit mm?");
    FacetPoses& poses = moments.try_emplace(*time_ns, FacetPoses(facets.size())).first->second;
    ACUS_REQUIRE(!poses[f], table.Where(row), ": facet '", facet[row], "' is there twice at ",
                 time_s[row], " s");
    poses[f] = Eigen::Translation3d(position_mm) * q.normalized();
  }
  std::vector<FacetPoses> list;
  for (auto& [time, poses] : moments) list.push_back(std::move(poses));
  ACUS_REQUIRE(!list.empty(), path.string(), ": holds no pose with status OK");
  return list;
}

}  // namespace acus::registration
