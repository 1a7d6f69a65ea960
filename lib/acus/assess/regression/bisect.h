// Finds where two replays differ: the first step, stage and variable.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace acus::regression {

/// The first difference of two traces.
struct TraceDifference {
  std::string trace;     ///< "step" or "image".
  std::size_t row = 0;   ///< Number of the step or image, from 0.
  std::string time_s;    ///< From the first run.
  std::string stage;     ///< The first that differs, in the order in which stages run.
  std::string variable;  ///< A variable of that stage.
  std::string a, b;      ///< Values of both runs.
};

struct Bisection {
  std::size_t num_steps = 0;
  std::optional<TraceDifference> step, image;
  bool same() const { return !step && !image; }
};

/// Compares trace.csv and image_trace.csv of two run folders, value by value, exactly.
/// @throws InputError if a run has no trace.
Bisection Bisect(const std::filesystem::path& run_a, const std::filesystem::path& run_b);

/// A line for steps, and one for images.
std::string TextOf(const Bisection& found);

}  // namespace acus::regression
