#include "acus/scene/scenario/evidence.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

namespace acus::scenario {
namespace {

using nlohmann::json;

/// The keys of the numbers: writing and reading share this table.
template <typename Struct>
struct NumberKey {
  std::string_view key;
  double Struct::*number;
};

constexpr std::array<NumberKey<Cost>, 4> kCostKeys = {{{"step_us_median", &Cost::step_us_median},
                                                       {"step_us_p999", &Cost::step_us_p999},
                                                       {"image_ms_median", &Cost::image_ms_median},
                                                       {"image_ms_p95", &Cost::image_ms_p95}}};
constexpr std::array<NumberKey<Evidence>, 3> kErrorKeys = {
    {{"force_rms_n", &Evidence::force_rms_n},
     {"image_psnr_db", &Evidence::image_psnr_db},
     {"image_ssim", &Evidence::image_ssim}}};

template <typename Struct, std::size_t kCount>
json NumbersToJson(const Struct& object, const std::array<NumberKey<Struct>, kCount>& keys) {
  json block = json::object();
  for (const auto& [key, number] : keys) {
    if (std::isfinite(object.*number)) block[std::string(key)] = object.*number;
  }
  return block;
}

template <typename Struct, std::size_t kCount>
Struct NumbersFrom(const json& block, const std::array<NumberKey<Struct>, kCount>& keys,
                   Struct object) {
  for (const auto& [key, number] : keys) {
    const std::string name(key);
    if (block.contains(name)) object.*number = block.at(name).template get<double>();
  }
  return object;
}

}  // namespace

json ToJson(const Cost& cost) {
  return NumbersToJson(cost, kCostKeys);
}

json ToJson(const Evidence& evidence) {
  json stages = json::array();
  for (const EvidenceStage& stage : evidence.stages) {
    stages.push_back({{"stage", stage.stage}, {"rate", stage.rate}, {"share", stage.share}});
  }
  return {{"asked", evidence.asked},
          {"machine", evidence.machine},
          {"acus_version", evidence.acus_version},
          {"session", {{"name", evidence.session}, {"seconds", evidence.session_s}}},
          {"settings_measured", evidence.settings_measured},
          {"repetitions", evidence.repetitions},
          {"predicted", ToJson(evidence.predicted)},
          {"measured", ToJson(evidence.measured)},
          {"errors", NumbersToJson(evidence, kErrorKeys)},
          {"stages", std::move(stages)}};
}

Evidence EvidenceFrom(const json& block) {
  Evidence evidence;
  evidence.asked = block.at("asked");
  evidence.machine = block.at("machine");
  evidence.acus_version = block.at("acus_version");
  evidence.session = block.at("session").at("name");
  evidence.session_s = block.at("session").at("seconds");
  evidence.settings_measured = block.at("settings_measured");
  evidence.repetitions = block.at("repetitions");
  evidence.predicted = NumbersFrom(block.at("predicted"), kCostKeys, Cost{});
  evidence.measured = NumbersFrom(block.at("measured"), kCostKeys, Cost{});
  evidence = NumbersFrom(block.at("errors"), kErrorKeys, std::move(evidence));
  for (const json& stage : block.at("stages")) {
    evidence.stages.push_back({stage.at("stage"), stage.at("rate"), stage.at("share")});
  }
  return evidence;
}

}  // namespace acus::scenario
