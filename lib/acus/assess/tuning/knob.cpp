#include "acus/assess/tuning/knob.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/words.h"

namespace acus::tuning {
namespace {

using nlohmann::json;

std::vector<std::string> NamesOf(std::span<const Knob> knobs) {
  std::vector<std::string> names;
  for (const Knob& knob : knobs) names.push_back(knob.name);
  return names;
}

bool Holds(const std::vector<json>& values, const json& value) {
  return std::ranges::any_of(values, [&](const json& v) { return SameValue(v, value); });
}

/// Numbers from cheap to expensive; words and truth values in the order of the knob.
void Order(const Knob& knob, std::vector<json>& values) {
  const auto rank = [&knob](const json& value) {
    return std::ranges::find_if(knob.values, [&](const json& v) { return SameValue(v, value); }) -
           knob.values.begin();
  };
  std::ranges::stable_sort(values, [&](const json& a, const json& b) {
    if (a.is_number() && b.is_number()) {
      return knob.falls ? a.get<double>() > b.get<double>() : a.get<double>() < b.get<double>();
    }
    return rank(a) < rank(b);
  });
}

/// @throws InputError if the type of `value` is not that of the knob.
void RequireKind(const Knob& knob, const json& value) {
  if (knob.is_folder) {
    const std::filesystem::path folder = ValueText(value);
    ACUS_REQUIRE(std::filesystem::exists(folder), "--knob ", knob.name, ": ", folder.string(),
                 ": no such folder");
    return;
  }
  if (knob.values.empty()) return;
  const json& like = knob.values.front();
  std::vector<std::string> values;
  for (const json& allowed : knob.values) values.push_back(ValueText(allowed));
  if (like.is_number()) {
    ACUS_REQUIRE(value.is_number(), "--knob ", knob.name, ": ", ValueText(value),
                 " is not a number; values are for example ", Joined(values));
    return;
  }
  const auto nearest = NearestSpelling(ValueText(value), values);
  ACUS_REQUIRE(Holds(knob.values, value), "--knob ", knob.name, ": there is no value '",
               ValueText(value), "'", nearest ? "; did you mean " + *nearest + "?" : "",
               " Values: ", Joined(values));
}

std::vector<json> ValuesOf(const Knob& knob, const std::string& list) {
  std::vector<json> values;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string text = list.substr(begin, end - begin);
    ACUS_REQUIRE(!Trimmed(text).empty(), "--knob ", knob.name, "=", list,
                 ": a value is missing; give values between commas");
    json value = knob.is_folder ? json(std::string(Trimmed(text))) : ValueFromText(text);
    RequireKind(knob, value);
    if (!Holds(values, value)) values.push_back(std::move(value));
    begin = end + 1;
  }
  return values;
}

}  // namespace

std::string_view NameOf(ActsOn acts_on) {
  switch (acts_on) {
    case ActsOn::kForce:
      return "force";
    case ActsOn::kImage:
      return "image";
    case ActsOn::kBoth:
      return "force and image";
  }
  ACUS_ASSERT(false);
}

bool Knob::IsPapers(const json& value) const {
  return std::ranges::any_of(papers,
                             [&](const PaperValue& p) { return SameValue(p.value, value); });
}

const Knob& KnobNamed(std::span<const Knob> knobs, std::string_view name) {
  const auto found = std::ranges::find(knobs, name, &Knob::name);
  if (found != knobs.end()) return *found;
  const std::vector<std::string> names = NamesOf(knobs);
  const auto nearest = NearestSpelling(name, names);
  throw InputError(Message("--knob ", name, ": this scene has no such knob",
                           nearest ? "; did you mean " + *nearest + "?" : ".",
                           " What it calls for has: ", Joined(names)));
}

Knob KnobFromText(std::span<const Knob> knobs, const std::string& text) {
  const std::size_t equals = text.find('=');
  Knob knob = KnobNamed(knobs, text.substr(0, equals));
  std::vector<json> values = knob.values;
  if (equals != text.npos) values = ValuesOf(knob, text.substr(equals + 1));
  const bool adds_own = equals == text.npos || values.size() == 1;
  if (adds_own && !knob.scenario_value.is_null() && !Holds(values, knob.scenario_value)) {
    values.push_back(knob.scenario_value);
  }
  if (!knob.is_folder) Order(knob, values);
  ACUS_REQUIRE(values.size() >= 2, "--knob ", text,
               ": needs at least two values to compare: --knob ", knob.name, "=",
               knob.is_folder ? "FOLDER_A,FOLDER_B" : "a,b", ", from cheap to expensive");
  knob.values = std::move(values);
  return knob;
}

std::vector<scenario::Override> OverridesOf(std::span<const Knob> knobs, const Setting& setting) {
  std::vector<scenario::Override> overrides;
  for (const auto& [name, value] : setting) {
    const Knob& knob = KnobNamed(knobs, name);
    json changed = value;
    if (knob.is_folder) changed = std::filesystem::absolute(ValueText(value)).string();
    for (const std::string& pointer : knob.pointers) overrides.push_back({pointer, changed});
  }
  return overrides;
}

}  // namespace acus::tuning
