#include "acus/assess/tuning/setting.h"

#include "acus/base/core/csv.h"
#include "acus/base/core/words.h"

namespace acus::tuning {

std::string ValueText(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return NumberText(value.get<double>());
  if (value.is_boolean()) return value.get<bool>() ? "on" : "off";
  return value.dump();
}

nlohmann::json ValueFromText(std::string_view text) {
  const std::string word(Trimmed(text));
  if (word == "on") return true;
  if (word == "off") return false;
  nlohmann::json value = nlohmann::json::parse(word, nullptr, /*allow_exceptions=*/false);
  // A folder may be named 2026 or {a}; JSON values of knobs are only numbers and truth values.
  if (value.is_number() || value.is_boolean()) return value;
  return word;
}

std::string TextOf(const Setting& setting) {
  std::string text;
  for (const auto& [name, value] : setting) {
    if (!text.empty()) text += ", ";
    text += name + "=" + ValueText(value);
  }
  return text;
}

bool SameValue(const nlohmann::json& a, const nlohmann::json& b) {
  return a == b;
}

}  // namespace acus::tuning
