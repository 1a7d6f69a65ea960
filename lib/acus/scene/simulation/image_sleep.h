// Decides when an image is still valid: the stage then sleeps, and its last output holds.
#pragma once

#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::simulation {

/// True if the tissue has not moved: the forces of tools on it and the breath have the same bits,
/// as far as images show them.
bool TissueHasStayed(const Scene& scene, const Snapshot& before, const Snapshot& now) noexcept;

/// The same for breath alone.
bool BreathHasStayed(const Scene& scene, const Snapshot& before, const Snapshot& now) noexcept;

/// The same for the needle's pose in the hand and its shape.
bool NeedleHasStayed(const Snapshot& before, const Snapshot& now) noexcept;
bool ProbeHasStayed(const Snapshot& before, const Snapshot& now) noexcept;

/// An upper bound of the distance from the plane of `probe` within which any model of the
/// ultrasound or the CT slice shows a needle, mm.
double NeedleReachMm(const acoustics::Probe& probe, double needle_radius_mm);

/// True if there is no needle, or all of it is on one side of the plane, farther than `reach_mm`.
bool NeedleIsOffPlane(const Scene& scene, const Snapshot& snapshot, double reach_mm) noexcept;

}  // namespace acus::simulation
