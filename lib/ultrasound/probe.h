// Ultrasound probes: what they are, where their scan lines run, and how large their picture is.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "ultrasound/image.h"

namespace acus::ultrasound {

enum class ProbeKind { kLinear, kCurvilinear };

/// As in configs/schema/acus-probe.schema.json, where the ranges and defaults are.
struct Probe {
  std::string name;
  ProbeKind kind = ProbeKind::kLinear;
  double frequency_mhz = 0.0;
  int scan_lines = 0;              ///< Curvilinear only: a linear probe has one line per column.
  double width_mm = 0.0;           ///< Linear only: length of the face.
  double radius_mm = 0.0;          ///< Curvilinear only: of the face.
  double field_of_view_rad = 0.0;  ///< Curvilinear only: between the outermost lines.
  double depth_mm = 0.0;           ///< Of the last row below the face.
  int image_width_px = 0;
  int image_height_px = 0;
  double slice_thickness_mm = 0.0;  ///< A needle is seen within half of this from the plane.
  double pulse_length_mm = 0.0;     ///< Hanning window along the beam; 0 = none.
  double beam_width_mm = 0.0;       ///< Hanning window across the beams; 0 = none.
  double focus_mm = 0.0;            ///< Depth of the focus mark. Only drawn.
  double dynamic_range_db = 0.0;
  double gain_db = 0.0;
  double tgc_db_per_cm = 0.0;  ///< Gain that grows with depth.
};

/// Reads configs/probes/<name>.json (format acus-probe/1).
/// @throws InputError listing all problems, or naming the size that its kind of probe lacks.
Probe ReadProbe(const std::filesystem::path& path);

/// The same probe. Probes are also made in code, past the schema: here is what images rely on.
/// @throws InputError naming the first value that is out of range.
const Probe& CheckedProbe(const Probe& probe);

/// The face as far as the skin feels it: its length as the crow flies, and its radius (0: flat).
double FaceLengthMm(const Probe& probe);
double FaceRadiusMm(const Probe& probe);

/// Pixels are square. The depth fills the height; a picture wider than the probe has black sides.
/// If the probe is wider than the picture, pixels grow until it fits.
ImageGeometry PictureOf(const Probe& probe);

/// Where echoes are computed: straight lines with equal steps, in the probe's plane.
struct ScanGrid {
  std::vector<Eigen::Vector2d> start_mm;   ///< First sample (x, y) of each line, on the face.
  std::vector<Eigen::Vector2d> direction;  ///< Unit, of each line.
  int samples = 0;                         ///< Per line.
  double step_mm = 0.0;                    ///< Between the samples of a line.

  int lines() const { return static_cast<int>(start_mm.size()); }
  /// Distance of neighbouring lines at sample `k`. @pre lines() >= 2.
  double LateralSpacingMm(int k) const;
};

/// One line per column that the probe's face covers (linear), or a fan of scan_lines lines.
ScanGrid ScanGridOf(const Probe& probe);

/// Every pixel of a picture, one line per column.
ScanGrid ScanGridOf(const ImageGeometry& picture);

}  // namespace acus::ultrasound
