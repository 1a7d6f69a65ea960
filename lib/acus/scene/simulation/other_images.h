// Images that effects of the list add to a scene.
#pragma once

#include <memory>
#include <vector>

#include "acus/scene/simulation/image_renderer.h"
#include "acus/scene/simulation/moment_rest.h"

namespace acus::simulation {

/// An image, and the effect whose it is.
struct OtherImage {
  std::string_view key;
  std::string_view title;
  image::GrayImage image;
};

/// Renders them. One for each thread.
class OtherImageRenderer {
 public:
  /// @param scene  Must outlive this.
  explicit OtherImageRenderer(const Scene& scene);

  /// True if a stage reads the image of the probe, which Render is then to be given.
  bool ReadsImages() const { return reads_images_; }

  /// One for each effect that has a stage at every image, in their order.
  /// @param images  Of the same moment. @param times  If given, what each stage did is added to it.
  void Render(const Snapshot& snapshot, const Images& images, std::vector<OtherImage>& out,
              StageTimes* times = nullptr);

 private:
  struct Stage {
    const OtherEffect* effect;
    std::unique_ptr<effects::ImageStage> stage;
  };
  const Scene& scene_;
  std::vector<Stage> stages_;
  MomentRest rest_;
  bool reads_images_ = false;
};

}  // namespace acus::simulation
