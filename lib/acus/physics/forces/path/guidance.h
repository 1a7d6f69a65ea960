// What holds a needle on its line, apart from the force along it: a choice that goes with any model
// of that force.
#pragma once

#include <Eigen/Geometry>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/virtual_fixture.h"
#include "acus/physics/forces/laws/window_average.h"
#include "acus/physics/forces/path/needle_track.h"

namespace acus::forces {

enum class GuidanceKind {
  kOwn,    ///< What the model's paper does: layered a beam in soft tissue, the others below.
  kNone,   ///< Nothing across the path.
  kVidal,  ///< Vidal-2008 eq. 8, the line turning with the needle near the skin.
  kVirtualFixture,  ///< Alamilla-2021 eq. 7 to 11.
};

/// What guidance remembers. A plain value.
struct GuidanceState {
  WindowAverage offset_mean;                              ///< opp of Vidal's eq. 8.
  bool holds = false;                                     ///< The fixture has a trajectory.
  Fixture fixture;                                        ///< Once pierced.
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();  ///< Of the last sample.
  double play_mm = 0.0;  ///< Depth with a play, so that a tremor is not an advance.
};

struct GuidanceForce {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();      ///< On the needle, across the path.
  Eigen::Vector3d torque_n_mm = Eigen::Vector3d::Zero();  ///< About the tip; both in CT axes.
};

/// Before a model follows its path: kVidal turns it where the tissue near the skin lets it turn.
/// @pre track.pierced.
void TurnPath(GuidanceKind kind, const ForceTable& table, NeedleTrack& track,
              const NeedleMotion& motion) noexcept;

/// After it: the force and torque across the path; kVirtualFixture may take a new trajectory, on
/// which the needle's depth stays. @pre track.pierced, kind is not kOwn.
/// @param was_pierced  before this step.
GuidanceForce GuideNeedle(GuidanceKind kind, const ForceTable& table, GuidanceState& state,
                          NeedleTrack& track, const NeedleMotion& motion,
                          bool was_pierced) noexcept;

}  // namespace acus::forces
