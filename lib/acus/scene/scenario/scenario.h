// A scenario file: whose body, which tools, and only the effects that the scene calls for.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "acus/data/session/session_import.h"
#include "acus/physics/breathing/breath_source.h"
#include "acus/scene/effects/effect_list.h"
#include "acus/scene/scenario/evidence.h"
#include "acus/scene/scenario/scenario_document.h"
#include "acus/scene/scenario/ultrasound_effect.h"

namespace acus::scenario {

/// Where the prepared patient is. Paths are absolute; what no effect needs may be empty, or a file
/// that is not there.
struct Patient {
  std::filesystem::path ct;
  std::string dicom_series;  ///< Picks one of several series; may be empty.
  std::filesystem::path labels;
  std::filesystem::path surfaces;  ///< List of surfaces, in place of CT and labels.
  std::filesystem::path mesh;      ///< mesh.vtu, with the compliance beside it.
  std::filesystem::path corridor;  ///< CSV of the points entry and target.
  Eigen::Isometry3d ct_from_reference = Eigen::Isometry3d::Identity();
};

enum class NeedleForceModelKind { kLayered, kAlamilla, kVidal, kMeasured, kTissue };
/// What holds the needle on its line.
enum class GuidanceKind { kOwn, kNone, kVidal, kVirtualFixture };
struct NeedleForceEffect {
  NeedleForceModelKind model = NeedleForceModelKind::kLayered;
  GuidanceKind guidance = GuidanceKind::kOwn;
  std::filesystem::path table;
  std::filesystem::path measured;    ///< Only kMeasured: acus-measured-force.
  std::string recording = "mean";    ///< Of that file.
  std::uint64_t seed = 0;            ///< Not 0: a draw from how its recordings vary.
  double skin_nick_radius_mm = 0.0;  ///< Around the corridor's entry; 0: no nick.
};

enum class ProbeForceModelKind { kVidal, kMultiProxy, kTissue };
/// Forces on the probe or on a fingertip. Only the settings of its model are read.
struct ProbeForceEffect {
  ProbeForceModelKind model = ProbeForceModelKind::kVidal;
  std::filesystem::path table;
  double press_mm = 0.0;      ///< Deeper along the beam than recorded.
  bool reads_labels = false;  ///< multi_proxy, as all that follow. False: the CT.
  bool is_fingertip = false;  ///< False: the face of the probe preset.
  int num_proxies = 0;
  double face_width_mm = 0.0;  ///< Of a probe, across the image plane.
  double fingertip_radius_mm = 0.0;

  /// True if it depends on what the probe looks like.
  bool NeedsProbePreset() const {
    return model == ProbeForceModelKind::kMultiProxy && !is_fingertip;
  }
};

enum class TissueModelKind { kDisplacementFunctions, kSprings, kPlane2010, kFem3d };

/// Tissue that tools deform. Only the settings of its model are read.
struct TissueEffect {
  TissueModelKind model = TissueModelKind::kDisplacementFunctions;
  std::filesystem::path elasticity;
  std::filesystem::path table;    ///< Force table, for models that touch the needle.
  bool image = true;              ///< The images show the deformation.
  bool pressed_by_probe = false;  ///< ... and the skin under the probe; not fe_3d.
  double warp_spacing_mm = 0.0;
  int inverse_iterations = 0;
  double influence_radius_mm = 0.0;  ///< displacement_functions, springs.
  double path_spacing_mm = 0.0;      ///< springs.
  double plane_spacing_mm = 0.0;     ///< fe_2d, as all of the plane's.
  double plane_width_mm = 0.0;
  int plane_turned = 0;
  double plane_beyond_mm = 0.0;
  double plane_thickness_mm = 0.0;
  std::string element;              ///< fe_3d: as acus-mesh condensed the mesh.
  double contact_spacing_mm = 0.0;  ///< fe_3d.
  bool probe_contact = false;       ///< fe_3d.
  bool finite_strain = false;       ///< fe_3d: tissue near the corridor stiffens.
  int strain_nodes = 0;             ///< fe_3d, finite strain, as the next.
  int strain_iterations = 0;        ///< Per step.

