// What happens when in a force-depth recording: rest, advance with punctures, hold, retraction.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "acus/physics/forces/laws/force_curve.h"

namespace acus::fitting {

using forces::ForceCurve;

/// Samples [begin, end).
struct SampleRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size() const { return end > begin ? end - begin : 0; }
};

/// A peak of the force during the advance with a fall after it.
struct PunctureEvent {
  std::size_t peak = 0;    ///< Last sample before the fall.
  std::size_t trough = 0;  ///< First sample after it.
  double drop_n = 0.0;     ///< Fall of the smoothed force.
  bool sharp = false;      ///< Most of the fall is between two neighbouring samples' surroundings.
};

struct CurvePhases {
  SampleRange rest;             ///< Before the drive moves; may be empty.
  SampleRange advance;          ///< From the first motion to the greatest depth.
  SampleRange hold;             ///< At the greatest depth.
  SampleRange retract;          ///< The withdrawal, until the drive stops.
  std::vector<bool> moving_in;  ///< By sample: advancing at near full speed.
  double advance_mm_per_s = 0.0;
  double rate_hz = 0.0;
  double noise_n = 0.0;          ///< White noise of the force (from differences of neighbours).
  std::vector<double> smooth_n;  ///< Force, running mean over `smoothing` samples.
  std::size_t smoothing = 1;
  double least_drop_n = 0.0;             ///< Falls below this are noise.
  std::vector<PunctureEvent> punctures;  ///< In order of time.
};

/// Segments a recording by the drive's speed, and the advance by falls of the force.
/// Any of the ranges may be empty; nothing is thrown for an odd recording.
CurvePhases FindPhases(const ForceCurve& curve);

}  // namespace acus::fitting
