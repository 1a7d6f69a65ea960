// A scenario file: the patient, the tools, and the effects that are simulated.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "acus/data/session/session_import.h"
#include "acus/scene/effects/effect_list.h"
#include "acus/scene/scenario/breathing_effect.h"
#include "acus/scene/scenario/ct_slice_effect.h"
#include "acus/scene/scenario/evidence.h"
#include "acus/scene/scenario/needle_effect.h"
#include "acus/scene/scenario/needle_force_effect.h"
#include "acus/scene/scenario/probe_force_effect.h"
#include "acus/scene/scenario/scenario_document.h"
#include "acus/scene/scenario/tissue_effect.h"
#include "acus/scene/scenario/ultrasound_effect.h"

namespace acus::scenario {

/// Files of the prepared patient. Paths are absolute; those that no effect needs may be empty, or
/// name a file that does not exist.
struct Patient {
  std::filesystem::path ct;
  std::string dicom_series;  ///< Selects one of several series; may be empty.
  std::filesystem::path labels;
  bool trusts_labels = false;      ///< Also where they do not fit the CT.
  std::filesystem::path surfaces;  ///< List of surfaces, in place of CT and labels.
  std::filesystem::path mesh;      ///< mesh.vtu; the compliance is in the same folder.
  std::filesystem::path corridor;  ///< CSV with the points entry and target.
  Eigen::Isometry3d ct_from_reference = Eigen::Isometry3d::Identity();
  std::uint64_t stiffness_seed = 0;  ///< Forces and moduli are a draw; 0: those of the tables.
  int num_others = 0;                ///< Other patients whose forces a replay reports.
};

struct Scenario {
  std::filesystem::path file;
  std::string name;
  Patient patient;
  session::ImportOptions session;  ///< For sessions recorded by other programs.
  std::filesystem::path needle;    ///< Needle preset.
  std::filesystem::path probe;     ///< Probe preset.
  double image_rate_hz = 0.0;

  // The effects that the scenario names.
  std::optional<NeedleForceEffect> needle_force;
  std::optional<NeedleEffect> shape;  ///< effects/needle.
  std::optional<ProbeForceEffect> probe_force;
  std::optional<TissueEffect> tissue;
  std::optional<BreathingEffect> breathing;
  std::optional<UltrasoundEffect> ultrasound;
  std::optional<CtSliceEffect> ct_slice;
  std::vector<effects::CalledEffect> listed;  ///< Effects of the list, in its order.

  std::optional<Evidence> evidence;  ///< Evidence for values that acus-tradeoff chose.

  nlohmann::json effective;  ///< The file with overrides and defaults, for provenance.
};

/// The schema of scenario files, with the parts of all effects.
nlohmann::json ScenarioSchema();

/// Reads a scenario, applies overrides, checks it against its schema and resolves paths.
///
/// Paths of the patient are relative to the scenario file (those of overrides to the working
/// folder); presets are also looked up in the installed configs. Reads the transform, but no
/// volume: only effects that read a volume require that it exists (simulation::RequireFiles).
/// @throws InputError listing all problems.
Scenario ReadScenario(const std::filesystem::path& path, std::span<const Override> overrides);

}  // namespace acus::scenario
