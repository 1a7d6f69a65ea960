#include "acus/run/replay/effect_image_log.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "acus/base/core/text_table.h"
#include "acus/data/image/film.h"
#include "acus/data/image/png.h"
#include "acus/data/session/sequence_writer.h"
#include "acus/imaging/ultrasound/display/annotate.h"
#include "acus/scene/simulation/effect_images.h"

namespace acus::replay {
namespace {

using effects::EffectPixels;
using image::GrayImage;
using simulation::ListedEffect;
using simulation::Scene;
using simulation::Snapshot;

/// Height of the text bands above and below an image, outside its content.
constexpr int kBandPx = 22;

/// The times of one effect's images.
struct EffectMoments {
  std::vector<Snapshot> moments;
  double rate_hz = 0.0;
  std::size_t best = 0;  ///< The one to show if only one is shown.
};

/// The snapshot with the needle deepest in the patient, else the middle one.
std::size_t DeepestOf(const std::vector<Snapshot>& moments, const StepLog& steps) {
  std::size_t best = moments.size() / 2;
  double deepest_mm = 0.0;
  for (const simulation::StepOutput& step : steps.steps) {
    if (step.force.depth_mm <= deepest_mm) continue;
    const auto at = std::ranges::lower_bound(moments, step.time_ns, {}, &Snapshot::time_ns);
    if (at == moments.end()) break;
    deepest_mm = step.force.depth_mm;
    best = static_cast<std::size_t>(at - moments.begin());
  }
  return best;
}

std::vector<Snapshot> Those(const std::vector<Snapshot>& moments, std::size_t of_effect) {
  std::vector<Snapshot> found;
  std::ranges::copy_if(moments, std::back_inserter(found),
                       [of_effect](const Snapshot& s) { return s.of_effect == of_effect; });
  return found;
}

EffectMoments MomentsOf(const Scene& scene, std::size_t n, const std::vector<Snapshot>& moments,
                        const StepLog& steps) {
  const effects::ImageTiming& timing = scene.listed.all()[n].timing;
  EffectMoments out;
  if (timing.has_own_moments) {
    out.moments = Those(moments, n);
    out.rate_hz = timing.rate_hz;
    out.best = DeepestOf(out.moments, steps);
    return out;
  }
  const std::vector<Snapshot> all = MomentsOfScene(moments);
  const double per_image = timing.rate_hz > 0.0 ? scene.image_rate_hz / timing.rate_hz : 1.0;
  const auto stride = static_cast<std::size_t>(std::max(1L, std::lround(per_image)));
  for (std::size_t i = 0; i < all.size(); i += stride) out.moments.push_back(all[i]);
  out.rate_hz = scene.image_rate_hz / static_cast<double>(stride);
  out.best = all.size() / 2 / stride;
  return out;
}

/// Sequence, video and single images of one effect, in order of time.
class EffectImageWriter {
 public:
  EffectImageWriter(const Scene& scene, const ListedEffect& effect,
                    const effects::ImageStage& stage, const EffectMoments& moments,
                    std::filesystem::path folder, const ReplayOptions& options)
      : scene_(scene),
        effect_(effect),
        moments_(moments),
        folder_(std::move(folder)),
        options_(options),
        ct_from_image_(stage.ct_from_image()),
        text_(stage.Text()) {}

  void Write(std::size_t index, const EffectPixels& pixels) {
    if (folder_.empty() || pixels.empty()) return;
    const Snapshot& moment = moments_.moments[index];
    if (options_.sequence && ct_from_image_) WriteToSequence(moment, pixels.gray);
    const bool is_wanted = options_.png == PngChoice::kAll ||
                           (options_.png == PngChoice::kEvents && index == moments_.best);
    if (!options_.film && !is_wanted) return;
    if (!pixels.colour.rgb.empty()) {
      WriteShown(index, is_wanted, pixels.colour);
    } else if (text_) {
      Compose(moment, pixels.gray);
      WriteShown(index, is_wanted, composed_);
    } else {
      WriteShown(index, is_wanted, pixels.gray);
    }
  }

  /// A still image of an event.
  void WriteStill(int number, const std::string& caption, const EffectPixels& pixels) {
    char name[24];
    std::snprintf(name, sizeof name, "_event_%02d.png", number);
    log_.pngs.push_back({Key() + name, Message(effect_.title, ": ", caption)});
    if (pixels.colour.rgb.empty()) {
      image::WritePng(folder_ / log_.pngs.back().file, pixels.gray);
    } else {
      image::WritePng(folder_ / log_.pngs.back().file, pixels.colour);
    }
  }

