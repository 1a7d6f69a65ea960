// The recorded sweep over a leg (ultrasound/bone_leg of the shared data): frames, their tracked
// poses, and what stands for the scanner and the tissue in its simulation.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/acoustics/tissue_acoustics.h"

namespace acus::testing_support {

inline constexpr int kLegWidthPx = 950;
inline constexpr int kLegHeightPx = 811;
inline constexpr double kLegMmPerPx = 0.05392;

struct LegFrame {
  std::filesystem::path image;
  Eigen::Isometry3d ct_from_image;  ///< mm from the image's upper left corner, x along the face.
};

inline Eigen::Isometry3d LegPose(const Eigen::Vector3d& place_mm,
                                 const Eigen::Vector3d& euler_deg) {
  const Eigen::Vector3d angle = euler_deg * std::numbers::pi / 180.0;
  return Eigen::Translation3d(place_mm) * Eigen::AngleAxisd(angle.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(angle.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(angle.x(), Eigen::Vector3d::UnitX());
}

inline std::vector<LegFrame> LegFrames(const std::filesystem::path& folder) {
  const Eigen::Isometry3d marker_from_image =
      LegPose({26.44694442, -0.52572229, 128.00100047}, {92.48865621, -0.46874914, 179.2277322});
  std::vector<LegFrame> frames;
  std::ifstream in(folder / "sweep_initial.csv");
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    std::string time;
    double scale = 0.0;
    Eigen::Vector3d place;
    Eigen::Vector3d euler;
    row >> time >> scale >> place.x() >> place.y() >> place.z() >> euler.x() >> euler.y() >>
        euler.z();
    frames.push_back({.image = folder / "frames" / (time + ".png"),
                      .ct_from_image = LegPose(place, euler) * marker_from_image});
  }
  return frames;
}

/// The probe's frequency, gain, TGC and compression are not known: chosen so that the grey of soft
/// tissue and of bone at a right angle is that of every second frame.
inline acoustics::Probe LegProbe() {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.frequency_mhz = 7.5;
  probe.fractional_bandwidth = 0.7;
  probe.width_mm = kLegWidthPx * kLegMmPerPx;
  probe.depth_mm = kLegHeightPx * kLegMmPerPx;
  probe.scan_lines = 256;
  probe.samples_per_line = 1024;
  probe.focus_mm = probe.elevation_focus_mm = 20.0;
  probe.image_width_px = kLegWidthPx;
  probe.image_height_px = kLegHeightPx;
  probe.gain_db = 13.0;
  probe.tgc_db_per_cm = 5.0;
  probe.dynamic_range_db = 105.0;
  return probe;
}

/// One even soft tissue around the bone, under the name of muscle.
inline acoustics::TissueAcousticsTable LegTissues() {
  acoustics::TissueAcousticsTable table = acoustics::ReadTissueAcoustics(
      std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "acoustics" / "tissues.json");
  table.tissues.at("muscle").attenuation_db_per_cm_mhz = 0.6;
  table.tissues.at("muscle").backscatter_db = -50.0;
  return table;
}

}  // namespace acus::testing_support
