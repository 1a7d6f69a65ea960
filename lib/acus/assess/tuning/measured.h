// The results of one run of one setting: error and time from the same run.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acus/assess/tuning/setting.h"

namespace acus::tuning {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// A stage's share of the time of steps, or of images.
struct StageShare {
  std::string stage;
  std::string rate;     ///< "step" or "image".
  double share = 0.0;   ///< Share of the time of all stages of that rate, 0 to 1.
  double asleep = 0.0;  ///< Share of its runs without work, 0 to 1.
};

/// One run. Values of missing parts (no forces, no images) are kNotMeasured.
struct Measured {
  std::string knob;        ///< Parameter of the sweep; "jointly" if several were varied at once.
  Setting setting;         ///< Values of the swept parameters; the others have the scenario's.
  int repetition = 0;      ///< From 0.
  std::uint64_t seed = 0;  ///< Seed of the scene's random parts; the same for all settings.

  std::int64_t steps = 0;
  double step_us_median = kNotMeasured;  ///< Thread CPU time of Simulation::Step, us.
  double step_us_p999 = kNotMeasured;    ///< 99.9th percentile, us.
  double step_us_mean = kNotMeasured;    ///< us
  int images = 0;
  double image_ms_median = kNotMeasured;  ///< Thread CPU time of ProbeImageRenderer::Render, ms.
  double image_ms_p95 = kNotMeasured;     ///< 95th percentile, ms.
  double image_ms_mean = kNotMeasured;    ///< ms
  std::vector<StageShare> stages;         ///< Stages of the plan, in order.
  double preparation_s = kNotMeasured;    ///< CPU time of loading the scene, s.
  double memory_mb = kNotMeasured;        ///< Memory of the scene, 10^6 bytes.

  double force_felt_n = kNotMeasured;  ///< Largest force on needle or probe, N.

  // Relative to the reference: the same session with the most expensive value, and the same seed.
  bool is_reference = false;              ///< Its errors are zero, as it is the reference.
  double force_rms_n = kNotMeasured;      ///< RMS of the difference of forces, N.
  double force_largest_n = kNotMeasured;  ///< Largest difference of forces, N.
  double image_rms_grey = kNotMeasured;   ///< RMS of the difference of images, of 255 grey values.
  double image_ssim = kNotMeasured;       ///< Mean structural similarity; 1: identical.

  /// Why the run must not be used: forces out of bounds, or generated energy. Empty: usable.
  std::string unusable;

  /// Peak signal-to-noise ratio of the images, dB; infinite if they are identical.
  double ImagePsnrDb() const;
};

/// One line of JSON (format acus-tradeoff-run/1). Values that were not measured are null.
nlohmann::json ToJson(const Measured& measured);

/// @throws InputError if it is not the output of ToJson. @param label  Names the file in messages.
Measured MeasuredFromJson(const nlohmann::json& json, const std::string& label);

}  // namespace acus::tuning
