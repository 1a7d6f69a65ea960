#include "acus/assess/tuning/measured.h"

#include <cmath>

#include "acus/base/core/error.h"

namespace acus::tuning {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "acus-tradeoff-run/1";

struct NumberField {
  const char* key;
  double Measured::*value;
};
constexpr NumberField kNumbers[] = {{"step_us_median", &Measured::step_us_median},
                                    {"step_us_p999", &Measured::step_us_p999},
                                    {"step_us_mean", &Measured::step_us_mean},
                                    {"image_ms_median", &Measured::image_ms_median},
                                    {"image_ms_p95", &Measured::image_ms_p95},
                                    {"image_ms_mean", &Measured::image_ms_mean},
                                    {"preparation_s", &Measured::preparation_s},
                                    {"memory_mb", &Measured::memory_mb},
                                    {"force_felt_n", &Measured::force_felt_n},
                                    {"force_rms_n", &Measured::force_rms_n},
                                    {"force_largest_n", &Measured::force_largest_n},
                                    {"image_rms_grey", &Measured::image_rms_grey},
                                    {"image_ssim", &Measured::image_ssim}};

double NumberOrNothing(const json& value) {
  return value.is_null() ? kNotMeasured : value.get<double>();
}

}  // namespace

double Measured::ImagePsnrDb() const {
  return 20.0 * std::log10(255.0 / image_rms_grey);
}

json ToJson(const Measured& measured) {
  json out = {{"format", kFormat},
              {"knob", measured.knob},
              {"setting", measured.setting},
              {"repetition", measured.repetition},
              {"seed", measured.seed},
              {"steps", measured.steps},
              {"images", measured.images},
              {"is_reference", measured.is_reference},
              {"unusable", measured.unusable}};
  for (const NumberField& field : kNumbers) {
    const double value = measured.*field.value;
    out[field.key] = std::isnan(value) ? json() : json(value);
  }
  json stages = json::array();
  for (const StageShare& stage : measured.stages) {
    stages.push_back({{"stage", stage.stage},
                      {"rate", stage.rate},
                      {"share", stage.share},
                      {"asleep", stage.asleep}});
  }
  out["stages"] = std::move(stages);
  return out;
}

Measured MeasuredFromJson(const json& document, const std::string& label) {
  try {
    ACUS_REQUIRE(document.at("format") == kFormat, label, ": is no run of acus-tradeoff");
    Measured out;
    out.knob = document.at("knob");
    out.setting = document.at("setting").get<Setting>();
    out.repetition = document.at("repetition");
    out.seed = document.at("seed");
    out.steps = document.at("steps");
    out.images = document.at("images");
    out.is_reference = document.at("is_reference");
    out.unusable = document.at("unusable");
    for (const NumberField& field : kNumbers) {
      out.*field.value = NumberOrNothing(document.at(field.key));
    }
    for (const json& stage : document.at("stages")) {
      out.stages.push_back(
          {stage.at("stage"), stage.at("rate"), stage.at("share"), stage.at("asleep")});
    }
    return out;
  } catch (const json::exception&) {
    throw InputError(Message(label, ": is no run of acus-tradeoff, or a damaged one"));
  }
}

}  // namespace acus::tuning
