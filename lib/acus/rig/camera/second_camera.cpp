#include "acus/rig/camera/second_camera.h"

#include "acus/base/core/error.h"

namespace acus::camera {
namespace {

constexpr int kRecordedWaitMs = 100;

}  // namespace

bool IsRecorded(const std::string& place) {
  return place.starts_with("folder") || place.starts_with("video") || place.starts_with("film");
}

SecondCamera::SecondCamera(const SecondCameraOptions& options, const FrameSourceOptions& source)
    : options_(options) {
  auto opened = OpenFrameSource(options.place, source);
  if (IsRecorded(options.place)) {
    recorded_ = std::move(opened);
  } else {
    live_ = std::make_unique<NewestFrames>(std::move(opened));
  }
}

std::optional<Image> SecondCamera::At(std::int64_t time_ns) {
  std::optional<Image> image;
  if (recorded_) {
    image.emplace();
    if (!recorded_->Next(*image, kRecordedWaitMs)) image.reset();
  } else {
    image = live_->NearestTo(time_ns, std::int64_t{options_.apart_ms} * 1'000'000);
  }
  const FrameSourceStatus status = recorded_ ? recorded_->status() : live_->status();
  problem_.clear();
  if (!image) {
    problem_ = status.connected
                   ? Message("the second camera has no image within ", options_.apart_ms,
                             " ms of the first one's: take both at the same moments; until then "
                             "one camera tracks")
                   : "second camera: " + status.text + "; until then one camera tracks";
    return std::nullopt;
  }
  const CameraParameters& p = options_.pair.right.parameters();
  if (image->width_px == p.width_px && image->height_px == p.height_px) return image;
  problem_ = Message("the second camera's image has ", image->width_px, " x ", image->height_px,
                     " pixels, the stereo file says ", p.width_px, " x ", p.height_px,
                     ": set the camera to that size, or calibrate the pair at this one");
  return std::nullopt;
}

std::string SecondCamera::Problem() const {
  return problem_;
}

}  // namespace acus::camera
