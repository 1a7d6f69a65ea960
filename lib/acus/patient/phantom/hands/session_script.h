// Scripted sessions: what a needle and a probe do, as poses at 1 kHz and as a list of true events.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"
#include "acus/patient/phantom/planning/insertion_plan.h"

namespace acus::phantom {

/// One move of the needle along its line, and the rest after it.
struct NeedleMove {
  enum class To { kStart, kSkin, kBone, kTarget, kDepth };
  enum class Aim { kTarget, kBone };
  enum class Breath { kAsBefore, kHold, kRelease };
  To to = To::kStart;
  double depth_mm = 0.0;         ///< For kDepth.
  Aim aim = Aim::kTarget;        ///< On a change the needle turns about the entry point first.
  double speed_mm_per_s = 10.0;  ///< Highest.
  double hold_s = 0.0;
  Breath breath = Breath::kAsBefore;  ///< Of the patient, from the beginning of the move.
  /// Force of the thumb on the plunger of a syringe, N, from the beginning of the move; nothing: as
  /// before.
  std::optional<double> plunger_n = std::nullopt;
};

struct ProbeScript {
  double lift_mm = 25.0;
  double land_s = 1.5;
  double sweep_mm = 18.0;
  double sweep_s = 5.0;
  double ahead_mm = 32.0;  ///< Middle of the face, along the skin, seen from the entry.
  double toe_rad = 0.14;   ///< Beam tilted towards the needle.
  double gap_mm = 0.3;     ///< Gel.
  double out_of_plane_mm = 0.4;
};

struct TremorSettings {
  double needle_mm = 0.12;  ///< Root mean square, sideways, in air.
  double needle_rad = 0.0014;
  double tissue_damping = 0.35;
  double probe_mm = 0.10;
  double probe_rad = 0.0014;
  double low_hz = 8.0;
  double high_hz = 12.0;
  double wander_mm = 0.4;
};

/// What a demonstration shows at the target.
struct FluidDemonstration {
  std::string exercise;    ///< The demonstration's folder is `demonstration_` and this.
  double plunger_n = 0.0;  ///< Force on the plunger, or on the stylet; below 0: pulls.
  double hold_s = 0.0;
};

struct SessionSettings {
  std::string name = "insertion";
  double standoff_mm = 60.0;
  double bone_press_mm = 0.5;
  double turn_rad_per_s = 0.21;
  std::vector<NeedleMove> needle;
  std::vector<FluidDemonstration> demonstrations;
  ProbeScript probe;
  TremorSettings tremor;
};

/// Something that happened to the needle's tip, found on the exact anatomy along the exact path.
struct NeedleEvent {
  double time_s;
  std::string
      kind;  ///< "contact", "puncture", "bone_touch", "target_reached", "redirect", "withdrawn".
  std::string tissue;  ///< That is entered.
  double depth_mm;     ///< Of the tip behind the entry point, along the needle.
};

struct ScriptedSession {
  session::Session session;
  std::vector<NeedleEvent> events;  ///< In order of time.
};

/// Plays the script at 1 kHz. Poses are reference_from_ct * ct_from_tool, the tremor depends on
/// context.seed. Moves to bone are omitted where the plan has no bone near the path.
ScriptedSession PlayScript(const PatientField& field, const InsertionPlan& plan,
                           const SessionSettings& settings,
                           const Eigen::Isometry3d& reference_from_ct, const RunContext& context);

}  // namespace acus::phantom
