#include "acus/scene/scenario/fluoroscopy_effect.h"

#include <numbers>

#include "acus/base/config/json_file.h"

namespace acus::scenario {

FluoroscopyEffect ReadFluoroscopyEffect(const nlohmann::json& effect,
                                        const std::filesystem::path& folder) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  FluoroscopyEffect out;
  out.c_arm = config::FindConfig(effect.at("c_arm").get<std::string>(), folder);
  if (effect.contains("isocentre_mm")) {
    const auto& place = effect.at("isocentre_mm");
    out.isocentre_in_ct_mm = Eigen::Vector3d(place[0], place[1], place[2]);
  }
  out.lao_rad = kRadians * effect.at("lao_deg").get<double>();
  out.cranial_rad = kRadians * effect.at("cranial_deg").get<double>();
  out.rate_hz = effect.at("rate_hz");
  out.needle = effect.at("needle");
  return out;
}

}  // namespace acus::scenario
