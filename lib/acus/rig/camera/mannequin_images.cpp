#include "acus/rig/camera/mannequin_images.h"

#include <cmath>
#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"
#include "acus/data/transforms/transform_graph.h"
#include "acus/rig/camera/mannequin_camera.h"
#include "acus/rig/camera/stereo_pair.h"

namespace acus::simulators {
namespace {

constexpr const char* kReference = "Reference";
constexpr std::uint64_t kNoiseOfEach = 1ULL << 40;  ///< Images of one camera, before the next's.

/// Half the samples of a still image: 30 images a second of 720 lines take 75 % of one core.
camera::ImageMaking Making() {
  camera::ImageMaking making;
  making.samples = 2;
  return making;
}

class Images final : public ImageSource {
 public:
  Images(const MannequinView& view, camera::FacetSet facets)
      : view_(view), facets_(std::move(facets)) {
    if (view.stereo.empty()) {
      Add("Video", camera::ReadCamera(view.camera), Eigen::Isometry3d::Identity());
      return;
    }
    const camera::StereoPair pair = camera::ReadStereo(view.stereo);
    Add("Video", pair.left, Eigen::Isometry3d::Identity());
    Add("VideoRight", pair.right, pair.right_from_left);
  }

  std::vector<std::string> streams() const override { return streams_; }
  double rate_hz() const override { return view_.rate_hz; }

  std::vector<tracking::Image> Draw(std::span<const tracking::NamedPose> poses,
                                    std::int64_t time_ns) override {
    std::vector<tracking::Image> drawn;
    for (Eye& eye : eyes_) {
      drawn.push_back(
          DrawFrom(eye, eye.here_from_first * CameraFromReference(view_, time_ns), poses));
    }
    return drawn;
  }

 private:
  struct Eye {
    Eigen::Isometry3d here_from_first;
    camera::MannequinCamera camera;
    std::uint64_t number;  ///< Of its next image; each camera has noise of its own.
  };

  void Add(const std::string& stream, const camera::CameraModel& camera,
           const Eigen::Isometry3d& here_from_first) {
    eyes_.push_back(
        {.here_from_first = here_from_first,
         .camera = camera::MannequinCamera(
             camera, facets_, {{.object = kReference, .surface = camera::PlainTorso()}}, Making()),
         .number = kNoiseOfEach * streams_.size()});
    streams_.push_back(stream);
  }

  tracking::Image DrawFrom(Eye& eye, const Eigen::Isometry3d& camera_from_reference,
                           std::span<const tracking::NamedPose> poses) {
    std::vector<camera::ObjectInView> objects = {
        {.name = kReference, .camera_from_object = camera_from_reference}};
    for (const tracking::NamedPose& pose : poses) {
      const auto name = transforms::ParseTransformName(pose.name);
      if (!name || !pose.valid || facets_.Find(name->from) == nullptr) continue;
      objects.push_back(
          {.name = name->from,
           .camera_from_object = camera_from_reference * pose.reference_from_tool.isometry()});
    }
    eye.camera.Render(objects, eye.number++, drawn_);
    return {.width = drawn_.width_px,
            .height = drawn_.height_px,
            .channels = drawn_.channels,
            .pixels = drawn_.pixels};
  }

  MannequinView view_;
  camera::FacetSet facets_;
  std::vector<Eye> eyes_;
  std::vector<std::string> streams_;
  camera::Image drawn_;
};

}  // namespace

Eigen::Isometry3d CameraFromReference(const MannequinView& view, std::int64_t time_ns) {
  const double turn = 2.0 * std::numbers::pi * 1e-9 * static_cast<double>(time_ns);
  const Eigen::Vector3d sway_mm(view.sway_mm * std::sin(turn / 10.0),
                                view.sway_mm * std::sin(turn / 13.0), 0.0);
  const Eigen::Vector3d forward = (view.looks_at_mm - view.eye_mm).normalized();
  // To the right: level, unless it looks straight down.
  Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ());
  if (right.norm() < 1e-6) right = Eigen::Vector3d::UnitX();
  return math::PoseFromAxes(view.eye_mm + sway_mm, forward, right).inverse();
}

std::unique_ptr<ImageSource> MannequinImages(const MannequinView& view) {
  const double distance_mm = (view.looks_at_mm - view.eye_mm).norm();
  ACUS_REQUIRE(distance_mm >= 100.0 && distance_mm <= 10'000.0, "the camera is ", distance_mm,
               " mm from what it looks at; allowed are 100 to 10000");
  camera::FacetSet facets = camera::ReadFacets(view.facets);
  ACUS_REQUIRE(facets.Find(kReference) != nullptr, view.facets.string(),
               ": there is no object 'Reference', which is the mannequin");
  return std::make_unique<Images>(view, std::move(facets));
}

std::unique_ptr<ImageSource> MannequinImages(
    const std::vector<std::filesystem::path>& camera_and_facets,
    const std::filesystem::path& stereo) {
  ACUS_REQUIRE(stereo.empty() || !camera_and_facets.empty(), "--stereo ", stereo.string(),
               ": draws nothing without facets; give --camera CAMERA FACETS too");
  if (camera_and_facets.empty()) return nullptr;
  MannequinView view;
  view.camera = config::FindConfig(camera_and_facets.at(0), ".");
  view.facets = config::FindConfig(camera_and_facets.at(1), ".");
  if (!stereo.empty()) view.stereo = config::FindConfig(stereo, ".");
  return MannequinImages(view);
}

}  // namespace acus::simulators
