// An exercise: the target of the tip, the structures to spare, and the values to reach.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/run/training/checklist.h"
#include "acus/run/training/needle_passes.h"
#include "acus/run/training/plane_share.h"

namespace acus::training {

/// A value to reach. At least one of the limits is set.
struct Goal {
  std::string metric;  ///< Name, as in metrics.json.
  std::optional<double> at_most;
  std::optional<double> at_least;
  std::string why;      ///< May be empty.
  double weight = 1.0;  ///< In the score. > 0.
  bool must = false;    ///< A trial that does not meet it fails.
};

struct Exercise {
  std::string name;
  std::string instructions;
  std::filesystem::path scenario;     ///< As written in the file; may be empty.
  std::filesystem::path target_file;  ///< Absolute; empty: the scenario's corridor.
  std::string target_point = "target";
  std::string target_name = "target";  ///< Name for the screen.
  double target_radius_mm = 3.0;
  std::vector<std::string> avoid;  ///< Names of labels.
  PassOptions passes;
  PlaneOptions image_plane;
  std::vector<Goal> goals;
  Checklist checklist;
  HintOptions hints;
};

/// Reads an acus-exercise file; paths in it are relative to it.
/// @throws InputError listing all problems: keys, ranges, a goal whose limits exclude each other, a
///     metric with two goals.
Exercise ReadExercise(const std::filesystem::path& path);

}  // namespace acus::training
