// Marks of states: each has a shape of its own, so that it is recognised without colours.
#pragma once

#include "acus/run/training/checklist.h"
#include "acus/window/frame.h"
#include "acus/window/sketch.h"

namespace acus::window {

Colour ColourOf(Severity severity) noexcept;

/// Good: a tick. Note: a dot. Warning: a triangle. Fault: a cross.
/// @param radius_px  Half the height of the mark.
void DrawMark(Severity severity, const Eigen::Vector2d& centre, double radius_px, Sketch& sketch);

/// Done: a tick. Failed: a cross. Open: a ring, filled for the next step.
void DrawMark(training::StepState state, bool is_next, const Eigen::Vector2d& centre,
              double radius_px, Sketch& sketch);

}  // namespace acus::window
