// A whole sweep: every run, and what they say of each setting.
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
  std::string knob;           ///< Whose sweep; "jointly".
  Setting setting;            ///< Of one knob, or of all that are swept jointly.
  bool is_scenario = false;   ///< As the scenario has it.
  bool is_default = false;    ///< What Acus does unless told otherwise (one knob only).
  bool is_paper = false;      ///< What a paper did (one knob only).
  std::string paper;          ///< Which one.
  bool is_reference = false;  ///< What errors are against.
  std::string unusable;       ///< If any of its runs must not be used: why.

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
  Estimate image_psnr_db;  ///< Infinite where all images are identical.
  Estimate image_ssim;
  /// Paired with the run of the same repetition as the scenario has it; nothing if it is not swept.
  Estimate step_us_over_scenario;
  Estimate image_ms_over_scenario;
  Estimate force_rms_over_scenario_n;
};

struct SweepResult {
  std::string scenario;  ///< Its name, or its file.
  std::filesystem::path scenario_file;
  std::filesystem::path session;
  double seconds = 0.0;         ///< Of the session.
  double step_period_ms = 0.0;  ///< Of the recorded samples: the time there is for a step.
  double image_period_ms = 0.0;
  std::string machine;  ///< Processor and kernel threads.
  bool jointly = false;
  bool is_subset = false;  ///< Not every combination was run: a seeded subset of them.
  int repetitions = 1;
  std::vector<Knob> knobs;              ///< Those swept, with the values that were run.
  std::vector<Measured> runs;           ///< In the order of the plan.
  std::vector<SettingResult> settings;  ///< By knob, from cheap to expensive; jointly: as planned.
};

}  // namespace acus::tuning
