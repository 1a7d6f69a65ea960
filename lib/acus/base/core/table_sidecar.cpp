#include "acus/base/core/table_sidecar.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/words.h"

namespace acus {
namespace {

constexpr std::uintmax_t kMostSidecarBytes = 1U << 20U;

double NumberOf(const nlohmann::json& document, const char* key, const std::string& label) {
  const auto& value = document.at(key);
  ACUS_REQUIRE(value.is_number(), label, ": ", key, " is not a number");
  return value.get<double>();
}

}  // namespace

TableSidecar SidecarOf(const std::filesystem::path& table) {
  TableSidecar sidecar;
  if (table.extension() != ".tsv") return sidecar;
  auto path = table;
  path.replace_extension(".json");
  if (!std::filesystem::exists(path)) return sidecar;
  const std::string label = path.string();
  RequireInputFile(path, kMostSidecarBytes);
  const std::string text = ReadTextFile(path);
  RequireJsonDepth(text, label);
  const auto document = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  ACUS_REQUIRE(document.is_object(), label,
               ": is not a JSON object; it is read as the description "
               "of ",
               table.filename().string());
  sidecar.path = path;
  for (const auto& [key, value] : document.items()) {
    if (!value.is_object() || !value.contains("Units")) continue;
    ACUS_REQUIRE(value["Units"].is_string(), label, ": Units of ", key, " are not a text");
    sidecar.units[key] = value["Units"];
  }
  if (document.contains("Columns")) {
    const auto& columns = document["Columns"];
    const auto is_text = [](const nlohmann::json& name) { return name.is_string(); };
    ACUS_REQUIRE(columns.is_array() && std::ranges::all_of(columns, is_text), label,
                 ": Columns is not a list of names");
    sidecar.columns = columns.get<std::vector<std::string>>();
  }
  if (document.contains("SamplingFrequency")) {
    sidecar.rate_hz = NumberOf(document, "SamplingFrequency", label);
    ACUS_REQUIRE(*sidecar.rate_hz > 1e-6 && *sidecar.rate_hz < 1e9, label,
                 ": SamplingFrequency is ", *sidecar.rate_hz, " Hz; 1e-6 to 1e9 are possible");
  }
  if (document.contains("StartTime")) sidecar.start_s = NumberOf(document, "StartTime", label);
  return sidecar;
}

std::string WithTimes(const std::string& text, double rate_hz, double start_s) {
  std::string out;
  std::size_t row = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1);
    const std::string_view line = std::string_view(text).substr(begin, end + 1 - begin);
    begin = end + 1;
    if (!Trimmed(line).empty()) {
      out += NumberText(start_s + static_cast<double>(row++) / rate_hz) + "\t";
    }
    out += line;
  }
  return out;
}

}  // namespace acus
