// The task of calibrating an ultrasound probe: reads points and poses, writes ImageToProbe.
#include <algorithm>
#include <map>

#include "acus/base/config/pose_json.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/residual_plot.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/patient/registration/pose_log.h"
#include "acus/patient/registration/probe_calibration.h"
#include "acus/patient/registration/result_folder.h"
#include "acus/patient/registration/tasks.h"

namespace acus::registration {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using nlohmann::json;

constexpr double kLargestPx = 1e5;
constexpr std::size_t kMostNamed = 20;  ///< Outliers on the terminal; the file has all.

/// The columns of a table of points; poses of the probe's marker by row.
struct PointTable {
  explicit PointTable(const fs::path& path) : table(path) {}

  CsvTable table;
  std::vector<std::int64_t> time_ns = {};
  std::vector<Vector2d> point_px = {};
  std::vector<std::optional<Isometry3d>> reference_from_probe = {};

  double Seconds(std::size_t row) const { return 1e-9 * static_cast<double>(time_ns[row]); }
};

std::vector<std::vector<double>> NumberColumns(const CsvTable& table,
                                               std::initializer_list<const char*> names) {
  std::vector<std::vector<double>> columns;
  for (const char* name : names) columns.push_back(table.Numbers(name));
  return columns;
}

void ReadPixels(PointTable& points) {
  const CsvTable& table = points.table;
  const auto time_s = table.Texts("time_s");
  const auto columns = NumberColumns(table, {"u_px", "v_px"});
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    const auto time_ns = session::NanosecondsFromText(time_s[row]);
    ACUS_REQUIRE(time_ns, table.Where(row), ": time_s is '", time_s[row], "', not a time in s");
    points.time_ns.push_back(*time_ns);
    points.point_px.emplace_back(columns[0][row], columns[1][row]);
    ACUS_REQUIRE(points.point_px[row].cwiseAbs().maxCoeff() <= kLargestPx, table.Where(row),
                 ": the point is at pixel (", columns[0][row], ", ", columns[1][row],
                 "); pixels up to ", kLargestPx, " are accepted");
  }
}

void ReadPosesBeside(PointTable& points) {
  const CsvTable& table = points.table;
  ACUS_REQUIRE(
      table.Has("qw"), table.path().string(),
      ": has no poses of the probe's marker; add the columns x_mm, y_mm, z_mm, qw, qx, qy, "
      "qz, or name its recording by --log");
  const auto columns = NumberColumns(table, {"x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"});
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    const auto at = [&](std::size_t c) { return columns[c][row]; };
    const Eigen::Quaterniond q(at(3), at(4), at(5), at(6));
    ACUS_REQUIRE(std::abs(q.norm() - 1.0) <= 1e-3, table.Where(row),
                 ": the quaternion's length is ", q.norm(), ", not 1");
    points.reference_from_probe.emplace_back(
        Isometry3d(Eigen::Translation3d(at(0), at(1), at(2)) * q.normalized()));
  }
}

void ReadPosesOf(const LogTool& probe, PointTable& points, RunContext& context) {
  const session::PoseStream stream = ReadTool(probe, context);
  ACUS_REQUIRE(!stream.empty(), probe.log.string(), ": has no pose of ", probe.tool);
  std::size_t num_invalid = 0;
  for (std::size_t row = 0; row < points.time_ns.size(); ++row) {
    const std::int64_t time_ns = points.time_ns[row];
    ACUS_REQUIRE(time_ns >= stream.front().time_ns && time_ns <= stream.back().time_ns,
                 points.table.Where(row), ": ", points.Seconds(row), " s is not in the recording ",
                 probe.log.string(), ", which runs from ",
                 static_cast<double>(stream.front().time_ns) * 1e-9, " to ",
                 static_cast<double>(stream.back().time_ns) * 1e-9, " s");
    const session::PoseSample pose = session::PoseAt(stream, time_ns);
    points.reference_from_probe.emplace_back();
    if (pose.valid) points.reference_from_probe.back() = pose.reference_from_tool;
    if (!pose.valid) ++num_invalid;
  }
  if (num_invalid > 0) {
    context.Warn(Message(num_invalid, " points were omitted: the tracker did not see ", probe.tool,
                         " at their times"));
  }
}

PointTable ReadPointTable(const ProbeTask& task, RunContext& context) {
  context.provenance.AddInput(task.points);
  PointTable points(task.points);
  ReadPixels(points);
  if (task.probe.log.empty()) {
    ReadPosesBeside(points);
  } else {
    ReadPosesOf(task.probe, points, context);
  }
  return points;
}

std::string WireNames(const WirePhantom& phantom) {
  std::string text;
  for (std::size_t i = 0; i < phantom.num_wires(); ++i) {
    text += (i == 0 ? "'" : ", '") + phantom.WireAt(i).name + "'";
  }
  return text;
}

/// What was read, with the time of each image.
struct WireImages {
  std::vector<WireImage> images;
  std::vector<double> time_s;
};

