#include "acus/run/replay/view_log.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "acus/data/image/film.h"
#include "acus/data/image/png.h"
#include "acus/scene/simulation/view_scene.h"

namespace acus::replay {
namespace {

using simulation::Scene;
using simulation::StageId;

/// Film and pictures, in order of time.
class ViewWriter {
 public:
  ViewWriter(const std::filesystem::path& folder, const ReplayOptions& options, double rate_hz)
      : folder_(folder), options_(options), rate_hz_(rate_hz) {}

  void Write(int index, bool is_middle, const image::ColourImage& picture) {
    if (folder_.empty()) return;
    if (options_.film) {
      if (!film_) {
        image::FilmOptions film;
        film.frames_per_s = std::clamp(rate_hz_, 1.0, 240.0);
        film.quality = 23;  // Colour on smooth surfaces shows bands earlier than speckle.
        film_.emplace(folder_ / "view_3d.mp4", picture.width, picture.height, film);
      }
      film_->Add(picture);
    }
    if (options_.png == PngChoice::kAll) {
      char name[32];
      std::snprintf(name, sizeof name, "view_3d_%05d.png", index);
      image::WritePng(folder_ / "frames" / name, picture);
    } else if (options_.png == PngChoice::kEvents && is_middle) {
      image::WritePng(folder_ / "view_3d.png", picture);
      pngs_.push_back({"view_3d.png", "the patient in the middle of the session"});
    }
  }

  std::vector<WrittenPng> Finish() {
    if (film_) film_->Finish();
    return std::move(pngs_);
  }

 private:
  std::filesystem::path folder_;
  ReplayOptions options_;
  double rate_hz_;
  std::optional<image::FilmWriter> film_;
  std::vector<WrittenPng> pngs_;
};

}  // namespace

ImageLog RenderView(const Scene& scene, const std::vector<simulation::Snapshot>& snapshots,
                    const std::filesystem::path& folder, const ReplayOptions& options,
                    simulation::StageTimes* times, const RunContext& context) {
  ImageLog log;
  if (!scene.plan.Has(StageId::kView3d) || snapshots.empty()) return log;
  // Of the images' moments, as many as come nearest to the rate.
  const int stride =
      std::max(1, static_cast<int>(std::lround(scene.image_rate_hz / scene.view_3d->rate_hz)));
  simulation::ViewRenderer renderer(scene, context);
  std::optional<simulation::ImageRenderer> images;
  if (scene.plan.Reads(StageId::kView3d, effects::ports::kBMode)) {
    images.emplace(scene, nullptr, simulation::Pictures::kBModeOnly);
  }
  ViewWriter writer(folder, options, scene.image_rate_hz / stride);
  simulation::Images plane;
  volume_rendering::ViewPicture picture;
  const int count = static_cast<int>(snapshots.size());
  const simulation::Snapshot* shown = nullptr;
  for (int i = 0; i < count; i += stride) {
    context.Checkpoint("view", static_cast<double>(i) / count);
    const simulation::Snapshot& snapshot = snapshots[static_cast<std::size_t>(i)];
    if (images) images->Render(snapshot, plane, times, shown);
    const bool same_plane =
        shown == nullptr || !images || images->Sleeps(StageId::kUltrasound, snapshot, *shown);
    renderer.Render(snapshot, images ? &plane.b_mode : nullptr, picture, context.num_threads, times,
                    same_plane ? shown : nullptr);
    shown = &snapshot;
    writer.Write(log.num_images++, i <= count / 2 && i + stride > count / 2, picture.colour);
  }
  log.pngs = writer.Finish();
  context.Checkpoint("view", 1.0);
  return log;
}

}  // namespace acus::replay
