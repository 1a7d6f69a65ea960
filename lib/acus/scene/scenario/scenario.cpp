#include "acus/scene/scenario/scenario.h"

#include <map>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/transforms/transform_file.h"

namespace acus::scenario {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

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

/// Of a file that need not be there: only effects that read it ask for it.
fs::path PathOf(const json& object, const char* key, const fs::path& folder) {
  if (!object.contains(key)) return {};
  return (folder / object.at(key).get<std::string>()).lexically_normal();
}

fs::path ExistingPath(const json& object, const char* key, const fs::path& folder,
                      const std::string& where) {
  const fs::path path = PathOf(object, key, folder);
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
  patient.ct = PathOf(object, "ct", folder);
  patient.labels = PathOf(object, "labels", folder);
  patient.surfaces = PathOf(object, "surfaces", folder);
  ACUS_REQUIRE(patient.surfaces.empty() || (patient.ct.empty() && patient.labels.empty()), where,
               ": surfaces stand in place of ct and labels; give those, or surfaces, not both");
  patient.mesh = PathOf(object, "mesh", folder);
  if (fs::is_directory(patient.mesh)) patient.mesh /= "mesh.vtu";
  patient.corridor = PathOf(object, "corridor", folder);
  patient.dicom_series = object.at("series");
  ACUS_REQUIRE(!(object.contains("ct_from_reference") && object.contains("ct_from_reference_file")),
               where, ": give ct_from_reference or ct_from_reference_file, not both");
  if (object.contains("ct_from_reference")) {
    patient.ct_from_reference =
        RigidOf(object.at("ct_from_reference"), where + "/ct_from_reference");
  }
  const fs::path transform = ExistingPath(object, "ct_from_reference_file", folder, where);
  if (!transform.empty()) patient.ct_from_reference = transforms::ReadTransform(transform);
  return patient;
}

ProbeForceEffect ReadProbeForce(const json& object, const fs::path& folder) {
  const json& settings = object.at("multi_proxy");
  ProbeForceEffect effect;
  static const std::map<std::string, ProbeForceModelKind> kModels = {
      {"vidal", ProbeForceModelKind::kVidal},
      {"multi_proxy", ProbeForceModelKind::kMultiProxy},
      {"tissue", ProbeForceModelKind::kTissue}};
  effect.model = kModels.at(object.at("model"));
  effect.table = config::FindConfig(object.at("table").get<std::string>(), folder);
  effect.press_mm = object.at("press_mm");
  effect.reads_labels =
      effect.model == ProbeForceModelKind::kMultiProxy && settings.at("reads") == "labels";
  effect.is_fingertip = settings.at("tool") == "fingertip";
  effect.num_proxies = settings.at("proxies");
  effect.face_width_mm = settings.at("face_width_mm");
  effect.fingertip_radius_mm = settings.at("fingertip_radius_mm");
  return effect;
}

TissueEffect ReadTissueEffect(const json& object, const fs::path& folder) {
  static const std::map<std::string, TissueModelKind> kModels = {
      {"displacement_functions", TissueModelKind::kDisplacementFunctions},
      {"springs", TissueModelKind::kSprings},
      {"fe_2d", TissueModelKind::kPlane2010},
      {"fe_3d", TissueModelKind::kFem3d}};
  TissueEffect effect;
  effect.model = kModels.at(object.at("model"));
  effect.elasticity = config::FindConfig(object.at("elasticity").get<std::string>(), folder);
  effect.table = config::FindConfig(object.at("table").get<std::string>(), folder);
  effect.image = object.at("image");
  effect.pressed_by_probe = object.at("pressed_by_probe");
  effect.warp_spacing_mm = object.at("warp_spacing_mm");
  effect.inverse_iterations = object.at("inverse_iterations");
  const json& springs = object.at("springs");
  effect.path_spacing_mm = springs.at("path_spacing_mm");
  effect.influence_radius_mm = effect.model == TissueModelKind::kSprings
                                   ? springs.at("influence_radius_mm")
                                   : object.at("displacement_functions").at("influence_radius_mm");
  const json& plane = object.at("fe_2d");
  effect.plane_spacing_mm = plane.at("spacing_mm");
  effect.plane_width_mm = plane.at("width_mm");
  effect.plane_turned = plane.at("turned_planes");
  effect.plane_beyond_mm = plane.at("beyond_mm");
  effect.plane_thickness_mm = plane.at("thickness_mm");
  effect.element = object.at("fe_3d").at("element");
  effect.contact_spacing_mm = object.at("fe_3d").at("contact_spacing_mm");
  effect.probe_contact = object.at("fe_3d").at("probe_contact");
  effect.finite_strain = object.at("fe_3d").at("law") == "finite_strain";
  effect.strain_nodes = object.at("fe_3d").at("strain_nodes");
  effect.strain_iterations = object.at("fe_3d").at("strain_iterations");
  return effect;
}

NeedleEffect ReadNeedleEffect(const json& object, const fs::path& folder) {
  static const std::map<std::string, NeedleModelKind> kModels = {
      {"rigid", NeedleModelKind::kRigid},
      {"lateral_beam", NeedleModelKind::kLateralBeam},
      {"bendable", NeedleModelKind::kBendable}};
  NeedleEffect effect;
  effect.model = kModels.at(object.at("model"));
  effect.axis_lock = object.at("axis_lock");
  effect.elasticity = config::FindConfig(object.at("elasticity").get<std::string>(), folder);
  effect.influence_radius_mm = object.at("influence_radius_mm");
  effect.nodes = object.at("nodes");
  effect.path_spacing_mm = object.at("path_spacing_mm");
  effect.tip_stiffness_n_per_mm = object.at("tip_stiffness_n_per_mm");
  effect.hand_n_per_mm = object.at("hand").at("stiffness_n_per_mm");
  effect.hand_n_mm_per_rad = object.at("hand").at("stiffness_n_mm_per_rad");
  effect.kappa_n_per_mm = object.at("hand").at("kappa_n_per_mm");
  effect.bevel = object.at("bevel");
  return effect;
}

BreathingEffect ReadBreathingEffect(const json& object, const fs::path& folder) {
  BreathingEffect effect;
  effect.motion = PathOf(object, "motion", folder);
  effect.signal = PathOf(object, "signal", folder);
  effect.amplitude = object.at("amplitude");
  effect.signal_file = {object.at("column"), object.at("rate_hz")};
  effect.recorded = {object.at("smoothing_s"), object.at("repeat")};
  effect.normalise = object.at("normalise");
  const json& pattern = object.at("pattern");
  effect.pattern = {.period_s = pattern.at("period_s"),
                    .exponent = pattern.at("exponent"),
                    .period_spread = pattern.at("period_spread"),
                    .speed_spread = pattern.at("speed_spread"),
                    .level_spread = pattern.at("level_spread"),
                    .level = pattern.at("level"),
                    .seed = pattern.at("seed")};
  const std::string from_session = object.at("from_session");
  if (from_session == "always") effect.from_session = SessionBreath::kAlways;
  if (from_session == "never") effect.from_session = SessionBreath::kNever;
  for (const json& hold : object.at("hold")) effect.holds.push_back({hold.at(0), hold.at(1)});
  effect.image = object.at("image");
  effect.warp_spacing_mm = object.at("warp_spacing_mm");
  effect.inverse_iterations = object.at("inverse_iterations");
  return effect;
}

/// Those of the list of effects that are called for, their paths as from anywhere.
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

/// The file of needle_force.model measured, and which of its laws.
void ReadMeasured(const json& effect, const fs::path& folder, const std::string& file,
                  NeedleForceEffect& force) {
  const std::string where = file + ": /effects/needle_force";
  const bool is_measured = force.model == NeedleForceModelKind::kMeasured;
  ACUS_REQUIRE(is_measured == effect.contains("measured"), where,
               is_measured ? ": model \"measured\" needs the file of the fit, measured: the "
                             "measured.json that acus-fit writes"
                           : "/measured: only model \"measured\" reads it; set the model, or "
                             "leave it out");
  if (!is_measured) return;
  force.measured = config::FindConfig(effect.at("measured").get<std::string>(), folder);
  force.recording = effect.at("recording");
  force.seed = effect.at("seed");
  ACUS_REQUIRE(force.seed == 0 || force.recording == "mean", where, "/seed: is ", force.seed,
               ", which draws from all recordings, but recording is '", force.recording,
               "'; leave one of the two out");
}

/// What the schema cannot say: effects that lean on one another.
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
  if (s.tissue && s.tissue->pressed_by_probe) {
    ACUS_REQUIRE(s.tissue->model != TissueModelKind::kFem3d, file,
                 ": /effects/tissue/pressed_by_probe is for models that the probe does not deform; "
                 "fe_3d computes it: set fe_3d/probe_contact");
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

/// The changes (--set) whose place or value a message names, or nothing: their user made the
/// mistake, not the file that they change.
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
    const json& effect = effects["needle_force"];
    const std::string table = effect.at("table");
    static const std::map<std::string, NeedleForceModelKind> kModels = {
        {"layered", NeedleForceModelKind::kLayered},
        {"alamilla", NeedleForceModelKind::kAlamilla},
        {"vidal", NeedleForceModelKind::kVidal},
        {"measured", NeedleForceModelKind::kMeasured},
        {"tissue", NeedleForceModelKind::kTissue}};
    static const std::map<std::string, GuidanceKind> kGuidance = {
        {"own", GuidanceKind::kOwn},
        {"none", GuidanceKind::kNone},
        {"vidal", GuidanceKind::kVidal},
        {"virtual_fixture", GuidanceKind::kVirtualFixture}};
    NeedleForceEffect& force = scenario.needle_force.emplace();
    force.model = kModels.at(effect.at("model"));
    force.guidance = kGuidance.at(effect.at("guidance"));
    force.table = config::FindConfig(table, folder);
    ReadMeasured(effect, folder, path.string(), force);
    force.skin_nick_radius_mm = effect.at("skin_nick_radius_mm");
    const bool goes_by_membranes = force.model != NeedleForceModelKind::kMeasured &&
                                   force.model != NeedleForceModelKind::kTissue;
    ACUS_REQUIRE(force.skin_nick_radius_mm == 0.0 || goes_by_membranes, path.string(),
                 ": /effects/needle_force/skin_nick_radius_mm: only the models layered, alamilla "
                 "and vidal have a nick in the skin; leave it out");
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
    const json& effect = effects["ct_slice"];
    scenario.ct_slice = CtSliceEffect{effect.at("needle"), effect.at("window").at("centre_hu"),
                                      effect.at("window").at("width_hu")};
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