/// Rows of one time are one image.
WireImages ImagesOf(const PointTable& points, const WirePhantom& phantom,
                    const Isometry3d& reference_from_phantom) {
  const CsvTable& table = points.table;
  const auto names = table.Texts("wire");
  std::map<std::int64_t, std::size_t> image_at;
  WireImages result;
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    const auto wire = phantom.IndexOf(names[row]);
    ACUS_REQUIRE(wire, table.Where(row), ": the phantom has no wire '", names[row], "'; it has ",
                 WireNames(phantom));
    if (!points.reference_from_probe[row]) continue;
    const Isometry3d pose = points.reference_from_probe[row]->inverse() * reference_from_phantom;
    const auto [found, is_new] = image_at.try_emplace(points.time_ns[row], result.images.size());
    if (is_new) {
      result.images.push_back({pose, {}});
      result.images.back().points_px.resize(phantom.num_wires());
      result.time_s.push_back(points.Seconds(row));
    }
    WireImage& image = result.images[found->second];
    ACUS_REQUIRE(image.probe_from_phantom.isApprox(pose, 1e-9), table.Where(row),
                 ": the pose differs from that of another row of the same time; the points of an "
                 "image have one pose");
    ACUS_REQUIRE(!image.points_px[*wire], table.Where(row), ": wire '", names[row],
                 "' is there twice at ", points.Seconds(row), " s");
    image.points_px[*wire] = points.point_px[row];
  }
  return result;
}

Isometry3d PhantomPose(const ProbeTask& task, const WirePhantom& phantom, RunContext& context,
                       std::string& text) {
  if (!task.phantom_pose.empty()) {
    context.provenance.AddInput(task.phantom_pose);
    return transforms::ReadTransform(task.phantom_pose);
  }
  if (phantom.reference_from_phantom) return *phantom.reference_from_phantom;
  text +=
      "note: the wires are taken to be in the frame of the poses, since there is no "
      "PhantomToReference; --phantom-pose gives it\n";
  return Isometry3d::Identity();
}

/// A calibration and what its points are called.
struct Named {
  ProbeCalibration calibration;
  std::vector<std::string> wires;  ///< By PointResidual::wire.
  std::vector<double> time_s;      ///< By PointResidual::image.
};

Named FromWires(const ProbeTask& task, const PointTable& points,
                const ProbeCalibrationSettings& settings, RunContext& context, std::string& text) {
  context.provenance.AddInput(task.phantom);
  const WirePhantom phantom = ReadWirePhantom(task.phantom);
  const auto images = ImagesOf(points, phantom, PhantomPose(task, phantom, context, text));
  Named named{CalibrateByWires(phantom, images.images, settings), {}, images.time_s};
  for (std::size_t i = 0; i < phantom.num_wires(); ++i) {
    named.wires.push_back(phantom.WireAt(i).name);
  }
  return named;
}

Named FromStylus(const ProbeTask& task, const PointTable& points,
                 const ProbeCalibrationSettings& settings) {
  ACUS_REQUIRE(
      points.table.Has("tip_x_mm"), task.points.string(),
      ": has no places of a stylus (tip_x_mm, tip_y_mm, tip_z_mm); for points of wires, name "
      "the phantom by --phantom");
  const auto columns = NumberColumns(points.table, {"tip_x_mm", "tip_y_mm", "tip_z_mm"});
  std::vector<SeenPoint> seen;
  Named named{{}, {"tip"}, {}};
  for (std::size_t row = 0; row < points.table.num_rows(); ++row) {
    if (!points.reference_from_probe[row]) continue;
    const Vector3d tip_mm(columns[0][row], columns[1][row], columns[2][row]);
    seen.push_back({points.point_px[row], points.reference_from_probe[row]->inverse() * tip_mm});
    named.time_s.push_back(points.Seconds(row));
  }
  named.calibration = CalibrateByPoints(seen, settings);
  return named;
}

/// Points of one wire.
struct WireSummary {
  std::string name;
  std::size_t num_points = 0;
  std::size_t num_excluded = 0;
  double squares = 0.0;

  double RmsMm() const {
    const std::size_t used = num_points - num_excluded;
    return used == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(used));
  }
};

std::vector<WireSummary> Summaries(const Named& named) {
  std::vector<WireSummary> all;
  for (const std::string& name : named.wires) all.push_back({name});
  for (const PointResidual& point : named.calibration.residuals) {
    WireSummary& wire = all.at(point.wire);
    ++wire.num_points;
    if (!point.used) ++wire.num_excluded;
    if (point.used) wire.squares += point.residual_mm.head<2>().squaredNorm();
  }
  return all;
}

std::string OutlierText(const Named& named) {
  std::string text;
  std::size_t count = 0;
  for (const PointResidual& point : named.calibration.residuals) {
    if (point.used || ++count > kMostNamed) continue;
    text += Message("excluded: '", named.wires[point.wire], "' at ", named.time_s[point.image],
                    " s, ", FixedText(point.residual_mm.norm(), 2), " mm off\n");
  }
  if (count > kMostNamed) text += Message("excluded: ", count - kMostNamed, " more\n");
  return text;
}

