#include "acus/patient/registration/result_folder.h"

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::registration {

using nlohmann::json;

std::string VectorText(const Eigen::Vector3d& v, int decimals) {
  return FixedText(v.x(), decimals) + "  " + FixedText(v.y(), decimals) + "  " +
         FixedText(v.z(), decimals);
}

void WriteResult(const std::filesystem::path& folder, json document, const RunContext& context) {
  document["provenance"] = context.provenance.ToJson();
  config::WriteJson(folder / "registration.json", document);
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

transforms::Landmarks ReadPoints(const std::filesystem::path& path, RunContext& context) {
  context.provenance.AddInput(path);
  return transforms::ReadLandmarks(path);
}

Eigen::Vector3d TipFrom(const std::vector<double>& numbers) {
  if (numbers.empty()) return Eigen::Vector3d::Zero();
  ACUS_REQUIRE(numbers.size() == 3, "the tip needs three numbers (x,y,z in mm), got ",
               numbers.size());
  const Eigen::Vector3d tip_mm(numbers.data());
  ACUS_REQUIRE(tip_mm.allFinite() && tip_mm.norm() <= 2000.0,
               "the tip must be within 2000 mm of the tool's origin, got (", tip_mm.transpose(),
               ")");
  return tip_mm;
}

Eigen::Vector3d ReadTip(const std::filesystem::path& path, RunContext& context) {
  context.provenance.AddInput(path);
  const json document = config::ReadJson(path);
  const bool is_pivot = document.is_object() && document.value("format", json()) == "acus-pivot/1";
  ACUS_REQUIRE(is_pivot && document.contains("tip_mm") && document["tip_mm"].is_array(),
               path.string(),
               ": is not a pivot calibration (format acus-pivot/1); make one with "
               "'acus-register pivot'");
  std::vector<double> numbers;
  for (const json& number : document["tip_mm"]) {
    ACUS_REQUIRE(number.is_number(), path.string(), ": /tip_mm: must be three numbers");
    numbers.push_back(number.get<double>());
  }
  ACUS_REQUIRE(numbers.size() == 3, path.string(), ": /tip_mm: must be three numbers");
  return TipFrom(numbers);
}

}  // namespace acus::registration
