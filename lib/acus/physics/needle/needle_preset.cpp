#include "acus/physics/needle/needle_preset.h"

#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::needle {

NeedleProperties ReadNeedle(const std::filesystem::path& path) {
  const nlohmann::json document = config::ReadConfig(path, "acus-needle");
  NeedleProperties needle;
  needle.name = document.at("name");
  needle.gauge = document.at("gauge");
  needle.length_mm = document.at("length_mm");
  needle.graduation_mm = document.at("graduation_mm");
  needle.beam = {document.at("outer_diameter_mm"), document.at("inner_diameter_mm"),
                 document.at("youngs_modulus_gpa").get<double>() * 1e3};
  needle.bevel = {document.at("bevel_curvature_per_mm"),
                  document.at("bevel_roll_deg").get<double>() * std::numbers::pi / 180.0};
  ACUS_REQUIRE(needle.beam.inner_diameter_mm < needle.beam.outer_diameter_mm, path.string(),
               ": /inner_diameter_mm: is ", needle.beam.inner_diameter_mm,
               "; it must be below outer_diameter_mm, ", needle.beam.outer_diameter_mm);
  return needle;
}

RodProperties RodOf(const NeedleProperties& needle) {
  return RodOf(needle.beam, needle.length_mm);
}

}  // namespace acus::needle
