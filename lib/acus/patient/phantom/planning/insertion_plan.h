// Where a needle can go: straight paths from the skin to a target that keep clear of bone and gas.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/phantom/anatomy/patient_field.h"
#include "acus/patient/phantom/planning/body_frame.h"

namespace acus::phantom {

/// Where a probe would lie, seen from the entry, along the heading.
inline constexpr double kProbeAheadMm = 32.0;

struct PlanSettings {
  std::string target;                                   ///< Landmark, or empty: to be searched for.
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< Added to the landmark.
  Eigen::Vector3d approach = Eigen::Vector3d::UnitY();  ///< From target towards entry, CT.
  /// The image plane holds the needle and this axis (CT; 0 = the side to which the needle leans).
  Eigen::Vector3d image_axis = Eigen::Vector3d::Zero();
  double cone_rad = 0.6;             ///< Greatest angle between path and `approach`.
  std::vector<volume::Label> avoid;  ///< Tissues that the path must not meet.
  double clearance_mm = 1.5;         ///< Distance kept from them.
  double min_length_mm = 35.0;       ///< In tissue.
  double max_length_mm = 110.0;      ///< In tissue.
};

/// A straight insertion beside a probe. Vectors are unit, CT frame.
struct InsertionPlan {
  Eigen::Vector3d entry_ct_mm;
  Eigen::Vector3d target_ct_mm;
  Eigen::Vector3d direction;    ///< Into the body, from entry to target.
  Eigen::Vector3d skin_normal;  ///< At the entry, outwards, as seen in the image plane.
  Eigen::Vector3d heading;      ///< Along the skin in the image plane; there lies the probe.
  /// Turn about `bone_axis` (CT, through the entry) by which the needle would meet bone, and the
  /// depth at which it does.
  std::optional<double> bone_angle_rad;
  Eigen::Vector3d bone_axis = Eigen::Vector3d::UnitX();
  double bone_depth_mm = 0.0;

  double length_mm() const { return (target_ct_mm - entry_ct_mm).norm(); }
  /// Normal of the image plane that holds the needle: heading x (-skin_normal).
  Eigen::Vector3d lateral() const { return heading.cross(-skin_normal).normalized(); }
};

/// Whether a needle may enter here: not near the border of the volume, nor at a cut.
bool CanEnterAt(const PatientField& field, const Eigen::Vector3d& entry_ct_mm);

/// A plan whose image plane holds the needle and `axis`, or if that is zero, the skin's normal.
/// `skin_normal` is that at the entry.
InsertionPlan CompletePlan(const Eigen::Vector3d& entry_ct_mm, const Eigen::Vector3d& skin_normal,
                           const Eigen::Vector3d& target_ct_mm, const Eigen::Vector3d& axis);

/// Looks for the smallest turn of the needle that runs into bone: in the image plane if there is
/// one, otherwise across. Sets the plan's bone angle, axis and depth.
void FindBone(const PatientField& field, const PlanSettings& settings, InsertionPlan& plan);

/// How well a probe would sit ahead of the entry: the skin's distance from the tangent plane, mm,
/// or nothing if there is no skin there, or a cut.
std::optional<double> ProbeUnevennessMm(const PatientField& field, const InsertionPlan& plan);

/// True if nothing of `avoid` comes nearer than `clearance_mm` to the path inside the body.
bool PathIsFree(const PatientField& field, const Eigen::Vector3d& entry_ct_mm,
                const Eigen::Vector3d& target_ct_mm, const PlanSettings& settings);

/// The free path to `target_ct_mm` nearest to `settings.approach`.
/// @throws NoAnswerError if no free path of the right length lies in the cone.
InsertionPlan PlanToTarget(const PatientField& field, const Eigen::Vector3d& target_ct_mm,
                           const PlanSettings& settings, const RunContext& context);

/// The best of many paths all around the body: into the liver or a lesion if one can be reached,
/// otherwise deep into soft tissue, in plane with a probe on flat skin that sees target and needle.
/// With `frame`,
/// shoulders, arms and neck only if no path in the trunk is free.
/// @throws NoAnswerError if there is none.
InsertionPlan PlanAnywhere(const PatientField& field, const PlanSettings& settings,
                           const RunContext& context, const BodyFrame* frame = nullptr);

}  // namespace acus::phantom
