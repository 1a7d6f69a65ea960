// The results of a sweep: every run, and the statistics of each setting.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/assess/tuning/knob.h"
#include "acus/assess/tuning/measured.h"
#include "acus/assess/tuning/statistics.h"

namespace acus::tuning {

/// One setting over its repetitions: means with 95 % intervals.
struct SettingResult {
  std::string knob;           ///< The parameter of the sweep; "jointly".
  Setting setting;            ///< One parameter, or all that are swept jointly.
  bool is_scenario = false;   ///< The setting of the scenario.
  bool is_default = false;    ///< The default of Acus (one parameter only).
  bool is_paper = false;      ///< The setting of a paper (one parameter only).
  std::string paper;          ///< Name of the paper.
  bool is_reference = false;  ///< The reference of errors.
  std::string unusable;       ///< Why one of its runs must not be used; empty if all may.

  Estimate step_us_median;
  Estimate step_us_p999;
  Estimate image_ms_median;
  Estimate image_ms_p95;
  Estimate preparation_s;
  Estimate memory_mb;
  Estimate force_felt_n;
  Estimate force_rms_n;
  Estimate force_largest_n;
  Estimate image_rms_grey;
  Estimate image_psnr_db;  ///< Infinite if all images are identical.
  Estimate image_ssim;
  /// Difference to the run of the same repetition with the scenario's setting; nothing if that is
  /// not swept.
  Estimate step_us_over_scenario;
  Estimate image_ms_over_scenario;
  Estimate force_rms_over_scenario_n;
};

struct SweepResult {
  std::string scenario;  ///< Its name, or its file.
  std::filesystem::path scenario_file;
  std::filesystem::path session;
  double seconds = 0.0;         ///< Duration of the session.
  double step_period_ms = 0.0;  ///< Period of the recorded samples: the time available for a step.
  double image_period_ms = 0.0;
  std::string machine;  ///< Processor and kernel threads.
  bool jointly = false;
  bool is_subset = false;  ///< A seeded subset of the combinations was run.
  int repetitions = 1;
  std::vector<Knob> knobs;              ///< Swept parameters, with the values that were run.
  std::vector<Measured> runs;           ///< In the order of the plan.
  std::vector<SettingResult> settings;  ///< By parameter, cheap to expensive; jointly: as planned.
};

}  // namespace acus::tuning
