#include "acus/run/replay/other_image_log.h"

#include <cstdio>
#include <map>
#include <optional>

#include "acus/data/image/film.h"
#include "acus/data/image/png.h"
#include "acus/scene/simulation/other_images.h"

namespace acus::replay {
namespace {

using simulation::OtherImage;

/// Film and single images of one effect.
class OtherImageWriter {
 public:
  OtherImageWriter(const std::filesystem::path& folder, const ReplayOptions& options,
                   double rate_hz)
      : folder_(folder), options_(options), rate_hz_(rate_hz) {}

  void Write(int index, bool is_middle, const OtherImage& image, OtherImageLog& log) {
    if (folder_.empty() || image.image.pixels.empty()) return;
    const std::string key(image.key);
    if (options_.film) {
      if (!film_) {
        image::FilmOptions film;
        film.frames_per_s = rate_hz_;
        film_.emplace(folder_ / (key + ".mp4"), image.image.width, image.image.height, film);
        log.films.push_back({key + ".mp4", std::string(image.title)});
      }
      film_->Add(image.image);
    }
    if (options_.png == PngChoice::kAll) {
      char number[16];
      std::snprintf(number, sizeof number, "_%05d.png", index);
      image::WritePng(folder_ / "frames" / (key + number), image.image);
    } else if (options_.png == PngChoice::kEvents && is_middle) {
      image::WritePng(folder_ / (key + ".png"), image.image);
      log.pngs.push_back({key + ".png", std::string(image.title) + ", middle of the session"});
    }
  }

  void Finish() {
    if (film_) film_->Finish();
  }

 private:
  std::filesystem::path folder_;
  ReplayOptions options_;
  double rate_hz_;
  std::optional<image::FilmWriter> film_;
};

}  // namespace

OtherImageLog RenderOtherImages(const simulation::Scene& scene,
                                const std::vector<simulation::Snapshot>& snapshots,
                                const std::filesystem::path& folder, const ReplayOptions& options,
                                simulation::StageTimes* times, const RunContext& context) {
  OtherImageLog log;
  if (!scene.others.has_images() || snapshots.empty()) return log;
  simulation::OtherImageRenderer renderer(scene);
  std::optional<simulation::ImageRenderer> of_probe;
  if (renderer.ReadsImages()) of_probe.emplace(scene);
  std::map<std::string_view, OtherImageWriter> writers;
  simulation::Images images;
  std::vector<OtherImage> others;
  const int count = static_cast<int>(snapshots.size());
  for (int i = 0; i < count; ++i) {
    if (i % 16 == 0) context.Checkpoint("images of effects", static_cast<double>(i) / count);
    const simulation::Snapshot& snapshot = snapshots[static_cast<std::size_t>(i)];
    if (of_probe) of_probe->Render(snapshot, images);
    renderer.Render(snapshot, images, others, times);
    for (const OtherImage& other : others) {
      writers.try_emplace(other.key, folder, options, scene.image_rate_hz)
          .first->second.Write(i, i == count / 2, other, log);
    }
  }
  for (auto& [key, writer] : writers) writer.Finish();
  context.Checkpoint("images of effects", 1.0);
  return log;
}

}  // namespace acus::replay
