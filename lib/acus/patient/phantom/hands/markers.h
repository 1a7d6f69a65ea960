// Markers on the skin, as found in CT and as found on the mannequin.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/phantom/planning/insertion_plan.h"

namespace acus::phantom {

struct MarkerSettings {
  int count = 8;
  double radius_mm = 75.0;  ///< From the entry, along the skin.
  double fle_mm = 0.4;      ///< Root mean square length of the localisation error.
  Eigen::Isometry3d reference_from_ct = Eigen::Isometry3d::Identity();
};

struct NamedPoint {
  std::string name;
  Eigen::Vector3d position_mm;
};

/// Markers on the skin in a ring around the entry, at two distances, pulled in where the volume or
/// the body ends. @throws NoAnswerError if there is no skin for at least three.
std::vector<NamedPoint> PlaceMarkers(const PatientField& field, const InsertionPlan& plan,
                                     const MarkerSettings& settings, const RunContext& context);

/// The same markers as located on the mannequin: carried by reference_from_ct, each coordinate with
/// a normal error of fle_mm / sqrt(3). Depends on `seed`.
std::vector<NamedPoint> LocateOnMannequin(const std::vector<NamedPoint>& markers_ct,
                                          const MarkerSettings& settings, std::uint64_t seed);

/// CSV with columns name, x_mm, y_mm, z_mm; whole or not at all.
void WritePoints(const std::filesystem::path& path, const std::vector<NamedPoint>& points);

}  // namespace acus::phantom
