#include "acus/run/replay/image_log.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <future>
#include <optional>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/parallel.h"
#include "acus/data/image/film.h"
#include "acus/data/image/png.h"
#include "acus/data/session/sequence_writer.h"
#include "acus/imaging/ultrasound/display/annotate.h"
#include "acus/run/replay/trace.h"

namespace acus::replay {
namespace {

using simulation::ProbeImages;
using simulation::Scene;
using simulation::Sleep;
using simulation::Snapshot;

/// Images rendered before the writer takes over: enough to keep both threads busy.
constexpr int kBatch = 16;
constexpr double kNotCounted = -1.0;  ///< Marks an image whose time is not counted.

bool HasImages(const Scene& scene) {
  return scene.plan.Writes(effects::ports::kBMode) || scene.plan.Writes(effects::ports::kCtImage) ||
         scene.listed.has_images();
}

/// "bone contact at 17.80 s, 57.3 mm deep"
std::string CaptionOf(const simulation::StepOutput& step) {
  char text[64];
  std::snprintf(text, sizeof text, " at %.2f s, %.1f mm deep",
                1e-9 * static_cast<double>(step.time_ns), step.force.depth_mm);
  return EventWords(forces::NameOf(step.force.event)) + text;
}

/// The image of the sequence, on the left of the video.
const image::GrayImage& MainImage(const ProbeImages& images) {
  return images.b_mode.pixels.empty() ? images.ct_slice : images.b_mode;
}

/// Also true for an empty image.
bool IsBlack(const image::GrayImage& image) {
  return std::ranges::all_of(image.pixels, [](auto grey) { return grey == 0; });
}

/// Writes images in order of time: sequence, video and single images.
class ImageWriter {
 public:
  ImageWriter(const Scene& scene, const std::vector<Snapshot>& snapshots, const StepLog& steps,
              std::filesystem::path folder, const ReplayOptions& options, LabelledImages* labelled)
      : scene_(scene),
        snapshots_(snapshots),
        steps_(steps),
        folder_(std::move(folder)),
        options_(options),
        labelled_(labelled),
        persistence_(simulation::PersistenceOf(scene)) {
    if (options.png != PngChoice::kEvents) return;
    event_images_ = EventImages(snapshots, steps);
    if (event_images_.empty()) {
      event_images_.push_back({static_cast<int>(snapshots.size() / 2), "middle of the session"});
    }
  }

  void Write(int index, const ProbeImages& frames) {
    // A plan may have only images of effects.
    if (folder_.empty() || MainImage(frames).pixels.empty()) return;
    const Snapshot& snapshot = snapshots_[static_cast<std::size_t>(index)];
    const ProbeImages& images = persistence_.on() ? WithPersistence(snapshot, frames) : frames;
    if (options_.trace) trace_.Add(snapshot.time_ns, images);
    if (labelled_ != nullptr) {
      labelled_->Write(snapshot, StepAt(steps_, snapshot.time_ns), MainImage(images));
    }
    if (options_.sequence) WriteToSequence(snapshot, MainImage(images));
    if (!options_.film && !WantsImage(index)) return;
    Compose(snapshot, images);
    if (options_.film) WriteToFilm(images);
    if (WantsImage(index)) WriteImage(index);
  }

  void Finish() {
    if (sequence_) sequence_->Commit();
    if (film_) film_->Finish();
    if (options_.trace && !folder_.empty()) trace_.Write(folder_ / "image_trace.csv");
  }

  std::vector<WrittenPng> TakePngs() { return std::move(pngs_); }
  std::vector<WrittenFilm> Films() const {
    if (!film_) return {};
    return {{"film.mp4", "Video of the session"}};
  }

 private:
  const ProbeImages& WithPersistence(const Snapshot& snapshot, const ProbeImages& frames) {
    if (!snapshot.probe_valid) persistence_.Reset();
    persistence_.Add(snapshot.time_ns, frames.b_mode, persistent_.b_mode);
    if (!snapshot.probe_valid)
      persistence_.Reset();  // The first image after that does not fade in from black.
    persistent_.ct_slice = frames.ct_slice;
    return persistent_;
  }

