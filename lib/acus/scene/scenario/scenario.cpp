#include "acus/scene/scenario/scenario.h"

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/scene/scenario/optional_path.h"

namespace acus::scenario {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// 16 numbers, row by row. The schema has checked their count.
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
  const fs::path path = OptionalPath(object, key, folder);
  if (path.empty()) return {};
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
  patient.ct = OptionalPath(object, "ct", folder);
  patient.labels = OptionalPath(object, "labels", folder);
  patient.trusts_labels = object.at("trust_labels");
  patient.surfaces = OptionalPath(object, "surfaces", folder);
  ACUS_REQUIRE(patient.surfaces.empty() || (patient.ct.empty() && patient.labels.empty()), where,
               ": surfaces stand in place of ct and labels; give those, or surfaces, not both");
  patient.mesh = OptionalPath(object, "mesh", folder);
  if (fs::is_directory(patient.mesh)) patient.mesh /= "mesh.vtu";
  patient.corridor = OptionalPath(object, "corridor", folder);
  patient.dicom_series = object.at("series");
  ACUS_REQUIRE(!(object.contains("ct_from_reference") && object.contains("ct_from_reference_file")),
               where, ": give ct_from_reference or ct_from_reference_file, not both");
  if (object.contains("ct_from_reference")) {
    patient.ct_from_reference =
        RigidOf(object.at("ct_from_reference"), where + "/ct_from_reference");
  }
  const fs::path transform = ExistingPath(object, "ct_from_reference_file", folder, where);
  if (!transform.empty()) patient.ct_from_reference = transforms::ReadTransform(transform);
  if (object.contains("stiffness")) {
    patient.stiffness_seed = object["stiffness"].at("seed");
    patient.num_others = object["stiffness"].at("others");
  }
  return patient;
}

/// The effects of the list that the scenario names, with absolute paths.
std::vector<effects::CalledEffect> CalledEffects(const json& called, const fs::path& folder,
                                                 const std::string& file) {
  std::vector<effects::CalledEffect> found;
  for (const effects::Effect* effect : effects::AllEffects()) {
    if (!called.contains(effect->key())) continue;
    json settings = called.at(std::string(effect->key()));
    effect->Check(settings, Message(file, ": /effects/", effect->key()));
    try {
      effect->ResolveFiles(settings, folder);
    } catch (const InputError& error) {
      throw InputError(Message(file, ": /effects/", effect->key(), ": ", error.what()));
    }
    for (const effects::PathSetting& path : effect->Paths()) {
      if (!settings.contains(path.key)) continue;
      const auto text = settings[path.key].get<std::string>();
      const bool is_preset = path.kind == effects::PathKind::kPreset;
      settings[path.key] = (is_preset ? config::FindConfig(text, folder) : folder / text)
                               .lexically_normal()
                               .string();
    }
    found.push_back({effect, std::move(settings)});
  }
  return found;
}

