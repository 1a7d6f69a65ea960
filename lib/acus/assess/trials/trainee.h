// A virtual trainee: how well hand and eye do, as numbers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace acus::trials {

/// The skill of a grade, or of one person of it. docs/concepts/studies.md explains each value.
struct TraineeSkill {
  std::string grade;
  double spread = 0.2;    ///< Between persons of the grade: SD of the values' logarithms.
  double learning = 0.2;  ///< Errors and times fall with trial^-learning.
  double delay_s = 0.25;  ///< From what is seen or sensed to what the hand does.

  double tremor_mm = 0.1;   ///< RMS along each axis, 8 to 12 Hz, out of tissue.
  double tremor_deg = 0.1;  ///< RMS about each axis.
  double drift_mm = 0.3;    ///< RMS, 0.2 to 0.8 Hz.

  double search_s = 10.0;  ///< With the probe, until the target is in the image.
  double sweep_mm = 10.0;  ///< Of the probe meanwhile.
  double plane_mm = 1.0;   ///< SD of the image plane's distance from the planned path.
  double plane_deg = 2.0;  ///< SD of its turn about the beam.

  double entry_mm = 2.0;   ///< SD of the entry along each axis of the skin.
  double aim_deg = 2.0;    ///< SD of the first direction, in both planes.
  double bias_mm = 1.0;    ///< Of the person: where the target is taken to be, always alike.
  double target_mm = 1.0;  ///< SD of where it is taken to be, along each axis, new each trial.
  double depth_mm = 1.0;   ///< SD of the depth at which the needle is stopped.

  double aim_s = 3.0;            ///< From the rest position to the skin.
  double speed_mm_per_s = 10.0;  ///< Of insertion.
  double speed_spread = 0.3;     ///< Relative SD of the speed from stretch to stretch.
  double stretch_mm = 15.0;      ///< Advance between two stops.
  double stop_s = 1.0;           ///< To look at the image.

  double notice_mm = 3.0;        ///< Predicted miss from which the direction is corrected.
  double correction_gain = 0.8;  ///< Share of the miss that a correction removes.
  double correction_deg = 1.0;   ///< SD of its direction.
  double withdraw_share = 0.6;   ///< Of the depth, before the direction is changed.
  int most_corrections = 5;
  double bone_n = 1.5;   ///< Resistance from which the needle is withdrawn.
  double place_s = 1.0;  ///< Rest at the end.
};

/// Reads an acus-trainee file. @throws InputError listing what is wrong.
TraineeSkill ReadTraineeSkill(const std::filesystem::path& path);

/// The person of a grade with this code: all values times exp(spread x normal), drawn from the seed
/// and the code; those of `trial` >= 1 after practice (power law of practice, Newell & Rosenbloom
/// 1981).
TraineeSkill PersonOf(const TraineeSkill& grade, std::uint64_t seed, const std::string& code,
                      int trial);

}  // namespace acus::trials
