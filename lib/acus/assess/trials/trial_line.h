// The straight line of an insertion: its entry through the skin, its direction, its depth.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acus/assess/trials/trial_scene.h"

namespace acus::trials {

/// The last insertion of a trial, as a straight line in CT space.
struct TrialLine {
  Eigen::Vector3d entry_ct_mm;    ///< Where the shaft leaves the tissue.
  Eigen::Vector3d axis_in_ct;     ///< Unit, inwards.
  double depth_mm = 0.0;          ///< From the entry to the tip.
  double speed_mm_per_s = 0.0;    ///< Mean of the last pass, without rests at its ends.
  Eigen::Isometry3d ct_from_tip;  ///< Pose of the needle at its deepest point; +z is the axis.
  std::int64_t deepest_ns = 0;    ///< Time of that point.
  std::int64_t entry_ns = 0;      ///< Start of the last pass.
  // Axes of changes, unit vectors in CT space; along x across = inward.
  Eigen::Vector3d inward_in_ct;  ///< Normal of the skin at the entry.
  Eigen::Vector3d along_in_ct;   ///< In the skin, along the needle's tilt; see MakeSkinAxes.
  Eigen::Vector3d across_in_ct;  ///< In the skin, inward x along.
};

/// The line of the last pass of a trial (training::FindPasses).
/// @throws InputError if the needle never advanced in tissue by the exercise's turn_mm.
TrialLine LineOfTrial(const TrialScene& scene, const session::Session& trial);

/// The point where a line enters the body, along its direction: of the entries within 60 mm of
/// `near_ct_mm`, the nearest to it, exact to 1e-6 mm. Nothing if there is none.
/// @pre direction_in_ct is a unit vector.
std::optional<Eigen::Vector3d> EntryOfLine(const TrialScene& scene,
                                           const Eigen::Vector3d& near_ct_mm,
                                           const Eigen::Vector3d& direction_in_ct);

/// The skin's inward normal, from a plane through the entries of nine parallel lines 6 mm apart;
/// the direction itself if fewer than three of them enter the body.
Eigen::Vector3d SkinNormalInCt(const TrialScene& scene, const Eigen::Vector3d& entry_ct_mm,
                               const Eigen::Vector3d& direction_in_ct);

/// Sets along_in_ct and across_in_ct from inward_in_ct and axis_in_ct: along is the direction of
/// the needle's tilt in the skin. A needle within 6 degrees of the normal has no such direction:
/// then it is `other_in_ct`, projected into the skin.
void MakeSkinAxes(TrialLine& line, const Eigen::Vector3d& other_in_ct);

/// A direction in words of the patient, from LPS: "the left", "the head", "the back".
std::string PatientDirection(const Eigen::Vector3d& direction_in_ct);

}  // namespace acus::trials
