// Tolerances for the difference of two runs.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace acus::comparison {

struct ForceLimit {
  double rms_n = 0.0;
  double max_n = 0.0;
};

struct ForceTolerances {
  double time_max_s = 0.0;
  ForceLimit any;  ///< For columns that are not in by_column.
  std::map<std::string, ForceLimit> by_column;
  double depth_max_mm = 0.0;  ///< Also for other lengths.
  double torque_max_n_mm = 0.0;
  double tissue_percent = 0.0;
  double event_time_s = 0.0;

  const ForceLimit& Of(const std::string& column) const;
};

struct ImageTolerances {
  double time_max_s = 0.0;
  double psnr_min_db = 0.0;
  double ssim_min = 0.0;
};

struct MetricTolerances {
  double relative = 0.0;
  double absolute = 0.0;
  std::map<std::string, double> relative_by_name;

  double RelativeOf(const std::string& name) const;
};

struct Tolerances {
  ForceTolerances forces;
  ImageTolerances images;
  MetricTolerances metrics;
};

/// Reads a file of format acus-tolerances/1 (configs/schema/acus-tolerances.schema.json).
/// @throws InputError listing all problems.
Tolerances ReadTolerances(const std::filesystem::path& path);

/// Reads the document from memory; `label` names the file in messages.
Tolerances TolerancesFrom(const nlohmann::json& document, const std::string& label);

}  // namespace acus::comparison