  void WriteToSequence(const Snapshot& snapshot, const image::GrayImage& image) {
    if (!sequence_) {
      session::SequenceFormat format;
      format.width = static_cast<std::size_t>(image.width);
      format.height = static_cast<std::size_t>(image.height);
      probe_from_image_ = acoustics::ImageOf(*scene_.probe).probe_from_image();
      format.fields["ImageToProbeTransform"] = session::TransformText(probe_from_image_.matrix());
      sequence_.emplace(folder_ / "images.igs.mha", format);
    }
    const Eigen::Isometry3d reference_from_ct = scene_.ct_from_reference.inverse();
    session::SequenceFields fields;
    const Eigen::Isometry3d reference_from_probe = reference_from_ct * snapshot.ct_from_probe;
    session::AddTransform(fields, "ProbeToReference", reference_from_probe.matrix(),
                          snapshot.probe_valid);
    session::AddTransform(fields, "ImageToReference",
                          reference_from_probe.matrix() * probe_from_image_.matrix(),
                          snapshot.probe_valid);
    if (snapshot.ct_from_needle) {
      session::AddTransform(fields, "NeedleToReference",
                            (reference_from_ct * *snapshot.ct_from_needle).matrix(), true);
    }
    if (const auto* step = StepAt(steps_, snapshot.time_ns)) {
      if (scene_.plan.Writes(effects::ports::kForce)) {
        fields.emplace_back("NeedleAxialForceN", NumberText(step->force.AxialN()));
      }
      if (scene_.plan.Writes(effects::ports::kProbeForce)) {
        fields.emplace_back("ProbeForceN", NumberText(step->probe.force_in_ct_n.norm()));
      }
    }
    sequence_->AddFrame(snapshot.time_ns, image.pixels, fields);
  }

  void Compose(const Snapshot& snapshot, const ProbeImages& images) {
    using Shows = ultrasound::Screen::Shows;
    const bool both = !images.b_mode.pixels.empty() && !images.ct_slice.pixels.empty();
    if (!screen_) {
      const Shows alone = images.b_mode.pixels.empty() ? Shows::kCtSlice : Shows::kBMode;
      screen_.emplace(*scene_.probe, both ? Shows::kBoth : alone);
    }
    const auto* step = StepAt(steps_, snapshot.time_ns);
    char text[80];
    std::snprintf(text, sizeof text, "%8.3f s", 1e-9 * static_cast<double>(snapshot.time_ns));
    std::string line = text;
    if (step != nullptr && scene_.plan.Writes(effects::ports::kForce)) {
      std::snprintf(text, sizeof text, "  %6.1f mm  %5.2f N", step->force.depth_mm,
                    step->force.AxialN());
      line += text;
    }
    const std::optional<ultrasound::ScanExtent> scan = ScanAt(snapshot);
    screen_->Compose(MainImage(images), both ? &images.ct_slice : nullptr, line, composed_,
                     scan ? &*scan : nullptr);
  }

  std::optional<ultrasound::ScanExtent> ScanAt(const Snapshot& snapshot) const {
    if (!snapshot.probe_valid || (scene_.ct == nullptr && scene_.labels == nullptr)) return {};
    const volume::Geometry& geometry =
        scene_.ct != nullptr ? scene_.ct->geometry : scene_.labels->geometry;
    return ultrasound::ScanExtent{geometry.index_from_ct() * snapshot.ct_from_probe, geometry.size};
  }

  void WriteToFilm(const ProbeImages& images) {
    // The video begins with the first image that is not black.
    if (!film_ && IsBlack(images.b_mode) && IsBlack(images.ct_slice)) return;
    if (!film_) {
      image::FilmOptions film;
      film.frames_per_s = scene_.image_rate_hz;
      film_.emplace(folder_ / "film.mp4", composed_.width, composed_.height, film);
    }
    film_->Add(composed_);
  }

  bool WantsImage(int index) const {
    if (options_.png == PngChoice::kAll) return true;
    return std::ranges::find(event_images_, index, &EventImage::index) != event_images_.end();
  }

