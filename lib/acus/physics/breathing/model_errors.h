// How well a motion model repeats displacements that are known.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "acus/physics/breathing/model_building.h"

namespace acus::breathing {

struct ModelError {
  double mean_mm = 0.0;
  double p95_mm = 0.0;
  double largest_mm = 0.0;
};

/// |u_model - u_known| at the nodes where `where` is not 0 (empty: everywhere), over the phases.
/// @pre `known` is on the model's nodes. @throws InputError if no node remains.
ModelError ErrorOf(const MotionModel& model, const MotionPhases& known,
                   std::span<const std::uint8_t> where);

/// For each phase but the reference: the error there of a model built without it. Key frames at the
/// ends of half a cycle cannot be omitted: there the model extrapolates.
/// @throws InputError if the phases that are left do not determine the model.
ModelError LeaveOneOutError(MotionKind kind, const MotionPhases& known,
                            std::span<const std::uint8_t> where);

}  // namespace acus::breathing
