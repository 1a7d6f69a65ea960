// What the view in three dimensions shows of a scene.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/scene/scenario/view_effect.h"
#include "acus/scene/simulation/image_renderer.h"
#include "acus/scene/simulation/scene.h"

namespace acus::simulation {

/// Surfaces of the tissues that `effect` names and `labels` hold; those of other tissues are left
/// out.
/// @throws InputError for a tissue that there is none of in any patient, or if all are left out.
std::vector<volume_rendering::SurfaceInView> SurfacesOf(const scenario::View3dEffect& effect,
                                                        const volume::LabelMap& labels,
                                                        const RunContext& context);

/// Renders the view of a plan that has it. Not for two threads at a time.
class ViewRenderer {
 public:
  /// @param scene  Must outlive the renderer.
  /// @throws InputError if the view's settings do not fit the patient.
  ViewRenderer(const Scene& scene, const RunContext& context);

  /// The same bits with any number of threads.
  /// @param b_mode  Of the same moment; null or empty: none.
  /// @param times  If given, what the stage did is added to it.
  /// @param shown  The moment that `out` shows already, with the same `b_mode`: if the picture
  /// would
  ///     be the same, it is left as it is. Null: there is none.
  void Render(const Snapshot& snapshot, const image::GrayImage* b_mode,
              volume_rendering::ViewPicture& out, int num_threads, StageTimes* times = nullptr,
              const Snapshot* shown = nullptr);

 private:
  bool HasStayed(const Snapshot& before, const Snapshot& now) const noexcept;

  const Scene& scene_;
  volume_rendering::PatientView view_;
  volume_rendering::Camera camera_;
};

}  // namespace acus::simulation
