// The breathing of a scene: the patient's motion, driven by a recording or a pattern.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/physics/breathing/breath_source.h"
#include "acus/physics/breathing/motion_file.h"
#include "acus/physics/breathing/motion_map.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::simulation {

/// Const after loading; shared by all stages and threads.
struct Breathing {
  breathing::PatientMotion motion;
  breathing::BreathSource source;
  double amplitude = 1.0;
  bool normalise = true;         ///< A recording's own breath levels stand for normal breath.
  bool image = true;             ///< The images show the motion.
  double warp_spacing_mm = 5.0;  ///< Distance of the knots at which images sample the map.
  int inverse_iterations = 5;    ///< To find the rest position.
  bool adds_motion = false;      ///< Tools at rest by x + u, as printed.
  bool from_session = false;     ///< The breath comes from the session; `source` is idle.

  /// The breath of `source` relative to a normal one, as sessions hold it.
  breathing::Breath NormalAt(double session_s) const noexcept;

  /// The patient's motion at a time, in seconds since the session began. Allocates nothing.
  /// @param of_session  The breath relative to a normal one; only read if `from_session`.
  breathing::MotionMap At(double session_s, const breathing::Breath& of_session) const noexcept;
};

/// @param from_session  The breath comes from the session: no signal is read.
/// @pre scenario.breathing is there.
/// @throws InputError if the motion or the signal is not readable, or a setting is out of range.
Breathing LoadBreathing(const scenario::Scenario& scenario, bool from_session, RunContext& context);

/// Maps a point of an image to its rest position: through the breath to the reference image, then
/// through the deformation by tools, if any. One for each thread.
class BreathingRest : public slicing::RestMap {
 public:
  /// @param deformed  Null if no tool deforms the tissue. Both must outlive this.
  BreathingRest(const Breathing& breathing, double session_s, const breathing::Breath& of_session,
                const slicing::RestMap* deformed)
      : map_(breathing.At(session_s, of_session)),
        spacing_mm_(breathing.warp_spacing_mm),
        iterations_(breathing.inverse_iterations),
        deformed_(deformed) {}

  bool moves() const { return map_.moves(); }
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept override;
  double SpacingMm() const noexcept override;

 private:
  breathing::MotionMap map_;
  double spacing_mm_;
  int iterations_;
  const slicing::RestMap* deformed_;
};

}  // namespace acus::simulation
