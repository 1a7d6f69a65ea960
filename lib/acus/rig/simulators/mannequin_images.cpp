#include "acus/rig/simulators/mannequin_images.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"
#include "acus/data/transforms/transform_graph.h"
#include "acus/rig/camera/mannequin_camera.h"

namespace acus::simulators {
namespace {

constexpr const char* kReference = "Reference";

/// Half the samples of a still image: 30 images a second of 720 lines take 75 % of one core.
camera::ImageMaking Making() {
  camera::ImageMaking making;
  making.samples = 2;
  return making;
}

class Images final : public ImageSource {
 public:
  Images(const MannequinView& view, camera::FacetSet facets)
      : view_(view),
        facets_(facets),
        camera_(camera::ReadCamera(view.camera), std::move(facets),
                {{.object = kReference, .surface = camera::PlainTorso()}}, Making()) {}

  std::string stream() const override { return "Video"; }
  double rate_hz() const override { return view_.rate_hz; }

  tracking::Image Draw(std::span<const tracking::NamedPose> poses, std::int64_t time_ns) override {
    const Eigen::Isometry3d camera_from_reference = CameraFromReference(view_, time_ns);
    std::vector<camera::ObjectInView> objects = {
        {.name = kReference, .camera_from_object = camera_from_reference}};
    for (const tracking::NamedPose& pose : poses) {
      const auto name = transforms::ParseTransformName(pose.name);
      if (!name || !pose.valid || facets_.Find(name->from) == nullptr) continue;
      objects.push_back(
          {.name = name->from,
           .camera_from_object = camera_from_reference * pose.reference_from_tool.isometry()});
    }
    camera_.Render(objects, number_++, drawn_);
    return {.width = drawn_.width_px,
            .height = drawn_.height_px,
            .channels = drawn_.channels,
            .pixels = drawn_.pixels};
  }

 private:
  MannequinView view_;
  camera::FacetSet facets_;
  camera::MannequinCamera camera_;
  camera::Image drawn_;
  std::uint64_t number_ = 0;
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

std::unique_ptr<ImageSource> MannequinImages(const std::filesystem::path& camera,
                                             const std::filesystem::path& facets) {
  MannequinView view;
  view.camera = camera;
  view.facets = facets;
  return MannequinImages(view);
}

}  // namespace acus::simulators
