// From the displacements of a patient at known moments of breath to a motion model
// (Fortmeier-2016, section 3).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "acus/physics/breathing/motion_model.h"

namespace acus::breathing {

/// The patient at one moment.
struct MotionPhase {
  Breath breath;
  /// (x, y, z) in CT space at each node, i fastest, mm. Empty: the reference image.
  std::vector<float> displacement_in_ct_mm;
};

/// All on the same nodes; in the order of time, one breath.
struct MotionPhases {
  volume::Geometry nodes;
  std::vector<MotionPhase> phases;

  std::size_t num_values() const { return 3 * nodes.num_voxels(); }
  /// @throws InputError if there are fewer than three phases or more than one reference, if a field
  ///     has another number of values or one that is not finite, or breath that is not finite.
  void Check() const;
};

/// Nodes over the same box, `per_axis` along each axis.
volume::Geometry NodesOver(const volume::Geometry& box, int per_axis);

/// The same displacements on other nodes, trilinear; as at the border beyond it.
MotionPhases Resampled(const MotionPhases& phases, const volume::Geometry& nodes);

/// Keeps the `num_modes` strongest principal components of the fields over time: what registration
/// got wrong in one phase alone goes. The reference stays what it is.
MotionPhases FilteredInTime(const MotionPhases& phases, int num_modes);

/// Share of the variance over time that each principal component has, strongest first.
std::vector<double> VarianceOfModes(const MotionPhases& phases);

/// @throws InputError if the phases do not determine the model: too few, or the same signal in all.
MotionModel BuildModel(MotionKind kind, const MotionPhases& phases);

}  // namespace acus::breathing
