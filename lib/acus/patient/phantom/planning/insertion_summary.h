// What an insertion is and what it passes through, for truth.json and for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acus/patient/phantom/hands/session_script.h"
#include "acus/patient/phantom/planning/image_view.h"
#include "acus/patient/phantom/planning/insertion_plan.h"

namespace acus::phantom {

/// A stretch of a path in one tissue; depths from the entry, mm.
struct PathPart {
  std::string tissue;
  double from_mm;
  double to_mm;
};

/// The name of the tissue at a point; "label_N" without a standard name.
std::string TissueNameAt(const PatientField& field, const Eigen::Vector3d& point_ct_mm);

/// The tissues from entry to target, in order, to 0.1 mm.
std::vector<PathPart> TissuesAlong(const PatientField& field, const InsertionPlan& plan);

/// Why a scene has its target: all for people.
struct SceneChoice {
  std::string title;                   ///< As "Lumbar puncture at L3-L4".
  std::string target;                  ///< As "liver, 41.2 mm inside it".
  std::string window;                  ///< As "intercostal (between two ribs)"; may be empty.
  std::string reason;                  ///< Of a target that the program chose; may be empty.
  std::optional<ImageView> view = {};  ///< What the probe sees, where that was found out.
};

/// `{title, target, window, reason, image, passes_through}` for truth.json.
nlohmann::json ChoiceJson(const SceneChoice& choice, const std::vector<PathPart>& parts);

/// Some lines: target, window, path, image, tissues, first attempt and session.
std::string InsertionText(const InsertionPlan& plan, const SceneChoice& choice,
                          const std::vector<PathPart>& parts, const ScriptedSession& session);

}  // namespace acus::phantom
