#include "ultrasound/probe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/json_file.h"
#include "core/error.h"

namespace acus::ultrasound {
namespace {

/// How far the outermost lines of a curved face start above its middle.
double SagMm(const Probe& probe) {
  return probe.radius_mm * (1.0 - std::cos(0.5 * probe.field_of_view_rad));
}

int SamplesOf(const Probe& probe, double step_mm) {
  return static_cast<int>(std::floor(probe.depth_mm / step_mm + 1e-9)) + 1;
}

ScanGrid LinearGrid(const Probe& probe) {
  const ImageGeometry picture = PictureOf(probe);
  const double pitch_mm = picture.lateral_mm_per_px;
  int columns = static_cast<int>(std::floor(probe.width_mm / pitch_mm + 1e-9));
  columns = std::clamp(columns, 1, picture.width_px);
  // As many black columns on the left as on the right.
  if ((picture.width_px - columns) % 2 != 0) columns += columns > 1 ? -1 : 1;
  ScanGrid grid;
  grid.step_mm = picture.axial_mm_per_px;
  grid.samples = std::min(picture.height_px, SamplesOf(probe, grid.step_mm));
  for (int c = 0; c < columns; ++c) {
    grid.start_mm.emplace_back((c - 0.5 * (columns - 1)) * pitch_mm, 0.0);
    grid.direction.emplace_back(0.0, 1.0);
  }
  return grid;
}

ScanGrid FanGrid(const Probe& probe) {
  ScanGrid grid;
  grid.step_mm = PictureOf(probe).axial_mm_per_px;
  grid.samples = SamplesOf(probe, grid.step_mm);
  for (int l = 0; l < probe.scan_lines; ++l) {
    const double angle =
        probe.field_of_view_rad * (static_cast<double>(l) / (probe.scan_lines - 1) - 0.5);
    const Eigen::Vector2d direction(std::sin(angle), std::cos(angle));
    grid.start_mm.emplace_back(probe.radius_mm * direction - Eigen::Vector2d(0.0, probe.radius_mm));
    grid.direction.push_back(direction);
  }
  return grid;
}

}  // namespace

Probe ReadProbe(const std::filesystem::path& path) {
  const auto json = config::ReadConfig(path, "acus-probe");
  const auto need = [&](const char* key, const char* kind) {
    ACUS_REQUIRE(json.contains(key), path.string(), ": /", key, ": missing; a ", kind,
                 " probe needs it");
    return json.at(key).get<double>();
  };
  Probe probe;
  probe.name = json.at("name");
  probe.kind = json.at("kind") == "linear" ? ProbeKind::kLinear : ProbeKind::kCurvilinear;
  if (probe.kind == ProbeKind::kLinear) {
    probe.width_mm = need("width_mm", "linear");
  } else {
    probe.radius_mm = need("radius_mm", "curvilinear");
    probe.field_of_view_rad = need("field_of_view_deg", "curvilinear") * std::numbers::pi / 180.0;
    probe.scan_lines = json.at("scan_lines");
  }
  probe.frequency_mhz = json.at("frequency_mhz");
  probe.depth_mm = json.at("depth_mm");
  probe.image_width_px = json.at("image_width_px");
  probe.image_height_px = json.at("image_height_px");
  probe.slice_thickness_mm = json.at("slice_thickness_mm");
  probe.pulse_length_mm = json.at("pulse_length_mm");
  probe.beam_width_mm = json.at("beam_width_mm");
  probe.focus_mm = json.at("focus_mm");
  probe.dynamic_range_db = json.at("dynamic_range_db");
  probe.gain_db = json.at("gain_db");
  probe.tgc_db_per_cm = json.at("tgc_db_per_cm");
  return probe;
}

const Probe& CheckedProbe(const Probe& probe) {
  constexpr int kMinPx = 16;
  constexpr int kMaxPx = 4096;
  ACUS_REQUIRE(probe.image_width_px >= kMinPx && probe.image_width_px <= kMaxPx &&
                   probe.image_height_px >= kMinPx && probe.image_height_px <= kMaxPx,
               "probe: picture of ", probe.image_width_px, " x ", probe.image_height_px,
               " pixels; allowed is ", kMinPx, " to ", kMaxPx, " each way");
  ACUS_REQUIRE(probe.depth_mm > 0.0 && std::isfinite(probe.depth_mm), "probe: depth ",
               probe.depth_mm, " mm; it must be above 0");
  if (probe.kind == ProbeKind::kLinear) {
    ACUS_REQUIRE(probe.width_mm > 0.0 && std::isfinite(probe.width_mm), "probe: width ",
                 probe.width_mm, " mm; it must be above 0");
  } else {
    ACUS_REQUIRE(probe.radius_mm > 0.0 && std::isfinite(probe.radius_mm) &&
                     probe.field_of_view_rad > 0.0 && probe.field_of_view_rad < 3.0 &&
                     probe.scan_lines >= kMinPx && probe.scan_lines <= kMaxPx,
                 "probe: radius ", probe.radius_mm, " mm, field of view ", probe.field_of_view_rad,
                 " rad, ", probe.scan_lines, " lines; allowed is above 0, 0 to 3, ", kMinPx, " to ",
                 kMaxPx);
  }
  ACUS_REQUIRE(probe.dynamic_range_db > 0.0 && probe.dynamic_range_db <= 120.0,
               "probe: dynamic range ", probe.dynamic_range_db, " dB; allowed is above 0 to 120");
  ACUS_REQUIRE(std::isfinite(probe.gain_db) && std::isfinite(probe.tgc_db_per_cm),
               "probe: its gain is not finite");
  ACUS_REQUIRE(
      probe.slice_thickness_mm >= 0.0 && probe.pulse_length_mm >= 0.0 && probe.beam_width_mm >= 0.0,
      "probe: slice thickness ", probe.slice_thickness_mm, " mm, pulse length ",
      probe.pulse_length_mm, " mm, beam width ", probe.beam_width_mm, " mm; none may be negative");
  return probe;
}

double FaceLengthMm(const Probe& probe) {
  if (probe.kind == ProbeKind::kLinear) return probe.width_mm;
  return 2.0 * probe.radius_mm * std::sin(0.5 * probe.field_of_view_rad);
}

double FaceRadiusMm(const Probe& probe) {
  return probe.kind == ProbeKind::kLinear ? 0.0 : probe.radius_mm;
}

ImageGeometry PictureOf(const Probe& probe) {
  double width_mm = probe.width_mm;
  double height_mm = probe.depth_mm;
  double top_mm = 0.0;
  if (probe.kind == ProbeKind::kCurvilinear) {
    top_mm = -SagMm(probe);
    height_mm = probe.depth_mm - top_mm;
    width_mm = 2.0 * (probe.radius_mm + probe.depth_mm) * std::sin(0.5 * probe.field_of_view_rad);
  }
  const double mm_per_px = std::max(height_mm / std::max(1, probe.image_height_px - 1),
                                    width_mm / std::max(1, probe.image_width_px));
  return {.width_px = probe.image_width_px,
          .height_px = probe.image_height_px,
          .lateral_mm_per_px = mm_per_px,
          .axial_mm_per_px = mm_per_px,
          .depth_of_top_row_mm = top_mm};
}

double ScanGrid::LateralSpacingMm(int k) const {
  const Eigen::Vector2d a = start_mm[0] + k * step_mm * direction[0];
  const Eigen::Vector2d b = start_mm[1] + k * step_mm * direction[1];
  return (b - a).norm();
}

ScanGrid ScanGridOf(const Probe& probe) {
  return probe.kind == ProbeKind::kLinear ? LinearGrid(probe) : FanGrid(probe);
}

ScanGrid ScanGridOf(const ImageGeometry& picture) {
  constexpr int kMaxPx = 8192;
  ACUS_REQUIRE(picture.width_px >= 1 && picture.height_px >= 1 && picture.width_px <= kMaxPx &&
                   picture.height_px <= kMaxPx,
               "picture: ", picture.width_px, " x ", picture.height_px, " pixels; allowed is 1 to ",
               kMaxPx, " each way");
  ACUS_REQUIRE(picture.lateral_mm_per_px > 0.0 && picture.axial_mm_per_px > 0.0 &&
                   std::isfinite(picture.lateral_mm_per_px) &&
                   std::isfinite(picture.axial_mm_per_px) &&
                   std::isfinite(picture.depth_of_top_row_mm),
               "picture: a pixel is ", picture.lateral_mm_per_px, " x ", picture.axial_mm_per_px,
               " mm; both must be above 0");
  ScanGrid grid;
  grid.step_mm = picture.axial_mm_per_px;
  grid.samples = picture.height_px;
  for (int c = 0; c < picture.width_px; ++c) {
    grid.start_mm.emplace_back((c - 0.5 * (picture.width_px - 1)) * picture.lateral_mm_per_px,
                               picture.depth_of_top_row_mm);
    grid.direction.emplace_back(0.0, 1.0);
  }
  return grid;
}

}  // namespace acus::ultrasound
