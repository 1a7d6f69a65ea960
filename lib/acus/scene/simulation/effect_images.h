// Images that effects of the list add to a scene.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "acus/scene/simulation/moment_rest.h"
#include "acus/scene/simulation/probe_image_renderer.h"

namespace acus::simulation {

/// An image, and the effect that it belongs to.
struct EffectImage {
  std::string_view key;
  std::string_view title;
  effects::EffectPixels pixels;
};

/// Renders the image of one effect. One for each thread.
class EffectImageRenderer {
 public:
  /// @param scene, effect  Must outlive this. @pre the plan has the effect's stage at every image.
  /// @param context  Has the number of threads that share each image.
  /// @throws InputError if a setting of the effect does not fit the patient.
  EffectImageRenderer(const Scene& scene, const ListedEffect& effect, const RunContext& context);

  const ListedEffect& effect() const { return effect_; }
  const effects::ImageStage& stage() const { return *stage_; }
  /// For the following images, see ImageMoment.
  void SetTipPath(std::vector<Eigen::Vector3d> path_in_ct_mm) {
    tip_path_in_ct_mm_ = std::move(path_in_ct_mm);
  }

  /// @param images  Images of the probe at this instant; null: rendered here if the stage reads
  ///     them.
  /// @param times  If given, the cost of each stage is added to it.
  /// @param shown  The instant that `out` shows already: an image that would be equal is not
  ///     rewritten. Null: none.
  void Render(const Snapshot& snapshot, const ProbeImages* images, effects::EffectPixels& out,
              StageTimes* times = nullptr, const Snapshot* shown = nullptr);

 private:
  bool Reads(effects::PortRef port) const {
    return scene_.plan.stages()[effect_.image_stage].Reads(port);
  }
  bool ImagesHaveChanged(const Snapshot& snapshot, const Snapshot* shown) const;

  const Scene& scene_;
  const ListedEffect& effect_;
  int num_threads_;
  effects::PortValues constant_;
  std::unique_ptr<effects::ImageStage> stage_;
  std::optional<MomentRest> rest_;              ///< If the stage reads it.
  std::optional<ProbeImageRenderer> of_probe_;  ///< The same.
  ProbeImages images_;
  std::vector<Eigen::Vector3d> tip_path_in_ct_mm_;
};

}  // namespace acus::simulation
