// The exercise beside the views: target, goals with their values now, and the steps to tick off.
#pragma once

#include "acus/window/frame.h"
#include "acus/window/layout.h"
#include "acus/window/marks.h"
#include "acus/window/sketch.h"

namespace acus::window {

/// What an exercise shows at one moment.
/// @param trial  Of the trainee, from 1: hints fade with it.
ExerciseOnDisplay ExerciseToShow(const training::Exercise& exercise,
                                 const replay::ExerciseProgress& progress,
                                 const std::optional<double>& tip_to_target_mm, int trial);

/// Rows that find no room are not drawn.
void DrawExercise(const ExerciseOnDisplay& exercise, const Rectangle& place, const TextSizes& sizes,
                  Sketch& sketch);

/// Words of a text in lines of at most `room_px`.
std::vector<std::string> Wrapped(const std::string& text, int size_px, int room_px,
                                 const Sketch& sketch);

}  // namespace acus::window
