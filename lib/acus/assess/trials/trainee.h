// The skill of a virtual trainee's hand and eye, as numbers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace acus::trials {

/// The skill of a grade, or of one person of it. docs/concepts/studies.md explains each value.
struct TraineeSkill {
  std::string grade;
  double spread = 0.2;    ///< SD of the values' logarithms between persons of the grade.
  double learning = 0.2;  ///< Errors and times fall with trial^-learning.
  double delay_s = 0.25;  ///< From sensory input to the hand's reaction.

  double tremor_mm = 0.1;   ///< RMS along each axis, 8 to 12 Hz, out of tissue.
  double tremor_deg = 0.1;  ///< RMS about each axis.
  double drift_mm = 0.3;    ///< RMS, 0.2 to 0.8 Hz.

  double search_s = 10.0;  ///< Duration of the search with the probe.
  double sweep_mm = 10.0;  ///< Motion of the probe during the search.
  double plane_mm = 1.0;   ///< SD of the image plane's distance from the planned path.
  double plane_deg = 2.0;  ///< SD of its rotation about the beam.

  double entry_mm = 2.0;   ///< SD of the entry along each axis of the skin.
  double aim_deg = 2.0;    ///< SD of the first direction, in both planes.
  double bias_mm = 1.0;    ///< Constant error of the person in the position of the target.
  double target_mm = 1.0;  ///< SD of an additional error along each axis, new in each trial.
  double depth_mm = 1.0;   ///< SD of the depth at which the needle stops.

  double aim_s = 3.0;            ///< From the rest position to the skin.
  double speed_mm_per_s = 10.0;  ///< Speed of insertion.
  double speed_spread = 0.3;     ///< Relative SD of the speed between stretches.
  double stretch_mm = 15.0;      ///< Advance between two stops.
  double stop_s = 1.0;           ///< Duration of a stop, to look at the image.

  double notice_mm = 3.0;        ///< Predicted miss from which the direction is corrected.
  double correction_gain = 0.8;  ///< Share of the miss that a correction removes.
  double correction_deg = 1.0;   ///< SD of its direction.
  double withdraw_share = 0.6;   ///< Share of the depth, for withdrawal before a turn.
  int most_corrections = 5;
  double bone_n = 1.5;   ///< Resistance from which the needle is withdrawn.
  double place_s = 1.0;  ///< Rest at the end.
};

/// Reads an acus-trainee file. @throws InputError listing all problems.
TraineeSkill ReadTraineeSkill(const std::filesystem::path& path);

/// The person of a grade with this code: all values times exp(spread x normal), drawn from the seed
/// and the code; those for `trial` >= 1 after practice (power law of practice, Newell & Rosenbloom
/// 1981).
TraineeSkill PersonOf(const TraineeSkill& grade, std::uint64_t seed, const std::string& code,
                      int trial);

}  // namespace acus::trials
