// How the channel in the tissue holds the bendable needle, and how the hand does (Fortmeier-2016,
// section 2.3).
#pragma once

#include <Eigen/Geometry>
#include <span>

#include "acus/physics/needle/curved_path.h"
#include "acus/physics/needle/rod.h"

namespace acus::needle {

struct CouplingOptions {
  double tip_stiffness_n_per_mm = 0.5;    ///< Tip to the path's last node, in all directions.
  double entry_stiffness_n_per_mm = 0.0;  ///< Skin around the shaft, across it; 0: none.
};

/// Where the tissue of the path is now, in the space in which the rod is: it may move by itself, as
/// a patient breathes.
class PathMotion {
 public:
  virtual ~PathMotion() = default;
  virtual Eigen::Vector3d NowMm(const Eigen::Vector3d& rest_mm) const noexcept = 0;
};

/// Springs from the needle's buried part to the channel: for each element of the rod one, in the
/// middle of what of it is buried, with the stiffness of the tissue along that piece; the tip's;
/// and the skin's. Places along the needle are matched by length from the tip, so that the springs
/// do not depend on how finely rod and path are cut, and change without a step as the needle goes
/// in.
///
/// Springs across act perpendicular to the channel. (The paper projects on the plane perpendicular
/// to the needle there: the same to second order in the angle between them. With the channel's,
/// the forces have a potential, and cannot give energy.)
///
/// @param path  in the space in which the rod is; displace the anchors afterwards to move tissue.
/// @return how many of `contacts` were filled: at most rod.num_elements() + 2.
int CoupleToPath(const RodModel& rod, const CurvedPath& path, const CouplingOptions& options,
                 std::span<RodContact> contacts) noexcept;

/// Takes the springs to where the tissue is now; a channel turns with it.
void MoveContacts(const PathMotion& motion, std::span<RodContact> contacts) noexcept;

/// The hub as the paper holds it in its base spring: drawn to v = s - l q_z, where s is the
/// insertion point as it is now, l the length outside, and q the orientation of the hand.
struct HandSpring {
  double stiffness_n_per_mm = 0.5;
  double stiffness_n_mm_per_rad = 500.0;
};
RodBase BaseFromHand(const Eigen::Vector3d& insertion_mm, double length_outside_mm,
                     const Eigen::Quaterniond& hand, const HandSpring& spring) noexcept;

/// Eq. 8: kappa times the offset from the hand's position to the hub, across the path's beginning.
Eigen::Vector3d HandForceN(double kappa_n_per_mm, const Eigen::Vector3d& hub_mm,
                           const Eigen::Vector3d& hand_mm,
                           const Eigen::Vector3d& path_direction) noexcept;

/// Torque that turns the hand's axis to the needle's tangent at the skin, N mm; none about the
/// hand's own axis.
Eigen::Vector3d HandTorqueNMm(double stiffness_n_mm_per_rad, const Eigen::Quaterniond& hand,
                              const Eigen::Vector3d& tangent_at_skin) noexcept;

}  // namespace acus::needle
