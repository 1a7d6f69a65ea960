#include "acus/run/replay/force_rows.h"

#include <algorithm>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/volume/labels.h"

namespace acus::replay {
namespace {

/// What a needle that bends adds: the torque on it about the hand's tip, how far its tip is off the
/// line along which the hub points, and where the tip is in CT space.
constexpr const char* kShapeColumns =
    "torque_x_n_mm,torque_y_n_mm,torque_z_n_mm,deflection_mm,tip_x_mm,tip_y_mm,tip_z_mm,";

bool IsBendable(const simulation::Scene& scene) {
  return scene.shape && scene.shape->bendable();
}

void Add(std::string& text, double value) {
  text += ',';
  text += NumberText(value);
}

void Add(std::string& text, const Eigen::Vector3d& vector) {
  for (int i = 0; i < 3; ++i) Add(text, vector[i]);
}

}  // namespace

std::string TissueName(const simulation::Scene& scene, volume::Label label) {
  if (label == 0) return "outside";
  std::string name;
  if (scene.labels) {
    const auto found = scene.labels->names.find(label);
    if (found != scene.labels->names.end()) name = found->second;
  } else {
    for (const auto& standard : volume::StandardLabels()) {
      if (standard.label == label) name = standard.name;
    }
  }
  if (name.empty()) return Message("label_", int{label});
  std::ranges::replace_if(
      name, [](char c) { return c == ',' || c == '\n' || c == '\r'; }, ' ');
  return name;  // Segments may be called anything; in a CSV they may not.
}

std::string ForceHeader(const simulation::Scene& scene) {
  return Message("time_s,depth_mm,tissue,force_axial_n,puncture_n,cutting_n,friction_n,bone_n,",
                 scene.listed.adds_force() ? "added_n," : "",
                 "lateral_n,force_x_n,force_y_n,force_z_n,", IsBendable(scene) ? kShapeColumns : "",
                 "event");
}

std::string ProbeForceHeader() {
  return "time_s,force_n,force_x_n,force_y_n,force_z_n,torque_x_n_mm,torque_y_n_mm,torque_z_n_mm,"
         "skin_mm,bone_mm,proxies,structure";
}

std::string EffectHeader(const simulation::ListedEffect& other) {
  std::string header = "time_s";
  for (const effects::Column& column : other.columns) header += ',' + column.name;
  return header;
}

void AppendEffectRow(std::string& text, const simulation::StepOutput& step,
                     const simulation::ListedEffect& other) {
  text += session::SecondsText(step.time_ns);
  for (std::size_t n = 0; n < other.columns.size(); ++n) {
    Add(text, step.effect[other.first_column + n]);
  }
  text += '\n';
}

void AppendForceRow(std::string& text, const simulation::StepOutput& step,
                    const simulation::Scene& scene) {
  const forces::NeedleForce& f = step.force;
  text += session::SecondsText(step.time_ns);
  Add(text, f.depth_mm);
  text += ',' + TissueName(scene, step.tissue_at_tip);
  for (const double value : {f.AxialN(), f.puncture_n, f.cutting_n, f.friction_n, f.bone_n}) {
    Add(text, value);
  }
  if (scene.listed.adds_force()) Add(text, f.added_n);
  Add(text, f.lateral_n);
  Add(text, f.force_in_ct_n);
  if (IsBendable(scene)) {
    Add(text, f.torque_in_ct_n_mm);
    Add(text, step.shape.tip_deflection_mm);
    Add(text, step.shape.tip_in_ct_mm);
  }
  text += ',';
  if (f.event != forces::NeedleEvent::kNone) text += forces::NameOf(f.event);
  text += '\n';
}

void AppendProbeForceRow(std::string& text, const simulation::StepOutput& step,
                         const simulation::Scene& scene) {
  const forces::ProbeForce& f = step.probe;
  text += session::SecondsText(step.time_ns);
  Add(text, f.force_in_ct_n.norm());
  Add(text, f.force_in_ct_n);
  Add(text, f.torque_in_ct_n_mm);
  Add(text, f.skin_mm);
  Add(text, f.bone_mm);
  text += ',' + std::to_string(f.num_on_skin) + ',';
  if (f.structure != 0) text += TissueName(scene, f.structure);
  text += '\n';
}

}  // namespace acus::replay
