// The CT's skin pulled onto a mannequin's: a displacement field through the whole body.
#pragma once

#include <Eigen/Core>

#include "acus/base/core/run_context.h"
#include "acus/data/mesh/surface.h"
#include "acus/data/volume/volume.h"
#include "acus/patient/registration/elastic_lattice.h"

namespace acus::registration {

struct WarpSettings {
  double lattice_mm = 8.0;      ///< In [2, 50]. Distance of the nodes.
  double reach_mm = 40.0;       ///< > 0. Mannequin points farther from the CT's skin do not count.
  double bone_modulus = 100.0;  ///< >= 1. Stiffness of bone over that of soft tissue.
  double air_modulus = 0.01;    ///< In (0, 1]. Of what lies outside the body, and of air in it.
  double compliance_mm =
      0.5;              ///< > 0. Softness of the pull: how thick a layer of tissue gives as much.
  int num_rounds = 10;  ///< >= 1. New nearest points, then a new elastic solution.
  int most_points = 6000;        ///< >= 100. Of the mannequin's points, evenly.
  double smallest_volume = 0.1;  ///< In [0, 1). A cell squeezed below this share has folded.
};

/// Points of the mannequin's skin in CT space, after rigid registration.
struct MannequinSkin {
  Eigen::Matrix3Xd points_mm;
  Eigen::Matrix3Xd normals;  ///< Outwards, unit; no column if they are not known.
};

struct WarpQuality {
  double before_rms_mm = 0.0;  ///< Distance of the mannequin's points from the CT's skin.
  double after_rms_mm = 0.0;   ///< From the warped skin.
  double after_p95_mm = 0.0;
  double after_largest_mm = 0.0;
  Eigen::Index num_points = 0;    ///< That counted in the last round.
  Eigen::Index num_left_out = 0;  ///< Out of reach, at the CT's ends, or facing another way.
  double largest_mm = 0.0;        ///< Displacement of the tissue.
  double smallest_volume = 1.0;   ///< Jacobian: local volume after over before, within the body.
  double largest_volume = 1.0;
  double bone_rms_mm = 0.0;  ///< What remains of bone's displacements after one rigid motion.
  double bone_strain = 0.0;  ///< Largest stretch of bone, 95th percentile.
};

struct SurfaceWarp {
  LatticeField field;  ///< mannequin-shaped place = CT place + field.At(CT place).
  WarpQuality quality;
};

/// Pulls the skin onto the mannequin's by springs along its normals and lets the body follow
/// elastically, bone (labels "bone" and standard bones) as a stiff inclusion; repeated with new
/// nearest points (the non-rigid ICP of Amberg et al. 2007 with an elastic body for its
/// smoothness). Pulls are soft at first.
///
/// @param labels  Tissues of the CT; its grid bounds the field.
/// @param skin    The CT's skin; where it is cut by the ends of the CT it is omitted.
/// @throws InputError if a setting is out of its range or there are fewer than 100 mannequin
/// points.
/// @throws NoAnswerError if hardly a point is in reach, or the field folds.
SurfaceWarp WarpToMannequin(const volume::LabelMap& labels, const mesh::Surface& skin,
                            const MannequinSkin& mannequin, const WarpSettings& settings,
                            const RunContext& context);

/// Evenly spread points of a mannequin's surface with their normals, carried into CT space.
MannequinSkin PointsOf(const mesh::Surface& mannequin, const Eigen::Isometry3d& ct_from_reference);

}  // namespace acus::registration
