#include "acus/scene/simulation/probe_image_renderer.h"

#include <algorithm>

#include "acus/scene/simulation/echo_changes.h"
#include "acus/scene/simulation/image_sleep.h"

namespace acus::simulation {
namespace {

void Blacken(const image::ImageGeometry& geometry, image::GrayImage& image) {
  image.Resize(geometry.width_px, geometry.height_px);
  std::ranges::fill(image.pixels, std::uint8_t{0});
}

/// Renders one image, unless its stage sleeps.
template <typename Renderer>
void Draw(Renderer& renderer, Sleep sleep, const Snapshot& snapshot,
          const std::optional<image::NeedleInImage>& needle, const slicing::RestMap* rest,
          image::GrayImage& out) {
  if (sleep == Sleep::kAwake) renderer.Render(snapshot.ct_from_probe, needle, out, 1, rest);
  if (sleep == Sleep::kProbeUnseen) Blacken(renderer.image(), out);
}

}  // namespace

ultrasound::FramePersistence PersistenceOf(const Scene& scene) {
  const auto* display = scene.b_mode ? DisplayOf(*scene.b_mode) : nullptr;
  return ultrasound::FramePersistence(display != nullptr ? display->persistence_s : 0.0);
}

ProbeImageRenderer::ProbeImageRenderer(const Scene& scene, const acoustics::Probe* probe,
                                       ImageChoice choice, Frames frames)
    : scene_(scene),
      rest_(scene),
      persistence_(frames == Frames::kInOrder ? PersistenceOf(scene)
                                              : ultrasound::FramePersistence(0.0)) {
  if (probe == nullptr && scene.probe) probe = &*scene.probe;
  const bool has_b_mode = scene.plan.Writes(effects::ports::kBMode);
  const bool has_ct_slice =
      choice == ImageChoice::kAll && scene.plan.Writes(effects::ports::kCtImage);
  if (!has_b_mode && !has_ct_slice) return;
  probe_ = *probe;
  if (has_ct_slice) {
    ct_slice_.emplace(*scene.ct, acoustics::ImageOf(*probe), probe->slice_thickness_mm,
                      scene.ct_window);
  }
  if (has_b_mode) {
    b_mode_.emplace(ImagePatient{scene.ct.get(), scene.labels.get(), scene.triangles.get()}, *probe,
                    *scene.b_mode);
  }
  if (scene.needle) {
    needle_reach_mm_ = NeedleReachMm(*probe, 0.5 * scene.needle->beam.outer_diameter_mm);
  }
}

std::optional<image::NeedleInImage> ImagedNeedle(const Scene& scene, const Snapshot& snapshot) {
  if (!snapshot.ct_from_needle) return std::nullopt;
  image::NeedleInImage needle{snapshot.ct_from_needle->translation(),
                              snapshot.ct_from_needle->linear().col(2), scene.needle->length_mm,
                              0.5 * scene.needle->beam.outer_diameter_mm};
  if (snapshot.needle_shape != nullptr) needle.shape = *snapshot.needle_shape;
  return needle;
}

bool ProbeImageRenderer::ReadsRestMap() const {
  return (ct_slice_ && scene_.plan.Reads(effects::ports::kCtImage, effects::ports::kRestMap)) ||
         (b_mode_ && scene_.plan.Reads(effects::ports::kBMode, effects::ports::kRestMap));
}

Sleep ProbeImageRenderer::SleepOf(effects::PortRef id, const Snapshot& snapshot,
                                  const Snapshot* shown) const noexcept {
  if (!snapshot.probe_valid) return Sleep::kProbeUnseen;
  if (shown == nullptr || !ProbeHasStayed(*shown, snapshot) ||
      !TissueHasStayed(scene_, *shown, snapshot)) {
    return Sleep::kAwake;
  }
  if (id == effects::ports::kBMode && !scene_.listed.IsSameEcho(shown->memory, snapshot.memory)) {
    return Sleep::kAwake;
  }
  const bool with_needle =
      id == effects::ports::kCtImage ? scene_.needle_in_ct_slice : scene_.needle_in_b_mode;
  if (!with_needle || NeedleHasStayed(*shown, snapshot)) return Sleep::kNothingMoved;
  const bool unseen = NeedleIsOffPlane(scene_, *shown, needle_reach_mm_) &&
                      NeedleIsOffPlane(scene_, snapshot, needle_reach_mm_);
  return unseen ? Sleep::kNeedleOffPlane : Sleep::kAwake;
}

bool ProbeImageRenderer::Sleeps(effects::PortRef id, const Snapshot& snapshot,
                                const Snapshot& shown) const noexcept {
  if (!snapshot.probe_valid) return !shown.probe_valid;  // A black image stays black.
  return SleepOf(id, snapshot, &shown) != Sleep::kAwake;
}

void ProbeImageRenderer::DrawBMode(Sleep sleep, const Snapshot& snapshot,
                                   const std::optional<image::NeedleInImage>& needle,
                                   const slicing::RestMap* rest, image::GrayImage& out) {
  image::GrayImage& drawn = persistence_.on() ? frame_ : out;
  Draw(*b_mode_, sleep, snapshot, needle, rest, drawn);
  if (sleep == Sleep::kAwake) ChangeEchoes(scene_, snapshot, *probe_, b_mode_->image(), drawn);
  if (!persistence_.on()) return;
  // Persistence also changes the image of an unchanged scene.
  const bool unseen = sleep == Sleep::kProbeUnseen;
  if (unseen) persistence_.Reset();
  persistence_.Add(snapshot.time_ns, frame_, out);
  if (unseen) persistence_.Reset();  // The first image after that does not fade in from black.
}

void ProbeImageRenderer::Render(const Snapshot& snapshot, ProbeImages& out, StageTimes* times,
                                const Snapshot* shown) {
  Stopwatch watch(times);
  const Sleep none = Sleep::kNothingMoved;
  const Sleep of_slice = ct_slice_ ? SleepOf(effects::ports::kCtImage, snapshot, shown) : none;
  const bool has_frame = !persistence_.on() || !frame_.pixels.empty();
  const Sleep of_b_mode =
      b_mode_ ? SleepOf(effects::ports::kBMode, snapshot, has_frame ? shown : nullptr) : none;
  const bool draws = of_slice == Sleep::kAwake || of_b_mode == Sleep::kAwake;
  const slicing::RestMap* rest = draws ? rest_.At(snapshot) : nullptr;
  if (ReadsRestMap()) {
    const Sleep still = snapshot.probe_valid ? Sleep::kNothingMoved : Sleep::kProbeUnseen;
    const Sleep idle = draws ? Sleep::kUndeformed : still;
    watch.EndOf(scene_.plan.WriterOf(effects::ports::kRestMap).number,
                rest != nullptr ? Sleep::kAwake : idle);
  }
  std::optional<image::NeedleInImage> needle;
  if (draws && (scene_.needle_in_ct_slice || scene_.needle_in_b_mode)) {
    needle = ImagedNeedle(scene_, snapshot);
  }
  if (ct_slice_) {
    Draw(*ct_slice_, of_slice, snapshot, scene_.needle_in_ct_slice ? needle : std::nullopt, rest,
         out.ct_slice);
    watch.EndOf(scene_.plan.WriterOf(effects::ports::kCtImage).number, of_slice);
  }
  if (b_mode_) {
    DrawBMode(of_b_mode, snapshot, scene_.needle_in_b_mode ? needle : std::nullopt, rest,
              out.b_mode);
    watch.EndOf(scene_.plan.WriterOf(effects::ports::kBMode).number, of_b_mode);
  }
}

}  // namespace acus::simulation
