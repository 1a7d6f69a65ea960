// What a scanner sees of a breathing patient: any CT, warped by a known motion.
#pragma once

#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/phantom/breath/breathing_motion.h"

namespace acus::phantom {

struct BreathingScanSettings {
  double noise_sd_hu = 10.0;      ///< New in every phase.
  std::uint64_t noise_index = 0;  ///< Another number, other noise.
};

/// The CT, taken at end expiration, as it would be at another moment of breath: each voxel shows
/// the tissue that is there then. Where lung grows, it gets thinner by as much (its mass stays).
/// What comes in over the border of the volume is its mirror image.
///
/// Places are right to a twentieth of a voxel: the backward flow is kept on nodes 2 to 4 mm apart.
volume::CtVolume ScanAt(const volume::CtVolume& ct, const BreathingMotion& motion,
                        const breathing::Breath& breath, const BreathingScanSettings& settings,
                        const RunContext& context);

/// (x, y, z) of WorldMm - rest at each node, i fastest, mm.
std::vector<float> DisplacementsOn(const volume::Geometry& nodes, const BreathingMotion& motion,
                                   const breathing::Breath& breath, int num_threads);

/// A point of tissue, at rest.
struct TissueLandmark {
  std::string name;
  std::string tissue;       ///< "lung" or "liver".
  Eigen::Vector3d rest_mm;  ///< CT space.
  double wall_mm = 0.0;     ///< Distance to the wall along which tissue slides.
};

/// `count` random points, half in lung and half in liver, that stay in the volume by
/// `breath`. Without label "liver", soft tissue under the right dome, up to 120 mm below it.
/// @throws InputError if lung or liver is too small.
std::vector<TissueLandmark> RandomLandmarks(const volume::LabelMap& labels,
                                            const BreathingMotion& motion,
                                            const breathing::Breath& breath, int count,
                                            const RunContext& context);

}  // namespace acus::phantom
