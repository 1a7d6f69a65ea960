// Targets with a known answer for the beam model of the ultrasound: labelled blocks, a table of
// acoustics made for them, and probes whose lines are as fine as the question needs.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "acus/imaging/ultrasound/beams/beam_renderer.h"

namespace acus::testing_support {

/// Voxel (i, j, k) has its centre at ((i + 0.5), (j + 0.5), (k + 0.5)) * spacing: borders between
/// labels lie at multiples of the spacing.
template <typename LabelAt>
volume::LabelMap LabelledBlock(const Eigen::Array3i& size, double spacing_mm,
                               const std::map<volume::Label, std::string>& names,
                               const LabelAt& label_at) {
  volume::Geometry geometry;
  geometry.size = size;
  geometry.spacing_mm.setConstant(spacing_mm);
  geometry.origin_mm.setConstant(0.5 * spacing_mm);
  volume::LabelMap labels(geometry);
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        labels.At(i, j, k) =
            label_at((i + 0.5) * spacing_mm, (j + 0.5) * spacing_mm, (k + 0.5) * spacing_mm);
      }
    }
  }
  labels.names = names;
  return labels;
}

/// Neither loss nor scatterers, unless said otherwise.
inline acoustics::TissueAcoustics Clear(double speed_m_per_s = 1540.0,
                                        double impedance_mrayl = 1.6) {
  acoustics::TissueAcoustics tissue;
  tissue.speed_m_per_s = speed_m_per_s;
  tissue.impedance_mrayl = impedance_mrayl;
  tissue.attenuation_db_per_cm_mhz = 0.0;
  tissue.attenuation_along_fibres_db_per_cm_mhz = 0.0;
  tissue.backscatter_db = -200.0;
  return tissue;
}

inline acoustics::TissueAcoustics Scattering(double backscatter_db = -30.0) {
  acoustics::TissueAcoustics tissue = Clear();
  tissue.backscatter_db = backscatter_db;
  return tissue;
}

inline acoustics::TissueAcousticsTable TableOf(
    std::map<std::string, acoustics::TissueAcoustics> tissues) {
  acoustics::TissueAcousticsTable table{
      .name = "targets", .file = "targets", .tissues = std::move(tissues), .by_hu = {}};
  table.tissues["water"] = Clear();
  table.by_hu = {{0.0, "water"}};
  return table;
}

/// 5 MHz, a line each 0.2 mm, a sample each 0.1 mm, focus at 20 mm, F-number 2.
inline acoustics::Probe TargetProbe() {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.frequency_mhz = 5.0;
  probe.fractional_bandwidth = 0.6;
  probe.width_mm = 25.6;
  probe.scan_lines = 129;
  probe.samples_per_line = 401;
  probe.depth_mm = 40.0;
  probe.focus_mm = 20.0;
  probe.f_number = 2.0;
  probe.image_width_px = 256;
  probe.image_height_px = 400;
  probe.dynamic_range_db = 60.0;
  return probe;
}

/// All more expensive effects off, and nothing but the lines.
inline ultrasound::BeamOptions Bare() {
  ultrasound::BeamOptions options;
  options.interfaces = options.angle = options.attenuation = options.shadow = false;
  options.comet_tail = options.speckle = options.fibre_texture = options.point_spread = false;
  options.needle_shadow = false;
  options.diffuse_share = 0.0;  // No lobe: what is left of the angle is Fresnel's.
  options.lobe_deg = 89.9;
  return options;
}

/// Face along +x at y = 0, beams along +y; turned by an angle towards +x.
inline Eigen::Isometry3d FaceAt(double x_mm, double y_mm, double z_mm, double turn_rad = 0.0) {
  return Eigen::Translation3d(x_mm, y_mm, z_mm) *
         Eigen::AngleAxisd(-turn_rad, Eigen::Vector3d::UnitZ());
}

inline double Db(double amplitude) {
  return 20.0 * std::log10(amplitude);
}

/// Mean over lines of the squared envelope of sample k.
inline double MeanIntensity(const slicing::BeamImage& envelope, int k, int first_line,
                            int end_line) {
  double sum = 0.0;
  for (int l = first_line; l < end_line; ++l) {
    sum += double{envelope.row(k)[l]} * envelope.row(k)[l];
  }
  return sum / (end_line - first_line);
}

struct Fit {
  double offset = 0.0;
  double slope = 0.0;
};

inline Fit StraightLine(const std::vector<double>& x, const std::vector<double>& y) {
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    mean_x += x[n] / static_cast<double>(x.size());
    mean_y += y[n] / static_cast<double>(x.size());
  }
  double xx = 0.0;
  double xy = 0.0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    xx += (x[n] - mean_x) * (x[n] - mean_x);
    xy += (x[n] - mean_x) * (y[n] - mean_y);
  }
  return {.offset = mean_y - xy / xx * mean_x, .slope = xy / xx};
}

}  // namespace acus::testing_support
