// An insertion that differs from a trial's, as a change of its line and as a session.
#pragma once

#include <optional>
#include <vector>

#include "acus/assess/trials/trial_line.h"

namespace acus::trials {

/// The difference of an insertion from the line of a trial. All zero: that line.
struct InsertionChange {
  double along_mm = 0.0;       ///< Motion of the entry along TrialLine::along_in_ct.
  double across_mm = 0.0;      ///< Motion of the entry along TrialLine::across_in_ct.
  double steeper_rad = 0.0;    ///< Rotation of the axis from along towards inward.
  double sideways_rad = 0.0;   ///< Subsequent rotation towards across.
  double depth_mm = 0.0;       ///< Added to the depth.
  double speed_factor = 1.0;   ///< > 0
  double breath_cycles = 0.0;  ///< [0, 1): later in the breath by this share of a cycle.
};

struct WhatIfSettings {
  int count = 1000;
  double entry_mm = 15.0;          ///< Largest change of the entry along each axis.
  double tilt_deg = 15.0;          ///< Largest rotation in each direction.
  double depth_mm = 15.0;          ///< Largest change of depth.
  double speed_factor = 2.0;       ///< Speeds from 1 / it to it.
  bool breath = true;              ///< Other phases of breath, in a patient who breathes.
  double aimed_share = 0.5;        ///< Share of the random ones that point to the target, [0, 1].
  double aim_jitter_deg = 1.0;     ///< Standard deviation of their direction.
  double aim_jitter_mm = 1.0;      ///< ... and of their depth.
  double lead_mm = 10.0;           ///< Length of the motion before the skin.
  double slowest_mm_per_s = 10.0;  ///< Speeds of insertion lie between these.
  double fastest_mm_per_s = 100.0;
  double rest_s = 0.3;  ///< Rest at the end.
  double rate_hz = 1000.0;
  int best = 5;  ///< Number of the best ones that are written as sessions.
};

/// Reads an acus-what-if file. @throws InputError listing all problems.
WhatIfSettings ReadWhatIfSettings(const std::filesystem::path& path);

/// A possible insertion: its line meets the skin.
struct Alternative {
  InsertionChange change;
  Eigen::Vector3d entry_ct_mm;
  Eigen::Vector3d axis_in_ct;  ///< Unit, inwards.
  double depth_mm = 0.0;
  double speed_mm_per_s = 0.0;
  bool aimed = false;  ///< Drawn towards the target.
};

/// The insertion after a change: the entry is moved in the plane of the skin and projected on the
/// skin along the new axis. Depths are at least 5 mm. Nothing if the line misses the body.
std::optional<Alternative> ChangedInsertion(const TrialScene& scene, const TrialLine& line,
                                            const InsertionChange& change,
                                            const WhatIfSettings& settings);

/// The first is the trial's line; then changes of one value at a time; then random ones, of which a
/// share points at the target. Each depends on the seed and its number only.
/// @param breathes  True if phases of breath matter.
std::vector<Alternative> MakeAlternatives(const TrialScene& scene, const TrialLine& line,
                                          const WhatIfSettings& settings, bool breathes,
                                          std::uint64_t seed);

/// The insertion as a session for acus-replay: from settings.lead_mm before the skin to the depth
/// and settings.rest_s there, with the trial's roll of the needle, its probe in the pose at the
/// deepest point, its breath and its clock. The speed rises and falls within 0.1 s.
session::Session SessionOf(const TrialScene& scene, const session::Session& trial,
                           const TrialLine& line, const Alternative& alternative,
                           const WhatIfSettings& settings);

/// Distance after a time on a path that begins and ends at rest: speed `speed_mm_per_s`, with
/// constant acceleration and deceleration within `ramp_s` (less on short paths).
double DistanceAfter(double time_s, double length_mm, double speed_mm_per_s, double ramp_s);

/// Total duration of that motion, s.
double DurationOf(double length_mm, double speed_mm_per_s, double ramp_s);

}  // namespace acus::trials
