// The situation at one time of a session: contact, image content, position of the tip.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "acus/run/training/motion_metrics.h"
#include "acus/run/training/plane_share.h"
#include "acus/run/training/structures.h"

namespace acus::training {

/// The area that the image of a probe covers: probe frame, x to the marked side, y along the beam,
/// mm.
struct ImageField {
  double depth_mm = 0.0;
  double half_width_mm = 0.0;   ///< Half the width of a flat face.
  double radius_mm = 0.0;       ///< Radius of a curved face; 0: flat.
  double half_angle_rad = 0.0;  ///< From the middle to the outermost line; 0: parallel lines.

  bool Contains(double x_mm, double y_mm) const;
};

struct Situation {
  bool needle_seen = false;
  bool probe_seen = false;
  bool probe_on_skin = false;
  std::optional<Eigen::Vector3d> target_in_probe_mm;  ///< If there is a target and a probe.
  bool target_in_view = false;                        ///< In the image area, and near its plane.
  std::optional<Eigen::Vector3d> tip_in_probe_mm;
  bool needle_in_plane = false;  ///< Tip and shaft.
  bool needle_in_tissue = false;
  bool needle_at_skin = false;            ///< Tissue begins within contact_mm ahead of the tip.
  std::optional<Eigen::Vector3d> tip_mm;  ///< Reference frame.
  std::optional<double> tip_to_target_mm;
  bool target_reached = false;
  bool breath_held = false;
  double plunger_n = 0.0;  ///< Force of the thumb on a syringe or a stylet; below 0: pulls.
};

struct SituationOptions {
  /// The probe is in contact if tissue begins at most this far in front of the centre of its face;
  /// a needle is at the skin if tissue begins this far ahead of the tip.
  double contact_mm = 3.0;
  PlaneOptions plane;
  std::optional<Eigen::Vector3d> target_mm;  ///< Reference frame.
  double target_radius_mm = 3.0;
};

/// @param label_at  Label of the patient at rest; 0 outside. @param probe  Null: there is none.
Situation SituationOf(const session::PoseSample& needle, const session::PoseSample* probe,
                      const ImageField& field, const LabelAtPoint& label_at,
                      const SituationOptions& options);

/// Distance from the centre of the probe's face to the tissue in front, mm along the beam, in steps
/// of 1 mm; 0 inside tissue. Nothing if there is none within `reach_mm`.
std::optional<double> GapToSkinMm(const transforms::Pose& reference_from_probe,
                                  const LabelAtPoint& label_at, double reach_mm = 150.0);

/// Depth of the centre of the probe's face below the skin, against the beam, in steps of 1 mm; 0
/// outside tissue, `reach_mm` if it is deeper.
double DepthBelowSkinMm(const transforms::Pose& reference_from_probe, const LabelAtPoint& label_at,
                        double reach_mm = 60.0);

}  // namespace acus::training
