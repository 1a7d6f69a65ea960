#include "acus/window/volume_view.h"

#include <algorithm>
#include <cmath>

#include "acus/base/translation/translation.h"
#include "acus/window/overlay.h"

namespace acus::window {
namespace {

using translation::Marked;
using translation::Translated;

const char* NameOfCut(VolumeCut cut) {
  switch (cut) {
    case VolumeCut::kNone:
      return "";
    case VolumeCut::kAxial:
      return Marked("axial cut");
    case VolumeCut::kCoronal:
      return Marked("coronal cut");
    case VolumeCut::kSagittal:
      return Marked("sagittal cut");
    case VolumeCut::kFacing:
      return Marked("cut across the line of sight");
  }
  return "";
}

}  // namespace

std::vector<volume_rendering::CutPlane> CutsOf(VolumeCut cut, double cut_mm,
                                               const Eigen::AlignedBox3d& box_in_ct_mm,
                                               const Eigen::Vector3d& towards_eye) {
  Eigen::Vector3d normal = towards_eye;
  // The patient's axes are those of CT space: left, posterior, superior.
  if (cut == VolumeCut::kSagittal) normal = Eigen::Vector3d::UnitX();
  if (cut == VolumeCut::kCoronal) normal = Eigen::Vector3d::UnitY();
  if (cut == VolumeCut::kAxial) normal = Eigen::Vector3d::UnitZ();
  if (cut == VolumeCut::kNone) return {};
  const double side = normal.dot(towards_eye) < 0.0 ? -1.0 : 1.0;
  // The same plane from both sides.
  const Eigen::Vector3d place =
      box_in_ct_mm.center() + (cut == VolumeCut::kFacing ? -cut_mm : cut_mm) * normal;
  return {volume_rendering::CutPlane(side * normal, place)};
}

VolumeView::VolumeView(const std::vector<VolumeLook>& looks, const VolumeViewSettings& settings)
    : looks_(looks), settings_(settings) {}

VolumeMoment VolumeView::MomentOf(const DisplayFrame& frame, const Orbit& orbit,
                                  const VolumeChoice& choice) const {
  VolumeMoment moment;
  moment.look = static_cast<std::size_t>(choice.look) % looks_.size();
  moment.opacity = choice.opacity;
  moment.cuts = CutsOf(choice.cut, choice.cut_mm, orbit.box_in_ct_mm(), orbit.TowardsEye());
  if (frame.motion != nullptr && frame.motion->moves()) moment.motion.emplace(*frame.motion);
  moment.needle = frame.needle;
  moment.pressed = frame.pressed;
  if (frame.ct_from_probe && frame.ultrasound.probe) {
    moment.ct_from_probe = frame.ct_from_probe;
    moment.probe = frame.ultrasound.probe;
    moment.b_mode = frame.ultrasound.image;
  }
  return moment;
}

void VolumeView::Update(const DisplayFrame& frame, const Rectangle& place, const Orbit& orbit,
                        const VolumeChoice& choice) {
  shown_ = !empty() && place.width >= 2 && place.height >= 2;
  if (!shown_) return;
  if (!renderer_) {
    renderer_ = std::make_unique<VolumeRenderer>(looks_, settings_.in_background, settings_.rays);
  }
  renderer_->Take(image_);
  VolumeMoment moment = MomentOf(frame, orbit, choice);
  const volume_rendering::Camera whole = orbit.CameraFor(place.width, place.height);
  moment.camera = whole;
  const bool same_size = asked_ && asked_->camera.width_px == whole.width_px &&
                         asked_->camera.height_px == whole.height_px;
  const bool same = same_size && asked_->SameView(moment) && asked_->SameContent(moment);
  same_moments_ = same ? same_moments_ + 1 : 0;
  if (same && (asked_whole_ || same_moments_ < settings_.still_moments || !renderer_->idle())) {
    return;
  }
  asked_whole_ = same;
  asked_ = moment;
  if (!asked_whole_) {
    const auto fewer = [&](int pixels) {
      return std::max(2, static_cast<int>(std::lround(settings_.moving_scale * pixels)));
    };
    moment.camera = Resampled(whole, fewer(whole.width_px), fewer(whole.height_px));
  }
  renderer_->Ask(std::move(moment), /*may_stop=*/asked_whole_);
  renderer_->Take(image_);
}

std::string VolumeView::TitleDetail(const VolumeChoice& choice) const {
  if (looks_.empty()) return "";
  const std::string trouble = renderer_ ? renderer_->trouble() : "";
  if (!trouble.empty()) return trouble;
  std::string text = Translated(looks_[static_cast<std::size_t>(choice.look) % looks_.size()].name);
  if (choice.opacity < 1.0) {
    text += ' ' + std::to_string(static_cast<int>(std::lround(100.0 * choice.opacity))) + " %";
  }
  if (choice.cut != VolumeCut::kNone) text += ", " + Translated(NameOfCut(choice.cut));
  const std::string card = renderer_ ? renderer_->statistics().card_trouble : "";
  if (!card.empty()) text += "; " + Translated("on the processor: {1}", {card});
  return text;
}

std::optional<VolumeReadout> VolumeView::readout() const {
  if (!shown_ || !renderer_) return std::nullopt;
  const VolumeStatistics counts = renderer_->statistics();
  return VolumeReadout{.per_s = counts.per_s,
                       .dropped = counts.dropped,
                       .whole = asked_whole_,
                       .rays_on = counts.rays_on};
}

void VolumeView::Wait() {
  if (renderer_) renderer_->Wait();
}

}  // namespace acus::window