  void WriteImage(int index) {
    char name[32];
    if (options_.png == PngChoice::kAll) {
      std::snprintf(name, sizeof name, "image_%05d.png", index);
      image::WritePng(folder_ / "frames" / name, composed_);
      return;
    }
    const auto& event = *std::ranges::find(event_images_, index, &EventImage::index);
    std::snprintf(name, sizeof name, "event_%02d.png", static_cast<int>(pngs_.size()) + 1);
    image::WritePng(folder_ / name, composed_);
    pngs_.push_back({name, event.caption});
  }

  const Scene& scene_;
  const std::vector<Snapshot>& snapshots_;
  const StepLog& steps_;
  std::filesystem::path folder_;
  ReplayOptions options_;
  LabelledImages* labelled_;
  std::vector<EventImage> event_images_;
  std::optional<session::SequenceWriter> sequence_;
  Eigen::Affine3d probe_from_image_ = Eigen::Affine3d::Identity();  ///< Geometry of the sequence.
  std::optional<image::FilmWriter> film_;
  std::optional<ultrasound::Screen> screen_;
  ultrasound::FramePersistence persistence_;
  ProbeImages persistent_;
  image::GrayImage composed_;
  ImageTrace trace_;
  std::vector<WrittenPng> pngs_;
};

}  // namespace

std::vector<EventImage> EventImages(const std::vector<Snapshot>& snapshots, const StepLog& log) {
  std::vector<EventImage> chosen;
  for (const simulation::StepOutput& step : log.steps) {
    const auto event = step.force.event;
    if (event != forces::NeedleEvent::kPuncture && event != forces::NeedleEvent::kBoneContact) {
      continue;
    }
    const auto at = std::ranges::lower_bound(snapshots, step.time_ns, {}, &Snapshot::time_ns);
    if (at == snapshots.end()) continue;
    const int index = static_cast<int>(at - snapshots.begin());
    if (!chosen.empty() && chosen.back().index == index) continue;
    chosen.push_back({index, CaptionOf(step)});
  }
  return chosen;
}

Snapshot SnapshotAt(const Scene& scene, const session::Session& session, std::int64_t time_ns) {
  Snapshot snapshot{.time_ns = time_ns,
                    .session_s = 1e-9 * static_cast<double>(time_ns - session.start_ns())};
  snapshot.breath = BreathOf(session, time_ns);
  session::PoseSample probe{.time_ns = time_ns, .valid = false};
  if (!session.probe.empty()) probe = session::PoseAt(session.probe, time_ns);
  snapshot.probe_valid = probe.valid;
  snapshot.ct_from_probe = scene.ct_from_reference * probe.reference_from_tool;
  if (scene.plan.Writes(effects::ports::kNeedle) && !session.needle.empty()) {
    const session::PoseSample pose = session::PoseAt(session.needle, time_ns);
    if (pose.valid) snapshot.ct_from_needle = scene.ct_from_reference * pose.reference_from_tool;
  }
  return snapshot;
}

std::vector<Snapshot> Snapshots(const Scene& scene, const session::Session& session,
                                simulation::StageTimes* times) {
  std::vector<Snapshot> snapshots;
  const bool has_needle = scene.plan.Writes(effects::ports::kNeedle);
  const auto& stream = session.probe.empty() && has_needle ? session.needle : session.probe;
  if (!HasImages(scene) || stream.empty()) return snapshots;
  const std::int64_t first_ns = stream.front().time_ns;
  const std::int64_t last_ns = stream.back().time_ns;
  for (std::int64_t i = 0;; ++i) {
    auto watch = simulation::Stopwatch::OfStep(times, i);
    const std::int64_t time_ns =
        first_ns + std::llround(1e9 * static_cast<double>(i) / scene.image_rate_hz);
    if (time_ns > last_ns) break;
    snapshots.push_back(SnapshotAt(scene, session, time_ns));
    watch.EndOf(scene.plan.WriterOf(effects::ports::kProbe).number,
                snapshots.back().probe_valid ? Sleep::kAwake : Sleep::kProbeUnseen);
  }
  return snapshots;
}

ImageLog RenderImages(const Scene& scene, const std::vector<Snapshot>& snapshots,
                      const StepLog& steps, const std::filesystem::path& folder,
                      const ReplayOptions& options, simulation::StageTimes* times,
                      const RunContext& context, LabelledImages* labelled) {
  ImageLog log;
  log.num_images = static_cast<int>(snapshots.size());
  if (snapshots.empty()) return log;
  std::vector<simulation::ProbeImageRenderer> renderers;
  std::vector<simulation::StageTimes> slot_times(static_cast<std::size_t>(context.num_threads),
                                                 simulation::StageTimes(scene.plan));
  for (int i = 0; i < context.num_threads; ++i) {
    // Their frames are not in order: the writer adds the persistence.
    renderers.emplace_back(scene, nullptr, simulation::ImageChoice::kAll,
                           simulation::Frames::kSingle);
  }

  // An image that is the same as the previous one is not rendered, but copied.
  const auto same = [&](effects::PortRef id, int i) {
    const auto at = static_cast<std::size_t>(i);
    return i > 0 && renderers[0].Sleeps(id, snapshots[at], snapshots[at - 1]);
  };

  // Two batches alternate: while one is rendered, the other is written.
  std::vector<ProbeImages> batches[2] = {std::vector<ProbeImages>(kBatch),
                                         std::vector<ProbeImages>(kBatch)};
  ImageWriter writer(scene, snapshots, steps, folder, options, labelled);
  std::future<void> written;
  log.cpu_s.resize(snapshots.size());
  for (int begin = 0; begin < log.num_images; begin += kBatch) {
    context.Checkpoint("images", static_cast<double>(begin) / log.num_images);
    std::vector<ProbeImages>& batch = batches[begin / kBatch % 2];
    const std::vector<ProbeImages>& other = batches[(begin / kBatch + 1) % 2];
    const int count = std::min(kBatch, log.num_images - begin);
    // One renderer for each thread: thread t renders images t, t + threads, ...
    ParallelFor(context.num_threads, context.num_threads, [&](int thread) {
      const auto slot = static_cast<std::size_t>(thread);
      for (int i = thread; i < count; i += context.num_threads) {
        const Snapshot* snapshot = &snapshots[static_cast<std::size_t>(begin + i)];
        const double begin_s = ThreadCpuSeconds();
        renderers[slot].Render(*snapshot, batch[static_cast<std::size_t>(i)],
                               times != nullptr ? &slot_times[slot] : nullptr,
                               begin + i > 0 ? snapshot - 1 : nullptr);
        log.cpu_s[static_cast<std::size_t>(begin + i)] = ThreadCpuSeconds() - begin_s;
      }
    });
    for (int i = 0; i < count; ++i) {
      const ProbeImages& before = i > 0 ? batch[static_cast<std::size_t>(i) - 1] : other.back();
      ProbeImages& now = batch[static_cast<std::size_t>(i)];
      const bool same_b_mode = same(effects::ports::kBMode, begin + i);
      const bool same_ct_slice = same(effects::ports::kCtImage, begin + i);
      if (same_b_mode) now.b_mode = before.b_mode;
      if (same_ct_slice) now.ct_slice = before.ct_slice;
      if (same_b_mode || same_ct_slice || begin + i < context.num_threads) {
        log.cpu_s[static_cast<std::size_t>(begin + i)] = kNotCounted;
      }
    }
    if (written.valid()) written.get();
    const auto write = [&writer, &batch, begin, count] {
      for (int i = 0; i < count; ++i) writer.Write(begin + i, batch[static_cast<std::size_t>(i)]);
    };
    const auto policy = context.num_threads > 1 ? std::launch::async : std::launch::deferred;
    written = std::async(policy, write);
  }
  if (written.valid()) written.get();
  std::erase_if(log.cpu_s, [](double cpu_s) { return cpu_s == kNotCounted; });
  writer.Finish();
  log.pngs = writer.TakePngs();
  log.films = writer.Films();
  for (const auto& slot : slot_times) {
    if (times != nullptr) times->Add(slot);
  }
  context.Checkpoint("images", 1.0);
  return log;
}

}  // namespace acus::replay