  ImageLog Finish() {
    if (sequence_) sequence_->Commit();
    if (film_) film_->Finish();
    return std::move(log_);
  }

 private:
  std::string Key() const { return std::string(effect_.key); }

  void WriteToSequence(const Snapshot& moment, const GrayImage& image) {
    const Eigen::Isometry3d reference_from_ct = scene_.ct_from_reference.inverse();
    if (!sequence_) {
      session::SequenceFormat format;
      format.width = static_cast<std::size_t>(image.width);
      format.height = static_cast<std::size_t>(image.height);
      format.fields["ImageToReferenceTransform"] =
          session::TransformText((Eigen::Affine3d(reference_from_ct) * *ct_from_image_).matrix());
      sequence_.emplace(folder_ / (Key() + ".igs.mha"), format);
    }
    session::SequenceFields fields;
    if (moment.ct_from_needle) {
      session::AddTransform(fields, "NeedleToReference",
                            (reference_from_ct * *moment.ct_from_needle).matrix(), true);
    }
    sequence_->AddFrame(moment.time_ns, image.pixels, fields);
  }

  void Compose(const Snapshot& moment, const GrayImage& image) {
    composed_.Resize(image.width, image.height + 2 * kBandPx);
    std::ranges::fill(composed_.pixels, std::uint8_t{0});
    std::ranges::copy(image.pixels, composed_.pixels.begin() + kBandPx * image.width);
    char time[32];
    std::snprintf(time, sizeof time, "%8.3f s", 1e-9 * static_cast<double>(moment.time_ns));
    const int half = image.width / 2;
    ultrasound::DrawText(composed_, 6, 6, text_->above);
    ultrasound::DrawText(composed_, image.width - 90, 6, time);
    ultrasound::DrawText(composed_, 6, image.height + kBandPx + 6, text_->below, 160, 0.85);
    ultrasound::DrawText(composed_, half - 40, 6, text_->left);
    ultrasound::DrawText(composed_, half + 30, 6, text_->right);
  }

  template <typename Image>
  void WriteShown(std::size_t index, bool is_wanted, const Image& image) {
    if (options_.film) {
      if (!film_) {
        image::FilmOptions film;
        film.frames_per_s = std::clamp(moments_.rate_hz, 1.0, 240.0);
        // Colour on smooth surfaces shows banding at a compression that speckle hides.
        if constexpr (std::is_same_v<Image, image::ColourImage>) film.quality = 23;
        const std::string name = Key() + ".mp4";
        film_.emplace(folder_ / name, image.width, image.height, film);
        log_.films.push_back({name, std::string(effect_.title)});
      }
      film_->Add(image);
    }
    if (is_wanted) WriteSingle(index, image);
  }

  template <typename Image>
  void WriteSingle(std::size_t index, const Image& image) {
    char number[24];
    if (effect_.timing.has_own_moments) {
      std::snprintf(number, sizeof number, "_%02d.png", static_cast<int>(index) + 1);
      const double time_s = 1e-9 * static_cast<double>(moments_.moments[index].time_ns);
      log_.pngs.push_back(
          {Key() + number, Message(effect_.title, " at ", RoundedText(time_s, 4), " s")});
    } else if (options_.png == PngChoice::kAll) {
      std::snprintf(number, sizeof number, "_%05d.png", static_cast<int>(index));
      image::WritePng(folder_ / "frames" / (Key() + number), image);
      return;
    } else {
      log_.pngs.push_back({Key() + ".png", Message(effect_.title, ", middle of the session")});
    }
    image::WritePng(folder_ / log_.pngs.back().file, image);
  }

