// Ultrasound probes: what they are, where their scan lines run, and how large their image is.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/data/image/image.h"

namespace acus::acoustics {

/// kPhased: a small flat face that steers; all lines start at its middle.
enum class ProbeKind { kLinear, kCurvilinear, kPhased };

/// As in configs/schema/acus-probe.schema.json, where the ranges and defaults are.
struct Probe {
  std::string name;
  ProbeKind kind = ProbeKind::kLinear;
  double frequency_mhz = 0.0;
  int scan_lines = 0;        ///< In the 2010 model a linear probe has one line per column instead.
  int samples_per_line = 0;  ///< Beam model. The 2010 model has one per row of the image.
  double width_mm = 0.0;     ///< Linear and phased: length of the face.
  double radius_mm = 0.0;    ///< Curvilinear: of the face. 0 for others.
  double field_of_view_rad = 0.0;  ///< Curvilinear and phased: between the outermost lines.
  double depth_mm = 0.0;           ///< Of the last row below the face.
  int image_width_px = 0;
  int image_height_px = 0;
  double slice_thickness_mm = 0.0;  ///< 2010: a needle is seen within half of it from the plane.
  double pulse_length_mm = 0.0;     ///< 2010: Hanning window along the beam; 0 = none.
  double beam_width_mm = 0.0;       ///< 2010: Hanning window across the beams; 0 = none.
  double focus_mm = 0.0;  ///< Depth where transmitted beams are narrowest, and of the focus mark.
  double dynamic_range_db = 0.0;
  double gain_db = 0.0;
  double tgc_db_per_cm = 0.0;  ///< Gain that grows with depth.

  // What the widths of pulse and beam follow from (beam_width.h). Not read by the 2010 model.
  double fractional_bandwidth = 0.6;  ///< -6 dB of the echo's spectrum over the frequency.
  int elements = 128;
  double pitch_mm = 0.0;               ///< Between elements; 0: the face over their number.
  double f_number = 2.0;               ///< Depth over active aperture, until all elements work.
  double elevation_aperture_mm = 5.0;  ///< Height of the elements.
  double elevation_focus_mm = 0.0;     ///< Of the acoustic lens; 0: as focus_mm.

  /// If the layout of the image is given (PLUS): else it follows from depth and shape.
  std::optional<image::ImageGeometry> image{};

  // What a display preset does to the beams; files of probes do not have it.
  /// Linear and curvilinear: lines lean by this from the normal of the face, towards +x.
  double steer_rad = 0.0;
  bool second_harmonic = false;  ///< Echoes are received at twice the frequency.

  /// Linear and phased: of the flat face; curvilinear: along the arc.
  double ArrayLengthMm() const;
};

/// Reads configs/probes/<name>.json (format acus-probe/1), or the ScanConversion of a PLUS
/// configuration (*.xml).
/// @throws InputError listing all problems, or naming the size that its kind of probe lacks.
Probe ReadProbe(const std::filesystem::path& path);

/// The same probe. Probes are also made in code, past the schema: here is what images rely on.
/// @throws InputError naming the first value that is out of range.
const Probe& CheckedProbe(const Probe& probe);

/// The face as far as the skin feels it: its length as the crow flies, and its radius (0: flat).
double FaceLengthMm(const Probe& probe);
double FaceRadiusMm(const Probe& probe);

/// The defaults of the schema, without a shape.
Probe DefaultProbe();

/// Unless the probe says otherwise, pixels are square. The depth fills the height; an image wider
/// than the probe has black sides. If the probe is wider than the image, pixels grow until it
/// fits.
image::ImageGeometry ImageOf(const Probe& probe);

/// Rows of the image above depth 0.
int RowsAboveFace(const image::ImageGeometry& image);

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

/// The beam model's lines: scan_lines over the width or the angle of the probe, each with
/// samples_per_line from the face to depth_mm along it. They lean by steer_rad.
ScanGrid BeamGridOf(const Probe& probe);

/// Line and sample of a place (probe's plane, mm) in a grid of BeamGridOf: neither is whole, and
/// both may lie outside the grid. @pre the probe is not phased, or not steered.
struct BeamPlace {
  double line = 0.0;
  double sample = 0.0;
};
BeamPlace PlaceInBeams(const Probe& probe, const ScanGrid& grid, const Eigen::Vector2d& place_mm);

/// Every pixel of an image, one line per column.
ScanGrid ScanGridOf(const image::ImageGeometry& image);

}  // namespace acus::acoustics
