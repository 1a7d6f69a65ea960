#include "acus/imaging/acoustics/probe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/plus_simulator.h"

namespace acus::acoustics {
namespace {

using nlohmann::json;

/// How far the outermost lines of a curved face start above its middle.
double SagMm(const Probe& probe) {
  return probe.radius_mm * (1.0 - std::cos(0.5 * probe.field_of_view_rad));
}

int SamplesOf(const Probe& probe, double step_mm) {
  return static_cast<int>(std::floor(probe.depth_mm / step_mm + 1e-9)) + 1;
}

ScanGrid LinearGrid(const Probe& probe) {
  const image::ImageGeometry image = ImageOf(probe);
  const double pitch_mm = image.lateral_mm_per_px;
  int columns = static_cast<int>(std::floor(probe.width_mm / pitch_mm + 1e-9));
  columns = std::clamp(columns, 1, image.width_px);
  // As many black columns on the left as on the right.
  if ((image.width_px - columns) % 2 != 0) columns += columns > 1 ? -1 : 1;
  ScanGrid grid;
  grid.step_mm = image.axial_mm_per_px;
  const int above = RowsAboveFace(image);
  grid.samples = std::min(image.height_px - above, SamplesOf(probe, grid.step_mm));
  for (int c = 0; c < columns; ++c) {
    grid.start_mm.emplace_back((c - 0.5 * (columns - 1)) * pitch_mm, 0.0);
    grid.direction.emplace_back(0.0, 1.0);
  }
  return grid;
}

ScanGrid FanGrid(const Probe& probe, int samples, double step_mm) {
  ScanGrid grid;
  grid.step_mm = step_mm;
  grid.samples = samples;
  for (int l = 0; l < probe.scan_lines; ++l) {
    const double angle =
        probe.field_of_view_rad * (static_cast<double>(l) / (probe.scan_lines - 1) - 0.5);
    const Eigen::Vector2d direction(std::sin(angle), std::cos(angle));
    grid.start_mm.emplace_back(probe.radius_mm * direction - Eigen::Vector2d(0.0, probe.radius_mm));
    grid.direction.push_back(direction);
  }
  return grid;
}

/// Turns all lines about their starts.
void Lean(double steer_rad, ScanGrid& grid) {
  if (steer_rad == 0.0) return;
  const Eigen::Vector2d turn(std::cos(steer_rad), std::sin(steer_rad));
  for (Eigen::Vector2d& d : grid.direction) {
    d = {d.x() * turn.x() + d.y() * turn.y(), d.y() * turn.x() - d.x() * turn.y()};
  }
}

Probe FromJson(const json& document) {
  Probe probe;
  probe.name = document.at("name");
  const std::string kind = document.at("kind");
  probe.kind = kind == "linear"   ? ProbeKind::kLinear
               : kind == "phased" ? ProbeKind::kPhased
                                  : ProbeKind::kCurvilinear;
  probe.scan_lines = document.at("scan_lines");
  probe.samples_per_line = document.at("samples_per_line");
  probe.frequency_mhz = document.at("frequency_mhz");
  probe.depth_mm = document.at("depth_mm");
  probe.image_width_px = document.at("image_width_px");
  probe.image_height_px = document.at("image_height_px");
  probe.slice_thickness_mm = document.at("slice_thickness_mm");
  probe.pulse_length_mm = document.at("pulse_length_mm");
  probe.beam_width_mm = document.at("beam_width_mm");
  probe.focus_mm = document.at("focus_mm");
  probe.dynamic_range_db = document.at("dynamic_range_db");
  probe.gain_db = document.at("gain_db");
  probe.tgc_db_per_cm = document.at("tgc_db_per_cm");
  probe.fractional_bandwidth = document.at("fractional_bandwidth");
  probe.elements = document.at("elements");
  probe.pitch_mm = document.at("pitch_mm");
  probe.f_number = document.at("f_number");
  probe.elevation_aperture_mm = document.at("elevation_aperture_mm");
  probe.elevation_focus_mm = document.at("elevation_focus_mm");
  return probe;
}

}  // namespace

double Probe::ArrayLengthMm() const {
  return kind == ProbeKind::kCurvilinear ? radius_mm * field_of_view_rad : width_mm;
}

Probe DefaultProbe() {
  const json smallest = {{"format", "acus-probe/1"},
                         {"name", "default"},
                         {"kind", "linear"},
                         {"frequency_mhz", 5},
                         {"depth_mm", 60}};
  return FromJson(config::CheckedConfig(smallest, "acus-probe", "default probe"));
}

Probe ReadProbe(const std::filesystem::path& path) {
  if (IsPlusConfiguration(path)) return ReadPlusProbe(path);
  const json document = config::ReadConfig(path, "acus-probe");
  Probe probe = FromJson(document);
  const auto need = [&](const char* key) {
    ACUS_REQUIRE(document.contains(key), path.string(), ": /", key, ": missing; a ",
                 document.at("kind").get<std::string>(), " probe needs it");
    return document.at(key).get<double>();
  };
  if (probe.kind != ProbeKind::kCurvilinear) probe.width_mm = need("width_mm");
  if (probe.kind == ProbeKind::kCurvilinear) probe.radius_mm = need("radius_mm");
  if (probe.kind != ProbeKind::kLinear) {
    probe.field_of_view_rad = need("field_of_view_deg") * std::numbers::pi / 180.0;
  }
  const double elements_mm = probe.pitch_mm * probe.elements;
  ACUS_REQUIRE(elements_mm <= 1.1 * probe.ArrayLengthMm() + 1e-9, path.string(),
               ": /pitch_mm: ", probe.elements, " elements with a pitch of ", probe.pitch_mm,
               " mm are longer than the face (", probe.ArrayLengthMm(),
               " mm); give a smaller pitch, fewer elements or a longer face");
  return probe;
}

const Probe& CheckedProbe(const Probe& probe) {
  constexpr int kMinPx = 16;
  constexpr int kMaxPx = 4096;
  ACUS_REQUIRE(probe.image_width_px >= kMinPx && probe.image_width_px <= kMaxPx &&
                   probe.image_height_px >= kMinPx && probe.image_height_px <= kMaxPx,
               "probe: image of ", probe.image_width_px, " x ", probe.image_height_px,
               " pixels; allowed is ", kMinPx, " to ", kMaxPx, " each way");
  ACUS_REQUIRE(probe.depth_mm > 0.0 && std::isfinite(probe.depth_mm), "probe: depth ",
               probe.depth_mm, " mm; it must be above 0");
  if (probe.kind == ProbeKind::kLinear) {
    ACUS_REQUIRE(probe.width_mm > 0.0 && std::isfinite(probe.width_mm), "probe: width ",
                 probe.width_mm, " mm; it must be above 0");
  } else {
    const bool round = probe.kind == ProbeKind::kCurvilinear;
    ACUS_REQUIRE((round ? probe.radius_mm > 0.0 : probe.radius_mm == 0.0) &&
                     std::isfinite(probe.radius_mm) && probe.field_of_view_rad > 0.0 &&
                     probe.field_of_view_rad < 3.0 && probe.scan_lines >= kMinPx &&
                     probe.scan_lines <= kMaxPx,
                 "probe: radius ", probe.radius_mm, " mm, field of view ", probe.field_of_view_rad,
                 " rad, ", probe.scan_lines, " lines; allowed is above 0 (phased: 0), 0 to 3, ",
                 kMinPx, " to ", kMaxPx);
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
  if (probe.kind != ProbeKind::kCurvilinear) return probe.width_mm;
  return 2.0 * probe.radius_mm * std::sin(0.5 * probe.field_of_view_rad);
}

double FaceRadiusMm(const Probe& probe) {
  return probe.kind != ProbeKind::kCurvilinear ? 0.0 : probe.radius_mm;
}

image::ImageGeometry ImageOf(const Probe& probe) {
  if (probe.image) return *probe.image;
  double width_mm = probe.width_mm;
  double height_mm = probe.depth_mm;
  double top_mm = 0.0;
  if (probe.kind != ProbeKind::kLinear) {
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

int RowsAboveFace(const image::ImageGeometry& image) {
  return static_cast<int>(
      std::lround(std::max(0.0, -image.depth_of_top_row_mm / image.axial_mm_per_px)));
}

double ScanGrid::LateralSpacingMm(int k) const {
  const Eigen::Vector2d a = start_mm[0] + k * step_mm * direction[0];
  const Eigen::Vector2d b = start_mm[1] + k * step_mm * direction[1];
  return (b - a).norm();
}

ScanGrid ScanGridOf(const Probe& probe) {
  if (probe.kind == ProbeKind::kLinear) return LinearGrid(probe);
  const double step_mm = ImageOf(probe).axial_mm_per_px;
  return FanGrid(probe, SamplesOf(probe, step_mm), step_mm);
}

ScanGrid BeamGridOf(const Probe& probe) {
  ACUS_REQUIRE(probe.scan_lines >= 2 && probe.samples_per_line >= 2 && probe.depth_mm > 0.0,
               "probe: ", probe.scan_lines, " lines of ", probe.samples_per_line, " samples over ",
               probe.depth_mm, " mm; give 2 or more of each and a depth above 0");
  const double step_mm = probe.depth_mm / (probe.samples_per_line - 1);
  ScanGrid grid;
  if (probe.kind != ProbeKind::kLinear) {
    grid = FanGrid(probe, probe.samples_per_line, step_mm);
    Lean(probe.steer_rad, grid);
    return grid;
  }
  grid.samples = probe.samples_per_line;
  grid.step_mm = step_mm;
  for (int l = 0; l < probe.scan_lines; ++l) {
    const double place = static_cast<double>(l) / (probe.scan_lines - 1) - 0.5;
    grid.start_mm.emplace_back(place * probe.width_mm, 0.0);
    grid.direction.emplace_back(0.0, 1.0);
  }
  Lean(probe.steer_rad, grid);
  return grid;
}

BeamPlace PlaceInBeams(const Probe& probe, const ScanGrid& grid, const Eigen::Vector2d& place_mm) {
  const double sine = std::sin(probe.steer_rad);
  const double cosine = std::cos(probe.steer_rad);
  const double middle = 0.5 * (grid.lines() - 1);
  if (probe.kind == ProbeKind::kLinear) {
    const double line_mm = probe.width_mm / (grid.lines() - 1);
    const double range_mm = place_mm.y() / cosine;
    return {(place_mm.x() - range_mm * sine) / line_mm + middle, range_mm / grid.step_mm};
  }
  // In the triangle centre of the face, start of the line, place: R^2 + r^2 + 2 R r cos = rho^2.
  const double line_rad = probe.field_of_view_rad / (grid.lines() - 1);
  const double y_mm = place_mm.y() + probe.radius_mm;
  const double from_centre_mm = std::hypot(place_mm.x(), y_mm);
  const double aside_mm = probe.radius_mm * sine;
  const double range_mm =
      std::sqrt(std::max(0.0, from_centre_mm * from_centre_mm - aside_mm * aside_mm)) -
      probe.radius_mm * cosine;
  const double turned =
      std::asin(std::clamp(range_mm * sine / std::max(from_centre_mm, 1e-9), -1.0, 1.0));
  return {(std::atan2(place_mm.x(), y_mm) - turned) / line_rad + middle, range_mm / grid.step_mm};
}

ScanGrid ScanGridOf(const image::ImageGeometry& image) {
  constexpr int kMaxPx = 8192;
  ACUS_REQUIRE(image.width_px >= 1 && image.height_px >= 1 && image.width_px <= kMaxPx &&
                   image.height_px <= kMaxPx,
               "image: ", image.width_px, " x ", image.height_px, " pixels; allowed is 1 to ",
               kMaxPx, " each way");
  ACUS_REQUIRE(image.lateral_mm_per_px > 0.0 && image.axial_mm_per_px > 0.0 &&
                   std::isfinite(image.lateral_mm_per_px) && std::isfinite(image.axial_mm_per_px) &&
                   std::isfinite(image.depth_of_top_row_mm),
               "image: a pixel is ", image.lateral_mm_per_px, " x ", image.axial_mm_per_px,
               " mm; both must be above 0");
  ScanGrid grid;
  grid.step_mm = image.axial_mm_per_px;
  grid.samples = image.height_px;
  for (int c = 0; c < image.width_px; ++c) {
    grid.start_mm.emplace_back((c - 0.5 * (image.width_px - 1)) * image.lateral_mm_per_px,
                               image.depth_of_top_row_mm);
    grid.direction.emplace_back(0.0, 1.0);
  }
  return grid;
}

}  // namespace acus::acoustics