  const Scene& scene_;
  const ListedEffect& effect_;
  const EffectMoments& moments_;
  std::filesystem::path folder_;
  ReplayOptions options_;
  std::optional<Eigen::Affine3d> ct_from_image_;
  std::optional<effects::ImageText> text_;
  std::optional<session::SequenceWriter> sequence_;
  std::optional<image::FilmWriter> film_;
  GrayImage composed_;
  ImageLog log_;
};

/// Positions of the needle's tip at the snapshots up to `last`, CT space.
std::vector<Eigen::Vector3d> TipPath(const std::vector<Snapshot>& moments, int last) {
  std::vector<Eigen::Vector3d> path;
  for (int i = 0; i <= last; ++i) {
    const Snapshot& moment = moments[static_cast<std::size_t>(i)];
    const bool bent = moment.needle_shape != nullptr && moment.needle_shape->num_points > 0;
    if (bent) {
      path.push_back(moment.needle_shape->At(0));
    } else if (moment.ct_from_needle) {
      path.emplace_back(moment.ct_from_needle->translation());
    }
  }
  return path;
}

void WriteStills(const std::vector<Snapshot>& of_scene, const StepLog& steps,
                 simulation::EffectImageRenderer& renderer, EffectImageWriter& writer) {
  EffectPixels pixels;
  int number = 0;
  for (const EventImage& event : EventImages(of_scene, steps)) {
    renderer.SetTipPath(TipPath(of_scene, event.index));
    renderer.Render(of_scene[static_cast<std::size_t>(event.index)], nullptr, pixels);
    writer.WriteStill(++number, event.caption, pixels);
  }
}

ImageLog RenderOne(const Scene& scene, const ListedEffect& effect, const EffectMoments& moments,
                   const std::vector<Snapshot>& of_scene, const StepLog& steps,
                   const std::filesystem::path& folder, const ReplayOptions& options,
                   simulation::StageTimes* times, const RunContext& context) {
  simulation::EffectImageRenderer renderer(scene, effect, context);
  EffectImageWriter writer(scene, effect, renderer.stage(), moments, folder, options);
  EffectPixels pixels;
  const std::size_t count = moments.moments.size();
  const std::size_t piece = count / 50 + 1;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % piece == 0) {
      context.Checkpoint(effect.title, static_cast<double>(i) / static_cast<double>(count));
    }
    const Snapshot* moment = &moments.moments[i];
    renderer.Render(*moment, nullptr, pixels, times, i > 0 ? moment - 1 : nullptr);
    writer.Write(i, pixels);
  }
  if (!folder.empty() && options.png == PngChoice::kEvents && renderer.stage().ShowsEvents()) {
    WriteStills(of_scene, steps, renderer, writer);
  }
  context.Checkpoint(effect.title, 1.0);
  ImageLog log = writer.Finish();
  log.num_images = static_cast<int>(count);
  return log;
}

}  // namespace

void AddOwnMoments(const Scene& scene, const session::Session& session,
                   std::vector<Snapshot>& moments) {
  const session::PoseStream& clock = session.needle.empty() ? session.probe : session.needle;
  for (std::size_t n = 0; n < scene.listed.all().size() && !clock.empty(); ++n) {
    const ListedEffect& effect = scene.listed.all()[n];
    if (!effect.has_image || !effect.timing.has_own_moments) continue;
    for (std::int64_t i = 0;; ++i) {
      const std::int64_t time_ns =
          clock.front().time_ns +
          std::llround(1e9 * static_cast<double>(i) / effect.timing.rate_hz);
      if (time_ns > clock.back().time_ns) break;
      moments.push_back(SnapshotAt(scene, session, time_ns));
      moments.back().of_effect = n;
    }
  }
  std::ranges::stable_sort(moments, {}, &Snapshot::time_ns);
}

std::vector<Snapshot> MomentsOfScene(const std::vector<Snapshot>& moments) {
  return Those(moments, Snapshot::kOfScene);
}

std::vector<EffectImageLog> RenderEffectImages(
    const Scene& scene, const std::vector<Snapshot>& moments, const StepLog& steps,
    const std::filesystem::path& folder, const ReplayOptions& options,
    simulation::StageTimes* times, const RunContext& context) {
  std::vector<EffectImageLog> logs;
  const std::vector<Snapshot> of_scene = MomentsOfScene(moments);
  for (std::size_t n = 0; n < scene.listed.all().size(); ++n) {
    const ListedEffect& effect = scene.listed.all()[n];
    if (!effect.has_image) continue;
    const EffectMoments own = MomentsOf(scene, n, moments, steps);
    if (own.moments.empty()) continue;
    logs.push_back({std::string(effect.key), RenderOne(scene, effect, own, of_scene, steps, folder,
                                                       options, times, context)});
  }
  return logs;
}

}  // namespace acus::replay
