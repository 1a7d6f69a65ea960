// What a pair of cameras sees of facets whose pose is known.
#pragma once

#include <string>
#include <vector>

#include "acus/rig/camera/pair_pose.h"
#include "support/facet_views.h"

namespace acus::testing_support {

/// Renders an object for both cameras and finds its markers.
class PairViews {
 public:
  PairViews(camera::StereoPair pair, camera::FacetSet set,
            const camera::ImageMaking& making = {.colour = false})
      : pair_(std::move(pair)),
        set_(std::move(set)),
        left_(pair_.left, set_, {}, making),
        right_(pair_.right, set_, {}, making),
        detector_(set_.dictionary) {}

  const camera::StereoPair& pair() const { return pair_; }
  const camera::FacetSet& set() const { return set_; }

  camera::Image Left(const std::string& name, const Eigen::Isometry3d& pose, std::uint64_t number) {
    return Take(left_, name, pose, number);
  }
  /// @param pose  In the left camera's frame.
  camera::Image Right(const std::string& name, const Eigen::Isometry3d& pose,
                      std::uint64_t number) {
    return Take(right_, name, pair_.right_from_left * pose, number + 1'000'000);
  }
  std::vector<camera::DetectedMarker> MarkersInLeft(const camera::Image& image) {
    return detector_.Detect(image, &pair_.left);
  }
  std::vector<camera::DetectedMarker> MarkersInRight(const camera::Image& image) {
    return detector_.Detect(image, &pair_.right);
  }

 private:
  static camera::Image Take(camera::MannequinCamera& maker, const std::string& name,
                            const Eigen::Isometry3d& pose, std::uint64_t number) {
    const camera::ObjectInView shown[] = {{name, pose}};
    camera::Image image;
    maker.Render(shown, number, image);
    return image;
  }

  camera::StereoPair pair_;
  camera::FacetSet set_;
  camera::MannequinCamera left_, right_;
  camera::MarkerDetector detector_;
};

}  // namespace acus::testing_support
