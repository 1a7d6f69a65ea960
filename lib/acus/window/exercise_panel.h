// The exercise beside the views: target, the steps to tick off, and goals with their current
// values.
#pragma once

#include "acus/window/frame.h"
#include "acus/window/layout.h"
#include "acus/window/marks.h"
#include "acus/window/sketch.h"

namespace acus::window {

/// The exercise as displayed at one time.
/// @param trial  Number of the trainee's trial, from 1: hints become rarer with it.
ExerciseOnDisplay ExerciseToShow(const training::Exercise& exercise,
                                 const replay::ExerciseProgress& progress,
                                 const std::optional<double>& tip_to_target_mm, int trial);

/// Rows without room are not drawn.
void DrawExercise(const ExerciseOnDisplay& exercise, const Rectangle& place, const TextSizes& sizes,
                  Sketch& sketch);

/// Words of a text in lines of at most `room_px`.
std::vector<std::string> Wrapped(const std::string& text, int size_px, int room_px,
                                 const Sketch& sketch);

}  // namespace acus::window