/// Rules that a schema cannot state: dependencies between effects.
void CheckTogether(const Scenario& s) {
  const std::string file = s.file.string();
  if (s.needle_force && s.needle_force->model == NeedleForceModelKind::kTissue) {
    ACUS_REQUIRE(
        s.tissue && s.tissue->TouchesNeedle(), file,
        ": /effects/needle_force/model is \"tissue\", but no effects/tissue computes forces "
        "on the needle; give it one of the models springs, fe_2d or fe_3d");
  }
  if (s.probe_force && s.probe_force->model == ProbeForceModelKind::kTissue) {
    ACUS_REQUIRE(s.tissue && s.tissue->model == TissueModelKind::kFem3d && s.tissue->probe_contact,
                 file,
                 ": /effects/probe_force/model is \"tissue\", but no effects/tissue is pressed by "
                 "the probe; give it the model fe_3d with fe_3d/probe_contact true");
  }
  if (s.probe_force && s.probe_force->presses_images && s.tissue) {
    ACUS_REQUIRE(!s.tissue->pressed_by_probe && !s.tissue->probe_contact, file,
                 ": /effects/probe_force/multi_proxy/image and /effects/tissue/",
                 s.tissue->probe_contact ? "fe_3d/probe_contact" : "pressed_by_probe",
                 " both press the tissue in the images; set one of them to false");
  }
  if (s.ultrasound && s.ultrasound->from_triangles) {
    ACUS_REQUIRE(
        !s.patient.surfaces.empty(), file,
        ": /effects/ultrasound/alamilla_2021/labels_from is \"triangles\", but there is no "
        "/patient/surfaces; give a list of surfaces, or set it to \"label_map\"");
  }
  if (s.tissue && s.tissue->pressed_by_probe) {
    ACUS_REQUIRE(s.tissue->model != TissueModelKind::kFem3d, file,
                 ": /effects/tissue/pressed_by_probe is for models that the probe does not deform; "
                 "fe_3d computes it: set fe_3d/probe_contact");
  }
  if (s.patient.num_others > 0) {
    ACUS_REQUIRE(s.needle_force, file, ": /patient/stiffness/others is ", s.patient.num_others,
                 ", but there is no effects/needle_force whose range it would report; add it, or "
                 "set others to 0");
    ACUS_REQUIRE(!(s.tissue && s.tissue->model == TissueModelKind::kFem3d), file,
                 ": /patient/stiffness/others is ", s.patient.num_others,
                 ", but the compliance of effects/tissue with fe_3d is that of one patient; set "
                 "others to 0, or choose the model springs or fe_2d");
  }
  if (s.shape) {
    ACUS_REQUIRE(s.needle_force, file,
                 ": /effects/needle says what is across the path of effects/needle_force, which is "
                 "not there; add it, for example --set /effects/needle_force/model=layered");
    ACUS_REQUIRE(!(s.shape->axis_lock && s.shape->model == NeedleModelKind::kBendable), file,
                 ": /effects/needle/axis_lock holds a straight needle on its path; a bendable one "
                 "follows it anyway. Leave axis_lock out, or take the model lateral_beam");
  }
  if (s.needle_force && s.needle_force->guidance != GuidanceKind::kOwn) {
    ACUS_REQUIRE(s.needle_force->model != NeedleForceModelKind::kTissue, file,
                 ": /effects/needle_force/guidance: model \"tissue\" guides the needle by the "
                 "tissue that it deforms; leave guidance at \"own\"");
    ACUS_REQUIRE(
        !s.shape, file,
        ": /effects/needle_force/guidance: effects/needle already computes the force across "
        "the path; leave guidance at \"own\", or take effects/needle out "
        "(--set /effects/needle=null)");
  }
  if (s.tissue && !s.tissue->TouchesNeedle()) {
    ACUS_REQUIRE(s.needle_force, file,
                 ": /effects/tissue/model \"displacement_functions\" moves tissue by the forces "
                 "of effects/needle_force, which is not there; add it, for example "
                 "--set /effects/needle_force/model=layered");
  }
}

}  // namespace

namespace {

/// The changes (--set) whose pointer or value a message contains, or nothing: the error is then in
/// them, not in the file that they change.
std::string BlamedChanges(std::span<const Override> overrides, const std::string& message) {
  std::string blamed;
  for (const Override& change : overrides) {
    const bool names_value =
        change.value.is_string() && change.value.get_ref<const std::string&>().size() > 1 &&
        message.find(change.value.get_ref<const std::string&>()) != message.npos;
    if (message.find(change.pointer) == message.npos && !names_value) continue;
    blamed +=
        Message(blamed.empty() ? "" : ", ", "--set ", change.pointer, "=", change.value.dump());
  }
  return blamed;
}

}  // namespace

nlohmann::json ScenarioSchema() {
  return effects::WithEffects(json::parse(config::SchemaText("acus-scenario")));
}

namespace {

Scenario ReadChanged(const fs::path& path, std::span<const Override> overrides) {
  json document = ScenarioDocument(path, overrides);
  document =
      config::CheckedConfig(std::move(document), "acus-scenario", path.string(), ScenarioSchema());
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
    scenario.needle_force = ReadNeedleForce(effects["needle_force"], folder, path.string());
  }
  if (effects.contains("needle")) {
    scenario.shape = ReadNeedleEffect(effects["needle"], folder);
  }
  if (effects.contains("probe_force")) {
    scenario.probe_force = ReadProbeForce(effects["probe_force"], folder);
  }
  if (effects.contains("tissue")) {
    scenario.tissue = ReadTissueEffect(effects["tissue"], folder);
  }
  if (effects.contains("breathing")) {
    scenario.breathing = ReadBreathingEffect(effects["breathing"], folder);
  }
  if (effects.contains("ultrasound")) {
    scenario.ultrasound = ReadUltrasoundEffect(effects["ultrasound"], folder);
  }
  if (effects.contains("ct_slice")) {
    scenario.ct_slice = ReadCtSliceEffect(effects["ct_slice"]);
  }
  scenario.listed = CalledEffects(effects, folder, path.string());
  CheckTogether(scenario);
  if (document.contains("evidence")) scenario.evidence = EvidenceFrom(document["evidence"]);
  scenario.effective = std::move(document);
  return scenario;
}

}  // namespace

Scenario ReadScenario(const fs::path& path, std::span<const Override> overrides) {
  try {
    return ReadChanged(path, overrides);
  } catch (const InputError& error) {
    const std::string blamed = BlamedChanges(overrides, error.what());
    if (blamed.empty()) throw;
    throw InputError(Message(blamed, ": with this change, ", error.what()));
  }
}

}  // namespace acus::scenario
