#include "acus/scene/scenario/scenario_document.h"

#include <algorithm>
#include <array>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/scene/effects/effect_list.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::scenario {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Relative to the scenario file; where a change sets them, to the working folder.
constexpr std::array<std::string_view, 9> kPaths = {
    "/patient/ct",          "/patient/labels",           "/patient/surfaces",
    "/patient/mesh",        "/patient/corridor",         "/patient/ct_from_reference_file",
    "/session/plus_config", "/effects/breathing/motion", "/effects/breathing/signal"};
constexpr std::array<std::string_view, 14> kPresets = {
    "/needle",
    "/probe",
    "/effects/needle_force/table",
    "/effects/needle_force/measured",
    "/effects/needle/elasticity",
    "/effects/probe_force/table",
    "/effects/tissue/elasticity",
    "/effects/tissue/table",
    "/effects/ultrasound/acoustics",
    "/effects/ultrasound/display",
    "/effects/ultrasound/aperture/acoustics",
    "/effects/ultrasound/beams/acoustics",
    "/effects/ultrasound/alamilla_2021/acoustics",
    "/effects/ultrasound/vidal_2008/acoustics"};

/// The session's frame is that of the CT.
Override IdentityRegistration() {
  return {"/patient/ct_from_reference", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
}

constexpr std::string_view kTransformFile = "/patient/ct_from_reference_file";
constexpr std::string_view kTransform = "/patient/ct_from_reference";

void Apply(json& document, const Override& given) {
  // A file in place of a matrix, or a matrix in place of a file.
  for (const auto& [one, other] :
       {std::pair{kTransformFile, kTransform}, std::pair{kTransform, kTransformFile}}) {
    const json::json_pointer replaced{std::string(other)};
    if (given.pointer == one && document.contains(replaced)) {
      document.at(replaced.parent_pointer()).erase(replaced.back());
    }
  }
  const bool is_identity = given.pointer == kTransformFile && given.value == "identity";
  const Override change = is_identity ? IdentityRegistration() : given;
  const json::json_pointer pointer(change.pointer);
  if (change.value.is_null()) {
    json& parent = document[pointer.parent_pointer()];
    if (parent.is_object()) parent.erase(pointer.back());
    return;
  }
  json value = change.value;
  if (value.is_string() && std::ranges::find(kPaths, change.pointer) != kPaths.end()) {
    value = fs::absolute(value.get<std::string>()).string();
  }
  document[pointer] = value;
}

void AddPathsOfEffects(effects::PathKind kind, std::vector<std::string>& pointers) {
  for (const effects::Effect* effect : effects::AllEffects()) {
    for (const effects::PathSetting& path : effect->Paths()) {
      if (path.kind == kind) pointers.push_back(Message("/effects/", effect->key(), "/", path.key));
    }
  }
}

/// Whether the schema of scenarios has a text, and nothing else, at a place.
bool IsText(const std::string& pointer) {
  const json schema = ScenarioSchema();
  const json* node = &schema;
  json::json_pointer rest(pointer);
  std::vector<std::string> steps;
  for (; !rest.empty(); rest.pop_back()) steps.push_back(rest.back());
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
    if (!node->contains("properties") || !node->at("properties").contains(*step)) return false;
    node = &node->at("properties").at(*step);
  }
  return node->value("type", json()) == "string";
}

/// A path relative to `folder`, made absolute.
std::string Absolute(const fs::path& path, const fs::path& folder) {
  return fs::absolute(folder / path).lexically_normal().string();
}

}  // namespace

Override ParseOverride(const std::string& text) {
  const auto equals = text.find('=');
  ACUS_REQUIRE(equals != text.npos && text.starts_with("/"), "--set ", text,
               ": must be /json/pointer=value, for example /effects/ultrasound/needle=false");
  const std::string raw = text.substr(equals + 1);
  RequireJsonDepth(raw, Message("--set ", text.substr(0, equals)));
  json value = json::parse(raw, nullptr, /*allow_exceptions=*/false);
  if (value.is_discarded()) {
    // A bare word is a string; text that begins as an object, a list or a quoted string is JSON.
    ACUS_REQUIRE(raw.find_first_of("{[\"") != 0, "--set ", text,
                 ": what follows the '=' is not valid JSON; check its brackets and quotes, and "
                 "protect them from the shell by single quotes");
    value = raw;
  }
  // A part of a UID or a name may look like a number.
  const bool looks_otherwise = value.is_number() || value.is_boolean();
  if (looks_otherwise && IsText(text.substr(0, equals))) value = raw;
  return {text.substr(0, equals), value};
}

json ScenarioDocument(const fs::path& path, std::span<const Override> changes) {
  json document = config::ReadJson(path);
  for (const Override& change : changes) {
    try {
      Apply(document, change);
    } catch (const json::exception&) {
      throw InputError(Message("--set ", change.pointer, ": cannot be set: ", path.string(),
                               " has no such place, or a value and no object lies above it"));
    }
  }
  return document;
}

std::vector<std::string> PathPointers() {
  std::vector<std::string> pointers(kPaths.begin(), kPaths.end());
  AddPathsOfEffects(effects::PathKind::kFile, pointers);
  return pointers;
}

std::vector<std::string> PresetPointers() {
  std::vector<std::string> pointers(kPresets.begin(), kPresets.end());
  AddPathsOfEffects(effects::PathKind::kPreset, pointers);
  return pointers;
}

json ForAnyFolder(json document, const fs::path& folder) {
  const auto at = [&document](const std::string& pointer) -> json* {
    const json::json_pointer place(pointer);
    if (!document.contains(place) || !document.at(place).is_string()) return nullptr;
    json& text = document.at(place);
    return text.get_ref<const std::string&>().empty() ? nullptr : &text;  // Empty: no path.
  };
  for (const std::string& pointer : PathPointers()) {
    if (json* path = at(pointer)) *path = Absolute(path->get<std::string>(), folder);
  }
  for (const std::string& pointer : PresetPointers()) {
    json* preset = at(pointer);
    if (preset == nullptr) continue;
    const fs::path name = preset->get<std::string>();
    // In the order of FindConfig: beside the scenario, among the presets, in the working folder.
    if (fs::exists(folder / name)) {
      *preset = Absolute(name, folder);
    } else if (!fs::exists(config::ConfigsFolder() / name) && fs::exists(name)) {
      *preset = Absolute(name, fs::current_path());
    }
  }
  for (const effects::Effect* effect : effects::AllEffects()) {
    const json::json_pointer place(Message("/effects/", effect->key()));
    if (document.contains(place)) effect->ResolveFiles(document.at(place), folder);
  }
  return document;
}

Override ForAnyFolder(Override change, const fs::path& folder) {
  json document;
  const json::json_pointer place(change.pointer);
  document[place] = std::move(change.value);
  document = ForAnyFolder(std::move(document), folder);
  change.value = document.at(place);
  return change;
}

}  // namespace acus::scenario
