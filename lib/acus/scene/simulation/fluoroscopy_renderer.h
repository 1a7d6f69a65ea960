// The fluoroscopy of a scene at one moment.
#pragma once

#include <optional>

#include "acus/imaging/fluoroscopy/fluoroscope.h"
#include "acus/scene/simulation/image_renderer.h"
#include "acus/scene/simulation/moment_rest.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::simulation {

/// Holds a copy of the CT as the C-arm reads it: one for all threads, which share each picture.
class FluoroscopyRenderer {
 public:
  /// @param scene  Must outlive the renderer. @pre the plan has the fluoroscopy.
  /// @throws InputError if the C-arm does not see the patient.
  FluoroscopyRenderer(const Scene& scene, int num_threads);

  /// The same bits for the same snapshot, whatever was rendered before and with any number of
  /// threads. The needle is straight in the hand if its tracker sees it and nothing bends it.
  /// @param times  As of ImageRenderer::Render.
  /// @param shown  The moment of the last picture, which `out` shows already. Where the patient has
  ///     stayed since, only the needle's shadow is made anew, and where the needle has, too,
  ///     nothing. Null: all is made.
  void Render(const Snapshot& snapshot, image::GrayImage& out, int num_threads,
              StageTimes* times = nullptr, const Snapshot* shown = nullptr);

  const fluoroscopy::Fluoroscope& fluoroscope() const { return fluoroscope_; }

 private:
  const Scene& scene_;
  MomentRest rest_;
  fluoroscopy::Fluoroscope fluoroscope_;
};

}  // namespace acus::simulation
