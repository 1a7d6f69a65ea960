// When an image need not be made anew: the stage sleeps, and what it made last still stands.
#pragma once

#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::simulation {

/// True if tissue lies where it lay: the same forces of tools on it and the same breath, to the
/// bit, as far as images show them.
bool TissueHasStayed(const Scene& scene, const Snapshot& before, const Snapshot& now) noexcept;

/// The same for breath alone.
bool BreathHasStayed(const Scene& scene, const Snapshot& before, const Snapshot& now) noexcept;

/// The same for the needle as the hand holds it and as it is bent.
bool NeedleHasStayed(const Snapshot& before, const Snapshot& now) noexcept;
bool ProbeHasStayed(const Snapshot& before, const Snapshot& now) noexcept;

/// How far from the plane of `probe` a needle may be and still be seen by any model of the
/// ultrasound or in the CT slice, mm. Rather more than less.
double NeedleReachMm(const acoustics::Probe& probe, double needle_radius_mm);

/// True if there is no needle, or all of it is on one side of the plane, farther than `reach_mm`.
bool NeedleIsOffPlane(const Scene& scene, const Snapshot& snapshot, double reach_mm) noexcept;

}  // namespace acus::simulation
