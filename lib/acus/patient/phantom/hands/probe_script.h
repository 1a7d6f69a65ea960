// The probe's part of a script: landing, a sweep to find the window, then resting on the skin.
#pragma once

#include "acus/patient/phantom/hands/session_script.h"

namespace acus::phantom {

class ProbePath {
 public:
  /// @throws NoAnswerError if there is no skin where the probe is to lie.
  ProbePath(const PatientField& field, const InsertionPlan& plan, const ProbeScript& script);

  /// Pose at a time, without tremor. `along_mm` and `across_mm` shift the face on the skin, along
  /// the plan's heading and across the image plane; the face stays on the skin.
  Eigen::Isometry3d CtFromProbe(double time_s, double along_mm, double across_mm) const;

 private:
  /// Height of the skin over the tangent plane at the entry.
  double Height(double along_mm, double across_mm) const;

  InsertionPlan plan_;
  ProbeScript script_;
  double first_along_mm_, first_across_mm_;
  int columns_, rows_;             ///< Along, across.
  std::vector<double> height_mm_;  ///< rows x columns, on a lattice of kLatticeMm.
  Eigen::Matrix3d ct_from_probe_rotation_;
};

}  // namespace acus::phantom
