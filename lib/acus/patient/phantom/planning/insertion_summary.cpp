#include "acus/patient/phantom/planning/insertion_summary.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/core/text_table.h"
#include "acus/base/math/angles.h"
#include "acus/data/volume/label_map_content.h"

namespace acus::phantom {
namespace {

std::string PointText(const Eigen::Vector3d& p) {
  return Message("(", FixedText(p.x(), 1), ", ", FixedText(p.y(), 1), ", ", FixedText(p.z(), 1),
                 ") mm");
}

std::string PartsText(const std::vector<PathPart>& parts) {
  std::string text;
  for (const PathPart& part : parts) {
    text += Message(text.empty() ? "" : ", ", part.tissue, " ",
                    FixedText(part.to_mm - part.from_mm, 1), " mm");
  }
  return text;
}

std::string FirstAttemptText(const InsertionPlan& plan) {
  if (!plan.bone_angle_rad) return "none: the needle touches no bone";
  return Message("touches bone at ", FixedText(plan.bone_depth_mm, 1), " mm, ",
                 FixedText(std::abs(*plan.bone_angle_rad) / math::kRadPerDegree, 0),
                 " degrees off the path");
}

}  // namespace

std::string TissueNameAt(const PatientField& field, const Eigen::Vector3d& point_ct_mm) {
  return volume::NameOfLabel(field.LabelAt(point_ct_mm));
}

std::vector<PathPart> TissuesAlong(const PatientField& field, const InsertionPlan& plan) {
  constexpr double kStepMm = 0.1;
  const auto steps = static_cast<int>(std::ceil(plan.length_mm() / kStepMm));
  std::vector<PathPart> parts;
  for (int n = 0; n < steps; ++n) {
    const double to_mm = std::min((n + 1) * kStepMm, plan.length_mm());
    const Eigen::Vector3d at = plan.entry_ct_mm + (n + 0.5) * kStepMm * plan.direction;
    if (field.LabelAt(at) == 0) continue;  // The skin is smooth, its voxels have steps.
    const std::string name = TissueNameAt(field, at);
    if (parts.empty() || parts.back().tissue != name) parts.push_back({name, n * kStepMm, to_mm});
    parts.back().to_mm = to_mm;
  }
  return parts;
}

nlohmann::json ChoiceJson(const SceneChoice& choice, const std::vector<PathPart>& parts) {
  nlohmann::json through = nlohmann::json::array();
  for (const PathPart& part : parts) {
    through.push_back({{"tissue", part.tissue}, {"from_mm", part.from_mm}, {"to_mm", part.to_mm}});
  }
  nlohmann::json image = nullptr;
  if (choice.view) {
    image = {{"target_share", choice.view->target},
             {"needle_share", choice.view->needle},
             {"face_share", choice.view->face},
             {"text", ViewText(*choice.view)}};
  }
  return {{"title", choice.title},   {"target", choice.target}, {"window", choice.window},
          {"reason", choice.reason}, {"image", image},          {"passes_through", through}};
}

std::string InsertionText(const InsertionPlan& plan, const SceneChoice& choice,
                          const std::vector<PathPart>& parts, const ScriptedSession& session) {
  const double lean_deg =
      std::acos(std::clamp(-plan.direction.dot(plan.skin_normal), -1.0, 1.0)) / math::kRadPerDegree;
  std::string text = choice.title.empty() ? "" : choice.title + "\n";
  text += Message("Target: ", choice.target, ", at ", PointText(plan.target_ct_mm), "\n");
  if (!choice.reason.empty()) text += "Chosen: " + choice.reason + "\n";
  if (!choice.window.empty()) text += "Window: " + choice.window + "\n";
  text +=
      Message("Path: ", FixedText(plan.length_mm(), 1), " mm from ", PointText(plan.entry_ct_mm),
              ", ", FixedText(lean_deg, 0), " degrees off the skin's normal\n");
  if (choice.view) text += "In the image: " + ViewText(*choice.view) + "\n";
  text += "Passes through: " + PartsText(parts) + "\n";
  text += "First attempt: " + FirstAttemptText(plan) + "\n";
  text += Message("Session: ", session.session.name, ", ",
                  FixedText(1e-9 * static_cast<double>(session.session.needle.back().time_ns), 1),
                  " s\n");
  return text;
}

}  // namespace acus::phantom
