// The bar below the views: messages, distance, forces, time; and the page of keys.
#pragma once

#include "acus/window/frame.h"
#include "acus/window/layout.h"
#include "acus/window/marks.h"
#include "acus/window/sketch.h"
#include "acus/window/steering.h"

namespace acus::window {

/// What the bar says, the worst first; among equals what concerns the patient before the computer.
/// Among them what to do now: the coach's line, or the next step of the exercise.
/// "All is well." only where nothing else is to be said and no step of the exercise has failed.
std::vector<StatusLine> LinesToShow(const DisplayFrame& frame, const ViewChoice& choice);

/// Delays, rates and forces in numbers only with ViewChoice::figures.
void DrawStatusBar(const DisplayFrame& frame, const ViewChoice& choice,
                   const std::optional<VolumeReadout>& volume, const Rectangle& place,
                   const TextSizes& sizes, Sketch& sketch);

/// Drawn over all views.
void DrawHelp(const Rectangle& window, const TextSizes& sizes, Sketch& sketch);

}  // namespace acus::window
