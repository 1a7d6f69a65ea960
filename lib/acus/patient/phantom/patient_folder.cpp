#include "acus/patient/phantom/patient_folder.h"

#include <cmath>
#include <optional>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/random.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/label_map_content.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/phantom/hands/demonstration.h"
#include "acus/patient/phantom/planning/insertion_summary.h"
#include "acus/patient/phantom/planning/scene_plan.h"

namespace acus::phantom {
namespace {

/// For exercises/spinal.json, where the path leads to the spinal canal: the stylet is removed.
const FluidDemonstration kSpinalDemonstration{.exercise = "spinal", .plunger_n = -2, .hold_s = 15};

using Eigen::Vector3d;
using Json = nlohmann::json;

Json ToJson(const InsertionPlan& plan) {
  Json json = {{"entry_ct_mm", config::Row(plan.entry_ct_mm)},
               {"target_ct_mm", config::Row(plan.target_ct_mm)},
               {"direction", config::Row(plan.direction)},
               {"skin_normal", config::Row(plan.skin_normal)},
               {"heading", config::Row(plan.heading)},
               {"length_mm", plan.length_mm()},
               {"bone_angle_deg", nullptr},
               {"bone_depth_mm", nullptr}};
  if (plan.bone_angle_rad) {
    json["bone_angle_deg"] = *plan.bone_angle_rad * 180.0 / std::numbers::pi;
    json["bone_axis"] = config::Row(plan.bone_axis);
    json["bone_depth_mm"] = plan.bone_depth_mm;
  }
  return json;
}

Json ToJson(const forces::CurveParameters& p) {
  return {{"contact_depth_mm", p.contact_depth_mm},
          {"a1_n_per_mm", p.a1_n_per_mm},
          {"a2_n_per_mm2", p.a2_n_per_mm2},
          {"puncture_depth_mm", p.puncture_depth_mm},
          {"plateau_n", p.plateau_n},
          {"plateau_slope_n_per_mm", p.plateau_slope_n_per_mm},
          {"friction_n_per_mm", p.friction_n_per_mm},
          {"relaxation_fraction", p.relaxation_fraction},
          {"relaxation_time_s", p.relaxation_time_s},
          {"offset_n", p.offset_n}};
}

/// What WriteInsertion has written.
struct Insertion {
  Json truth;
  std::string text;  ///< For people.
};

/// Places markers and plays the session; writes all of it.
Insertion WriteInsertion(const std::filesystem::path& folder, const PatientField& field,
                         const InsertionPlan& plan, const SceneChoice& choice,
                         const PhantomConfig& config, const RunContext& context) {
  const auto markers = PlaceMarkers(field, plan, config.markers, context);
  WritePoints(folder / "markers_ct.csv", markers);
  WritePoints(folder / "markers_mannequin.csv",
              LocateOnMannequin(markers, config.markers, context.seed));
  WritePoints(folder / "target_ct.csv", {{"target", plan.target_ct_mm}});
  WritePoints(folder / "corridor_ct.csv",
              {{"entry", plan.entry_ct_mm}, {"target", plan.target_ct_mm}});
  const ScriptedSession scripted =
      PlayScript(field, plan, config.session, config.markers.reference_from_ct, context);
  std::filesystem::create_directory(folder / "sessions");
  session::WriteSession(folder / "sessions" / config.session.name, scripted.session, context);
  std::vector<SessionSettings> demonstrations = {DemonstrationOf(field, plan, config.session)};
  std::vector<FluidDemonstration> with_fluid = config.session.demonstrations;
  if (auto epidural = EpiduralDemonstrationOf(field, plan, config.session)) {
    demonstrations.push_back(std::move(*epidural));
    with_fluid.push_back(kSpinalDemonstration);
  }
  for (const FluidDemonstration& fluid : with_fluid) {
    demonstrations.push_back(FluidDemonstrationOf(field, plan, config.session, fluid));
  }
  for (const SessionSettings& shown : demonstrations) {
    session::WriteSession(
        folder / shown.name,
        PlayScript(field, plan, shown, config.markers.reference_from_ct, context).session, context);
  }
  Json events = Json::array();
  for (const NeedleEvent& event : scripted.events) {
    events.push_back({{"time_s", event.time_s},
                      {"kind", event.kind},
                      {"tissue", event.tissue},
                      {"depth_mm", event.depth_mm}});
  }
  Json points = Json::object();
  for (const NamedPoint& marker : markers) points[marker.name] = config::Row(marker.position_mm);
  const std::vector<PathPart> parts = TissuesAlong(field, plan);
  Json insertion = ToJson(plan);
  insertion.update(ChoiceJson(choice, parts));
  Json truth = {
      {"format", "acus-truth/1"},
      {"seed", context.seed},
      {"config", config.document},
      {"reference_from_ct", config::MatrixRows(config.markers.reference_from_ct)},
      {"fle_mm", config.markers.fle_mm},
      {"markers_ct_mm", points},
      {"insertion", insertion},
      {"sessions",
       {{config.session.name,
         {{"duration_s", 1e-9 * static_cast<double>(scripted.session.needle.back().time_ns)},
          {"events", events}}}}}};
  return {truth, InsertionText(plan, choice, parts, scripted)};
}

void WarnWithoutBone(const InsertionPlan& plan, const RunContext& context) {
  if (plan.bone_angle_rad) return;
  context.Warn("no bone lies near the path: the session is made without touching bone");
}

/// Where the volume's border takes the place of the skin.
constexpr const char* kNoSkin =
    ". The CT shows no skin there: its border takes the place of the skin";

void WarnOfView(const SceneChoice& choice, const RunContext& context) {
  if (!choice.view || choice.view->target >= 0.5) return;
  context.Warn(Message("the probe does not see the target: in the image are ",
                       ViewText(*choice.view), ". Another --target or --window may be better"));
}

/// The settings' parameters, each varied by its spread.
forces::CurveParameters Varied(const ForceCurveSettings& settings, std::uint64_t seed, int index) {
  RandomStream random(seed, "parameters of force curve " + settings.name,
                      static_cast<std::uint64_t>(index));
  forces::CurveParameters p = settings.parameters;
  for (double* value : {&p.a1_n_per_mm, &p.a2_n_per_mm2, &p.puncture_depth_mm, &p.plateau_n,
                        &p.plateau_slope_n_per_mm, &p.friction_n_per_mm}) {
    *value *= std::max(1.0 + 0.01 * settings.spread_percent * random.Normal(), 0.2);
  }
  return p;
}

Json WriteForceCurves(const std::filesystem::path& folder, const PhantomConfig& config,
                      const RunContext& context) {
  std::filesystem::create_directory(folder);
  Json truth = Json::object();
  for (const ForceCurveSettings& settings : config.force_curves) {
    for (int i = 0; i < settings.count; ++i) {
      const std::string name = settings.name + "_" + std::to_string(i + 1);
      const forces::CurveParameters parameters = Varied(settings, context.seed, i);
      RandomStream seeds(context.seed, "noise of force curve " + name);
      const auto curve = forces::SynthesizeForceCurve(parameters, settings.drive, settings.noise_n,
                                                      seeds.Next(), name);
      forces::WriteForceCurve(folder / (name + ".csv"), curve);
      truth[name] = ToJson(parameters);
      truth[name]["noise_n"] = settings.noise_n;
    }
  }
  return truth;
}

Json VolumesMl(const volume::LabelMap& labels) {
  const auto count = volume::CountsByLabel(labels);
  Json volumes = Json::object();
  for (const auto& [label, name] : labels.names) {
    volumes[name] = 1e-3 * labels.geometry.voxel_volume_mm3() * static_cast<double>(count[label]);
  }
  return volumes;
}

/// Whether the volume's border cuts the body.
bool IsCut(const volume::LabelMap& labels) {
  const Eigen::Array3i last = labels.geometry.size - 1;
  for (int k = 0; k <= last[2]; ++k) {
    for (int j = 0; j <= last[1]; ++j) {
      const bool edge_row = k == 0 || k == last[2] || j == 0 || j == last[1];
      for (int i = 0; i <= last[0]; i += edge_row ? 1 : std::max(1, last[0])) {
        if (labels.At(i, j, k) != 0) return true;
      }
    }
  }
  return false;
}

}  // namespace

std::string WritePatient(const std::filesystem::path& folder, const PhantomConfig& config,
                         const RunContext& context) {
  AtomicFolder out(folder, context.overwrite);
  const Anatomy anatomy(config.body, context.seed);
  const AnatomyField field(anatomy, config.grid);
  ACUS_REQUIRE(!config.insertion.target.empty(),
               "/insertion/target: name a landmark of the anatomy");
  const Vector3d target = anatomy.Landmark(config.insertion.target) + config.insertion.offset_mm;
  const InsertionPlan plan = PlanToTarget(field, target, config.insertion, context);
  WarnWithoutBone(plan, context);
  Insertion insertion =
      WriteInsertion(out.path(), field, plan,
                     {.title = "", .target = config.insertion.target, .window = "", .reason = ""},
                     config, context);
  Json& truth = insertion.truth;
  truth["force_curves"] = WriteForceCurves(out.path() / "force_curves", config, context);
  const Scan scan = RenderScan(anatomy, config.grid, config.scanner, context);
  volume::WriteCt(out.path() / "ct.nrrd", scan.ct);
  volume::WriteLabelMap(out.path() / "labels.seg.nrrd", scan.labels);
  truth["scale"] = anatomy.scale();
  truth["hu"] = config.document.at("scanner").at("hu");
  truth["volumes_ml"] = VolumesMl(scan.labels);
  for (const auto& [name, point] : anatomy.landmarks())
    truth["landmarks_ct_mm"][name] = config::Row(point);
  config::WriteJson(out.path() / "truth.json", truth);
  config::WriteJson(out.path() / "provenance.json", context.provenance.ToJson());
  out.Commit();
  return insertion.text;
}

std::string WriteScene(const std::filesystem::path& folder, const volume::LabelMap& labels,
                       const PhantomConfig& config, const RunContext& context,
                       const SceneRequest& request) {
  AtomicFolder out(folder, context.overwrite);
  const LabelMapField inside(labels), up_to_border(labels, LabelMapField::Beyond::kAir);
  const LabelMapField* field = &inside;
  std::optional<ScenePlan> plan;
  std::string no_skin;
  try {
    plan = PlanScene(labels, inside, config.insertion, request, context);
    if (plan->is_soft_tissue) no_skin = "no structure is reached from the skin that the CT shows";
  } catch (const NoAnswerError& error) {
    // A window is on skin that is there, or nowhere.
    if (!IsCut(labels) || !request.window.empty()) throw;
    no_skin = error.what();
  }
  if (!no_skin.empty() && IsCut(labels)) {
    ScenePlan other = PlanScene(labels, up_to_border, config.insertion, request, context);
    if (!plan || !other.is_soft_tissue) {
      context.Warn(Message(no_skin, ". Where the volume's border cuts the body, it now takes ",
                           "the place of the skin"));
      plan = std::move(other);
      plan->choice.reason += kNoSkin;
      field = &up_to_border;
    }
  }
  WarnOfView(plan->choice, context);
  if (plan->touches_bone) WarnWithoutBone(plan->insertion, context);
  const Insertion insertion =
      WriteInsertion(out.path(), *field, plan->insertion, plan->choice, config, context);
  config::WriteJson(out.path() / "truth.json", insertion.truth);
  config::WriteJson(out.path() / "provenance.json", context.provenance.ToJson());
  out.Commit();
  return insertion.text;
}

}  // namespace acus::phantom
