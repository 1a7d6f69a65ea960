// The times in a session at which images are rendered.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "acus/data/session/session.h"

namespace acus::dataset {

/// `count` different times of needle samples, in order, or fewer if the session has fewer: a share
/// with the tip in the body, the others outside, both spread evenly over their samples. If there
/// are no samples of one kind, all are of the other.
/// @param inserted  Whether the tip of a sample is in the body.
std::vector<std::int64_t> FrameMoments(
    const session::PoseStream& needle,
    const std::function<bool(const session::PoseSample&)>& inserted, int count,
    double inserted_share);

}  // namespace acus::dataset