  /// True if the model steps with the samples and knows forces on the needle by itself.
  bool TouchesNeedle() const { return model != TissueModelKind::kDisplacementFunctions; }
};

enum class NeedleModelKind { kRigid, kLateralBeam, kBendable };

/// The needle's shape, and what it does across its path.
struct NeedleEffect {
  NeedleModelKind model = NeedleModelKind::kRigid;
  bool axis_lock = false;            ///< rigid, lateral_beam: once punctured, shown on its path.
  std::filesystem::path elasticity;  ///< bendable, as all that follows.
  double influence_radius_mm = 20.0;
  int nodes = 25;
  double path_spacing_mm = 1.0;
  double tip_stiffness_n_per_mm = 0.5;
  double hand_n_per_mm = 0.5;
  double hand_n_mm_per_rad = 500.0;
  double kappa_n_per_mm = 0.5;
  bool bevel = true;  ///< The needle's bevel steers.
};

/// Whether a session that recorded the patient's breath says how he breathes.
enum class SessionBreath { kIfRecorded, kAlways, kNever };

/// A patient who breathes.
struct BreathingEffect {
  std::filesystem::path motion;  ///< Folder of acus-breathing.
  double amplitude = 1.0;        ///< Of the motion; 0 holds the patient in the reference state.

  std::filesystem::path signal;  ///< A recording; empty: the pattern.
  breathing::SignalFileOptions signal_file;
  breathing::RecordedBreathSettings recorded;
  bool normalise = true;  ///< The recording's own levels stand for normal breath.
  /// period_s 0: that of the motion.
  breathing::PatternSettings pattern;
  std::vector<breathing::BreathHold> holds;  ///< Seconds since the session began.
  /// The signal or pattern is then only for a live session without a belt.
  SessionBreath from_session = SessionBreath::kIfRecorded;

  bool image = true;  ///< The images show the motion.
  double warp_spacing_mm = 0.0;
  int inverse_iterations = 0;  ///< Of the images.
};

struct CtSliceEffect {
  bool needle = true;
  double centre_hu = 0.0;  ///< Middle grey.
  double width_hu = 0.0;   ///< From black to white.
};

struct Scenario {
  std::filesystem::path file;
  std::string name;
  Patient patient;
  session::ImportOptions session;  ///< For sessions that other programs recorded.
  std::filesystem::path needle;    ///< Needle preset.
  std::filesystem::path probe;     ///< Probe preset.
  double image_rate_hz = 0.0;

  // The effects that the scene calls for.
  std::optional<NeedleForceEffect> needle_force;
  std::optional<NeedleEffect> shape;  ///< effects/needle.
  std::optional<ProbeForceEffect> probe_force;
  std::optional<TissueEffect> tissue;
  std::optional<BreathingEffect> breathing;
  std::optional<UltrasoundEffect> ultrasound;
  std::optional<CtSliceEffect> ct_slice;
  std::vector<effects::CalledEffect> listed;  ///< Of the list of effects, in its order.

  std::optional<Evidence> evidence;  ///< Of values that acus-tradeoff chose.

  nlohmann::json effective;  ///< The file with overrides and defaults, for provenance.
};

/// The schema of scenario files, with the parts of all effects.
nlohmann::json ScenarioSchema();

/// Reads a scenario, applies overrides, checks it against its schema and resolves paths.
///
/// Paths of the patient are relative to the scenario file (those of overrides to the working
/// folder); presets are also looked up in the installed configs. Reads the transform, but no
/// volume: whether that is there matters only to effects that read it (simulation::RequireFiles).
/// @throws InputError listing what is wrong.
Scenario ReadScenario(const std::filesystem::path& path, std::span<const Override> overrides);

}  // namespace acus::scenario
