#include "simulation/image_renderer.h"

#include <algorithm>

namespace acus::simulation {
namespace {

void Blacken(const ultrasound::ImageGeometry& picture, ultrasound::GrayImage& image) {
  image.Resize(picture.width_px, picture.height_px);
  std::ranges::fill(image.pixels, std::uint8_t{0});
}

}  // namespace

ImageRenderer::ImageRenderer(const Scene& scene, const ultrasound::Probe* probe) : scene_(scene) {
  if (probe == nullptr && scene.probe) probe = &*scene.probe;
  if (scene.tools_deform_images) {
    deformed_.emplace(*scene.tissue, scene.warp_spacing_mm);
  }
  if (scene.plan.Has(StageId::kCtSlice)) {
    ct_slice_.emplace(*scene.ct, ultrasound::PictureOf(*probe), probe->slice_thickness_mm,
                      scene.ct_window);
  }
  if (scene.plan.Has(StageId::kUltrasound)) {
    b_mode_.emplace(ImagePatient{scene.ct.get(), scene.labels.get()}, *probe, *scene.b_mode);
  }
}

std::optional<ultrasound::NeedleInImage> NeedleInPicture(const Scene& scene,
                                                         const Snapshot& snapshot) {
  if (!snapshot.ct_from_needle) return std::nullopt;
  ultrasound::NeedleInImage needle{
      snapshot.ct_from_needle->translation(), snapshot.ct_from_needle->linear().col(2),
      scene.needle->length_mm, 0.5 * scene.needle->beam.outer_diameter_mm};
  if (snapshot.needle_shape != nullptr) needle.shape = *snapshot.needle_shape;
  return needle;
}

void ImageRenderer::Render(const Snapshot& snapshot, Images& out, StageTimes* times) {
  Stopwatch watch(times);
  const auto needle = NeedleInPicture(scene_, snapshot);
  const ultrasound::RestMap* rest = nullptr;
  if (deformed_) {
    const bool asleep = snapshot.load == nullptr || !snapshot.probe_valid;
    if (!asleep) {
      deformed_->Update(*snapshot.load);
      rest = &*deformed_;
    }
  }
  std::optional<BreathingRest> breathing;
  if (scene_.breathing && scene_.breathing->image && snapshot.probe_valid) {
    breathing.emplace(*scene_.breathing, snapshot.session_s, snapshot.breath, rest);
    if (breathing->moves()) rest = &*breathing;
  }
  if (scene_.plan.Has(StageId::kDeformation)) watch.EndOf(StageId::kDeformation, rest == nullptr);
  if (ct_slice_) {
    if (snapshot.probe_valid) {
      ct_slice_->Render(snapshot.ct_from_probe, scene_.needle_in_ct_slice ? needle : std::nullopt,
                        out.ct_slice, 1, rest);
    } else {
      Blacken(ct_slice_->picture(), out.ct_slice);
    }
    watch.EndOf(StageId::kCtSlice, !snapshot.probe_valid);
  }
  if (b_mode_) {
    if (snapshot.probe_valid) {
      b_mode_->Render(snapshot.ct_from_probe, scene_.needle_in_b_mode ? needle : std::nullopt,
                      out.b_mode, 1, rest);
    } else {
      Blacken(b_mode_->picture(), out.b_mode);
    }
    watch.EndOf(StageId::kUltrasound, !snapshot.probe_valid);
  }
}

}  // namespace acus::simulation