std::string CornerTable(const ProbeCalibration& result, double confidence) {
  std::vector<std::vector<std::string>> rows;
  for (const PixelError& corner : result.corners) {
    rows.push_back({Message(corner.point_px.x(), ", ", corner.point_px.y()),
                    FixedText(corner.sd_mm.x(), 3), FixedText(corner.sd_mm.y(), 3),
                    FixedText(corner.sd_mm.z(), 3), FixedText(corner.bound_mm, 3)});
  }
  return TextTable({"corner px", "SD along columns mm", "along rows mm", "out of plane mm",
                    Message(100.0 * confidence, " % below mm")},
                   rows);
}

std::string Text(const Named& named, double confidence) {
  const ProbeCalibration& result = named.calibration;
  std::vector<std::vector<std::string>> rows;
  for (const WireSummary& wire : Summaries(named)) {
    rows.push_back({wire.name, Message(wire.num_points), Message(wire.num_excluded),
                    FixedText(wire.RmsMm(), 3)});
  }
  return TextTable({"point", "seen", "excluded", "in plane mm RMS"}, rows) +
         Message("\npixel           ", FixedText(result.mm_per_px.x(), 5), " x ",
                 FixedText(result.mm_per_px.y(), 5), " mm (+-",
                 FixedText(result.mm_per_px_half_width.x(), 5), ", ",
                 FixedText(result.mm_per_px_half_width.y(), 5), ")\npixel (0, 0)    ",
                 VectorText(result.probe_from_image.translation(), 3),
                 " mm in the frame of the probe's marker\nin plane        ",
                 FixedText(result.in_plane_rms_mm, 3), " mm RMS\nout of plane    ",
                 FixedText(result.out_of_plane_rms_mm, 3), " mm RMS\nimages          ",
                 result.num_images, "\n\n") +
         CornerTable(result, confidence) + OutlierText(named);
}

json PairOf(const Vector2d& v) {
  return {v.x(), v.y()};
}

json ToJson(const Named& named, double confidence) {
  const ProbeCalibration& result = named.calibration;
  json rows = json::array();
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector4d row = result.ImageToProbe().row(i);
    rows.push_back({row[0], row[1], row[2], row[3]});
  }
  json wires = json::array();
  for (const WireSummary& wire : Summaries(named)) {
    wires.push_back({{"name", wire.name},
                     {"num_points", wire.num_points},
                     {"num_excluded", wire.num_excluded},
                     {"in_plane_rms_mm", wire.RmsMm()}});
  }
  json points = json::array();
  for (const PointResidual& point : result.residuals) {
    points.push_back({{"time_s", named.time_s[point.image]},
                      {"name", named.wires[point.wire]},
                      {"residual_mm", config::Row(point.residual_mm)},
                      {"used", point.used}});
  }
  json corners = json::array();
  for (const PixelError& corner : result.corners) {
    corners.push_back({{"pixel", PairOf(corner.point_px)},
                       {"sd_mm", config::Row(corner.sd_mm)},
                       {"bound_mm", corner.bound_mm}});
  }
  return {{"format", "acus-probe-calibration/1"},
          {"image_to_probe", rows},
          {"probe_from_image", config::MatrixRows(result.probe_from_image)},
          {"mm_per_px", PairOf(result.mm_per_px)},
          {"mm_per_px_half_width", PairOf(result.mm_per_px_half_width)},
          {"in_plane_rms_mm", result.in_plane_rms_mm},
          {"out_of_plane_rms_mm", result.out_of_plane_rms_mm},
          {"num_images", result.num_images},
          {"constraint", result.constraint},
          {"confidence", confidence},
          {"wires", wires},
          {"corners", corners},
          {"points", points}};
}

report::Plot ResidualsByWire(const Named& named) {
  std::vector<double> rms_mm;
  for (const WireSummary& wire : Summaries(named)) rms_mm.push_back(wire.RmsMm());
  return report::ResidualPlot("In-plane residuals, RMS", named.wires, rms_mm);
}

}  // namespace

std::string Run(const ProbeTask& task, const fs::path& folder, RunContext& context) {
  ProbeCalibrationSettings settings = task.settings;
  if (!task.image_px.empty()) settings.image_px = {task.image_px[0], task.image_px[1]};
  const PointTable points = ReadPointTable(task, context);
  std::string text;
  const Named named = task.phantom.empty() ? FromStylus(task, points, settings)
                                           : FromWires(task, points, settings, context, text);
  const ProbeCalibration& result = named.calibration;
  AtomicFolder output(folder, context.overwrite);
  WriteResult(output.path(), ToJson(named, settings.confidence), context);
  session::WritePlusCalibration(output.path() / "image_to_probe.xml", "Image", "Probe",
                                result.ImageToProbe(),
                                std::hypot(result.in_plane_rms_mm, result.out_of_plane_rms_mm));
  transforms::WriteTransform(output.path() / "probe_from_image.tfm", result.probe_from_image,
                             "probe_from_image: takes points of the image (mm from pixel 0, 0) to "
                             "the probe's marker (mm)");
  report::WriteSvg(output.path() / "residuals.svg", ResidualsByWire(named));
  output.Commit();
  return text + Text(named, settings.confidence);
}

}  // namespace acus::registration
