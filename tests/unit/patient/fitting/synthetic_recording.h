// Recordings with a known truth, made by replaying a mechanical model through a drive's motion.
#pragma once

#include <algorithm>
#include <string>

#include "acus/base/core/random.h"
#include "acus/patient/fitting/mechanical_model.h"
#include "acus/physics/forces/laws/force_curve.h"

namespace acus::fitting {

struct DriveMotion {
  double rate_hz = 500.0;
  double rest_s = 1.0;
  double speed_mm_per_s = 5.0;
  double end_mm = 60.0;
  double hold_s = 40.0;
};

/// Rest, in to end_mm, hold, out to 0, rest: motion only, forces 0.
inline forces::ForceCurve Motion(const DriveMotion& drive, const std::string& name = "made") {
  forces::ForceCurve curve;
  curve.name = name;
  const double in_s = drive.end_mm / drive.speed_mm_per_s;
  const double total_s = 2.0 * drive.rest_s + 2.0 * in_s + drive.hold_s;
  for (int i = 0; i <= static_cast<int>(total_s * drive.rate_hz); ++i) {
    const double t = i / drive.rate_hz;
    const double in = std::clamp((t - drive.rest_s) / in_s, 0.0, 1.0);
    const double out = std::clamp((t - drive.rest_s - in_s - drive.hold_s) / in_s, 0.0, 1.0);
    curve.time_s.push_back(t);
    curve.depth_mm.push_back(drive.end_mm * (in - out));
    curve.force_n.push_back(0.0);
  }
  return curve;
}

/// A needle that is in the tissue from the start: 0.3 N + 0.016 N/mm in, 0.2 N + 0.01 N/mm out,
/// half of the force relaxes with 0.8 s and a fifth with 12 s.
inline MechanicalModel PlainTruth(const DriveMotion& drive) {
  MechanicalModel truth;
  truth.in = {{0.0, drive.end_mm}, {0.3, 0.3 + 0.016 * drive.end_mm}};
  truth.out = {{0.0, drive.end_mm}, {0.2, 0.2 + 0.01 * drive.end_mm}};
  truth.buildup_in_mm = 0.9;
  truth.buildup_out_mm = 1.2;
  truth.relaxing_share = {0.5, 0.2};
  truth.relaxation_s = {0.8, 12.0};
  truth.reference_mm_per_s = drive.speed_mm_per_s;
  truth.offset_n = 0.05;
  return truth;
}

inline forces::ForceCurve Recording(const MechanicalModel& truth, const DriveMotion& drive,
                                    double noise_n, std::uint64_t seed,
                                    const std::string& name = "made") {
  forces::ForceCurve curve = Motion(drive, name);
  RandomStream noise(seed, "recording " + name);
  curve.force_n = Replay(truth, curve.time_s, curve.depth_mm);
  for (double& force : curve.force_n) force += noise_n * noise.Normal();
  return curve;
}

}  // namespace acus::fitting
