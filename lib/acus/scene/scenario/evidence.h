// The evidence for the values of a scenario that acus-tradeoff chose: the request, the machine and
// the measurements. No simulation reads it.
#pragma once

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace acus::scenario {

/// Times of one setting on one session. NaN: not measured, or the scene has no such part.
struct Cost {
  double step_us_median = std::numeric_limits<double>::quiet_NaN();   ///< CPU time of a force step.
  double step_us_p999 = std::numeric_limits<double>::quiet_NaN();     ///< 99.9th percentile.
  double image_ms_median = std::numeric_limits<double>::quiet_NaN();  ///< CPU time of an image.
  double image_ms_p95 = std::numeric_limits<double>::quiet_NaN();     ///< 95th percentile.
};

/// The share of the time that a stage takes.
struct EvidenceStage {
  std::string stage;
  std::string rate;    ///< "step" or "image".
  double share = 0.0;  ///< Share of the time of all stages of that rate, 0 to 1.
};

struct Evidence {
  std::string asked;    ///< As on the command line: "--budget force=0.5ms,image=16ms".
  std::string machine;  ///< Processor and its number of threads.
  std::string acus_version;
  std::string session;  ///< Its name.
  double session_s = 0.0;
  int settings_measured = 0;
  int repetitions = 0;
  Cost predicted;  ///< By the additive model, before the setting itself was measured.
  Cost measured;   ///< On that machine and session.
  /// Relative to the most expensive setting: RMS of the difference of forces, N; PSNR of the
  /// images, dB (NaN also where all are the same), and SSIM.
  double force_rms_n = std::numeric_limits<double>::quiet_NaN();
  double image_psnr_db = std::numeric_limits<double>::quiet_NaN();
  double image_ssim = std::numeric_limits<double>::quiet_NaN();
  std::vector<EvidenceStage> stages;
};

/// The block "evidence" of a scenario. NaN values are omitted.
nlohmann::json ToJson(const Evidence& evidence);

/// @param block  Checked against the schema.
Evidence EvidenceFrom(const nlohmann::json& block);

/// Times in the form of the block "evidence". NaN values are omitted.
nlohmann::json ToJson(const Cost& cost);

}  // namespace acus::scenario
