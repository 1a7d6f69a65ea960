#include "acus/assess/regression/comparison/tolerances.h"

#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"

namespace acus::comparison {

using nlohmann::json;

const ForceLimit& ForceTolerances::Of(const std::string& column) const {
  const auto found = by_column.find(column);
  return found == by_column.end() ? any : found->second;
}

double MetricTolerances::RelativeOf(const std::string& name) const {
  const auto found = relative_by_name.find(name);
  return found == relative_by_name.end() ? relative : found->second;
}

Tolerances ReadTolerances(const std::filesystem::path& path) {
  return TolerancesFrom(config::ReadJson(path), path.string());
}

Tolerances TolerancesFrom(const json& document, const std::string& label) {
  const json checked = config::CheckedConfig(document, "acus-tolerances", label);
  Tolerances tolerances;
  const json& forces = checked.at("forces");
  tolerances.forces.time_max_s = forces.at("time_max_s");
  tolerances.forces.any = {forces.at("rms_n"), forces.at("max_n")};
  for (const auto& [column, limit] : forces.at("components").items()) {
    tolerances.forces.by_column[column] = {limit.at("rms_n"), limit.at("max_n")};
  }
  tolerances.forces.depth_max_mm = forces.at("depth_max_mm");
  tolerances.forces.torque_max_n_mm = forces.at("torque_max_n_mm");
  tolerances.forces.tissue_percent = forces.at("tissue_percent");
  tolerances.forces.event_time_s = forces.at("event_time_s");
  const json& images = checked.at("images");
  tolerances.images = {images.at("time_max_s"), images.at("psnr_min_db"), images.at("ssim_min")};
  const json& metrics = checked.at("metrics");
  tolerances.metrics.relative = metrics.at("relative");
  tolerances.metrics.absolute = metrics.at("absolute");
  for (const auto& [name, limit] : metrics.at("relative_by_name").items()) {
    tolerances.metrics.relative_by_name[name] = limit;
  }
  return tolerances;
}

}  // namespace acus::comparison
