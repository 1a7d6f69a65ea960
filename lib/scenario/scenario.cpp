#include "scenario/scenario.h"

#include "config/json_file.h"
#include "core/error.h"
#include "math/rigid.h"
#include "registration/transform_file.h"
#include "session/plus_config.h"

namespace acus::scenario {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Paths that overrides may set, which are relative to the working folder then.
constexpr const char* kPaths[] = {"/patient/ct", "/patient/labels",
                                  "/patient/ct_from_reference_file", "/session/plus_config"};

void Apply(json& document, const Override& change) {
  const json::json_pointer pointer(change.pointer);
  if (change.value.is_null()) {
    json& parent = document[pointer.parent_pointer()];
    if (parent.is_object()) parent.erase(pointer.back());
    return;
  }
  json value = change.value;
  for (const char* path : kPaths) {
    if (change.pointer == path && value.is_string()) {
      value = fs::absolute(value.get<std::string>()).string();
    }
  }
  document[pointer] = value;
}

/// 16 numbers, row by row. The schema has made sure of their count.
Eigen::Matrix4d MatrixOf(const json& rows) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = rows[static_cast<std::size_t>(i)];
  return matrix;
}

Eigen::Isometry3d RigidOf(const json& rows, const std::string& where) {
  try {
    return math::RigidFromMatrix(MatrixOf(rows));
  } catch (const InputError& error) {
    throw InputError(Message(where, ": ", error.what()));
  }
}

fs::path ExistingPath(const json& object, const char* key, const fs::path& folder,
                      const std::string& where) {
  if (!object.contains(key)) return {};
  const fs::path path = (folder / object.at(key).get<std::string>()).lexically_normal();
  ACUS_REQUIRE(fs::exists(path), where, "/", key, ": ", path.string(),
               ": no such file or folder; paths are relative to the scenario file");
  return path;
}

session::ImportOptions ReadImport(const json& object, const fs::path& folder,
                                  const std::string& where) {
  session::ImportOptions options;
  const fs::path plus_config = ExistingPath(object, "plus_config", folder, where);
  if (!plus_config.empty()) options.calibrations = session::ReadPlusCalibrations(plus_config);
  options.needle_frames = object.at("needle_frames").get<std::vector<std::string>>();
  options.probe_frames = object.at("probe_frames").get<std::vector<std::string>>();
  options.reference_frame = object.at("reference_frame");
  for (const auto& [name, rows] : object.at("calibrations").items()) {
    options.calibrations[name] = MatrixOf(rows);
  }
  if (object.contains("face_px")) {
    options.face_px = Eigen::Vector2d(object["face_px"][0], object["face_px"][1]);
  }
  return options;
}

Patient ReadPatient(const json& object, const fs::path& folder, const std::string& file) {
  const std::string where = file + ": /patient";
  Patient patient;
  patient.ct = ExistingPath(object, "ct", folder, where);
  patient.labels = ExistingPath(object, "labels", folder, where);
  patient.dicom_series = object.at("series");
  ACUS_REQUIRE(!(object.contains("ct_from_reference") && object.contains("ct_from_reference_file")),
               where, ": give ct_from_reference or ct_from_reference_file, not both");
  if (object.contains("ct_from_reference")) {
    patient.ct_from_reference =
        RigidOf(object.at("ct_from_reference"), where + "/ct_from_reference");
  }
  const fs::path transform = ExistingPath(object, "ct_from_reference_file", folder, where);
  if (!transform.empty()) patient.ct_from_reference = registration::ReadTransform(transform);
  return patient;
}

}  // namespace

Override ParseOverride(const std::string& text) {
  const auto equals = text.find('=');
  ACUS_REQUIRE(equals != text.npos && text.starts_with("/"), "--set ", text,
               ": must be /json/pointer=value, for example /effects/ultrasound/needle=false");
  const std::string raw = text.substr(equals + 1);
  json value = json::parse(raw, nullptr, /*allow_exceptions=*/false);
  if (value.is_discarded()) value = raw;
  return {text.substr(0, equals), value};
}

Scenario ReadScenario(const fs::path& path, std::span<const Override> overrides) {
  json document = config::ReadJson(path);
  for (const Override& change : overrides) {
    try {
      Apply(document, change);
    } catch (const json::exception&) {
      throw InputError(Message("--set ", change.pointer, ": cannot be set: ", path.string(),
                               " has no such place, or a value and no object lies above it"));
    }
  }
  document = config::CheckedConfig(std::move(document), "acus-scenario", path.string());
  const fs::path folder = fs::absolute(path).parent_path();

  Scenario scenario;
  scenario.file = path;
  scenario.name = document.at("name");
  scenario.patient = ReadPatient(document.at("patient"), folder, path.string());
  scenario.session = ReadImport(document.at("session"), folder, path.string() + ": /session");
  scenario.needle = config::FindConfig(document.at("needle").get<std::string>(), folder);
  scenario.probe = config::FindConfig(document.at("probe").get<std::string>(), folder);
  scenario.image_rate_hz = document.at("image_rate_hz");

  const json& effects = document.at("effects");
  if (effects.contains("needle_force")) {
    const std::string table = effects["needle_force"].at("table");
    scenario.needle_force =
        NeedleForceEffect{NeedleForceModelKind::kLayered, config::FindConfig(table, folder)};
  }
  if (effects.contains("ultrasound")) {
    const json& effect = effects["ultrasound"];
    const std::string table = effect.at("acoustics");
    scenario.ultrasound = UltrasoundEffect{UltrasoundModel::kColumns2010,
                                           config::FindConfig(table, folder), effect.at("needle")};
  }
  if (effects.contains("ct_slice")) {
    scenario.ct_slice = CtSliceEffect{effects["ct_slice"].at("needle")};
  }
  scenario.effective = std::move(document);
  return scenario;
}

}  // namespace acus::scenario
