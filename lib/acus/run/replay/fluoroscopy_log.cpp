#include "acus/run/replay/fluoroscopy_log.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "acus/base/core/text_table.h"
#include "acus/data/image/film.h"
#include "acus/data/image/png.h"
#include "acus/data/session/sequence_writer.h"
#include "acus/imaging/ultrasound/annotate.h"

namespace acus::replay {
namespace {

using image::GrayImage;
using simulation::Scene;
using simulation::Snapshot;

/// Above and below the picture: text stays off what is seen.
constexpr int kBandPx = 22;

/// "LAO 30  CRAN 10": the detector towards the patient's left and head.
std::string AnglesText(const fluoroscopy::CArmPose& pose) {
  const auto degrees = [](double rad) {
    return static_cast<int>(std::lround(std::abs(rad) * 180.0 / std::numbers::pi));
  };
  return Message(pose.lao_rad < 0.0 ? "RAO " : "LAO ", degrees(pose.lao_rad),
                 pose.cranial_rad < 0.0 ? "  CAUD " : "  CRAN ", degrees(pose.cranial_rad));
}

class Writer {
 public:
  Writer(const Scene& scene, const fluoroscopy::CArmGeometry& geometry,
         std::filesystem::path folder, const ReplayOptions& options)
      : scene_(scene), geometry_(geometry), folder_(std::move(folder)), options_(options) {}

  void Write(const Snapshot& snapshot, const GrayImage& image) {
    if (folder_.empty()) return;
    if (options_.sequence) WriteToSequence(snapshot, image);
    if (!options_.film) return;
    Compose(snapshot, image);
    if (!film_) {
      image::FilmOptions film;
      film.frames_per_s = scene_.fluoroscopy->rate_hz;
      film_.emplace(folder_ / "fluoroscopy.mp4", composed_.width, composed_.height, film);
    }
    film_->Add(composed_);
  }

  WrittenPng WritePicture(const Snapshot& snapshot, const GrayImage& image, int number,
                          std::string caption) {
    Compose(snapshot, image);
    char name[40];
    std::snprintf(name, sizeof name, "fluoroscopy_%02d.png", number);
    image::WritePng(folder_ / name, composed_);
    return {name, std::move(caption)};
  }

  void Finish() {
    if (sequence_) sequence_->Commit();
    if (film_) film_->Finish();
  }

 private:
  void WriteToSequence(const Snapshot& snapshot, const GrayImage& image) {
    const Eigen::Isometry3d reference_from_ct = scene_.ct_from_reference.inverse();
    if (!sequence_) {
      session::SequenceFormat format;
      format.width = static_cast<std::size_t>(image.width);
      format.height = static_cast<std::size_t>(image.height);
      format.fields["ImageToReferenceTransform"] = session::TransformText(
          (Eigen::Affine3d(reference_from_ct) * geometry_.ct_from_image()).matrix());
      sequence_.emplace(folder_ / "fluoroscopy.igs.mha", format);
    }
    session::SequenceFields fields;
    if (snapshot.ct_from_needle) {
      session::AddTransform(fields, "NeedleToReference",
                            (reference_from_ct * *snapshot.ct_from_needle).matrix(), true);
    }
    sequence_->AddFrame(snapshot.time_ns, image.pixels, fields);
  }

  void Compose(const Snapshot& snapshot, const GrayImage& image) {
    composed_.Resize(image.width, image.height + 2 * kBandPx);
    std::ranges::fill(composed_.pixels, std::uint8_t{0});
    std::ranges::copy(image.pixels, composed_.pixels.begin() + kBandPx * image.width);
    char time[32];
    std::snprintf(time, sizeof time, "%8.3f s", 1e-9 * static_cast<double>(snapshot.time_ns));
    const int below = image.height + kBandPx + 6;
    ultrasound::DrawText(composed_, 6, 6, AnglesText(scene_.fluoroscopy->pose));
    ultrasound::DrawText(composed_, image.width - 90, 6, time);
    ultrasound::DrawText(composed_, 6, below, scene_.fluoroscopy->c_arm.name, 160, 0.85);
    // Which side of the patient is where, as long as both sides can be told apart.
    if (std::abs(std::sin(scene_.fluoroscopy->pose.lao_rad)) < 0.8) {
      const bool from_front = std::cos(scene_.fluoroscopy->pose.lao_rad) > 0.0;
      const int half = image.width / 2;
      ultrasound::DrawText(composed_, half - 40, 6, from_front ? "R" : "L");
      ultrasound::DrawText(composed_, half + 30, 6, from_front ? "L" : "R");
    }
  }

  const Scene& scene_;
  const fluoroscopy::CArmGeometry& geometry_;
  std::filesystem::path folder_;
  ReplayOptions options_;
  std::optional<session::SequenceWriter> sequence_;
  std::optional<image::FilmWriter> film_;
  GrayImage composed_;
};

/// The picture with the needle deepest in the patient, else the middle one.
std::size_t BestPicture(const std::vector<Snapshot>& snapshots, const StepLog& steps) {
  std::size_t best = snapshots.size() / 2;
  double deepest_mm = 0.0;
  for (const simulation::StepOutput& step : steps.steps) {
    if (step.force.depth_mm <= deepest_mm) continue;
    const auto at = std::ranges::lower_bound(snapshots, step.time_ns, {}, &Snapshot::time_ns);
    if (at == snapshots.end()) break;
    deepest_mm = step.force.depth_mm;
    best = static_cast<std::size_t>(at - snapshots.begin());
  }
  return best;
}

}  // namespace

std::vector<Snapshot> FluoroscopySnapshots(const Scene& scene, const session::Session& session) {
  std::vector<Snapshot> snapshots;
  if (!scene.plan.Has(simulation::StageId::kFluoroscopy)) return snapshots;
  const bool needle = scene.plan.Has(simulation::StageId::kNeedlePose) && !session.needle.empty();
  const session::PoseStream& clock = session.needle.empty() ? session.probe : session.needle;
  if (clock.empty()) return snapshots;
  for (std::int64_t i = 0;; ++i) {
    Snapshot snapshot;
    snapshot.for_c_arm = true;
    snapshot.time_ns = clock.front().time_ns +
                       std::llround(1e9 * static_cast<double>(i) / scene.fluoroscopy->rate_hz);
    if (snapshot.time_ns > clock.back().time_ns) break;
    snapshot.session_s = 1e-9 * static_cast<double>(snapshot.time_ns - session.start_ns());
    snapshot.breath = BreathOf(session, snapshot.time_ns);
    if (needle) {
      const session::PoseSample pose = session::PoseAt(session.needle, snapshot.time_ns);
      if (pose.valid) snapshot.ct_from_needle = scene.ct_from_reference * pose.reference_from_tool;
    }
    snapshots.push_back(snapshot);
  }
  return snapshots;
}

ImageLog RenderFluoroscopy(const Scene& scene, const std::vector<Snapshot>& snapshots,
                           const StepLog& steps, const std::filesystem::path& folder,
                           const ReplayOptions& options, simulation::StageTimes* times,
                           const RunContext& context) {
  ImageLog log;
  log.num_images = static_cast<int>(snapshots.size());
  if (snapshots.empty()) return log;
  simulation::FluoroscopyRenderer renderer(scene, context.num_threads);
  Writer writer(scene, renderer.fluoroscope().geometry(), folder, options);
  const std::size_t best = BestPicture(snapshots, steps);
  GrayImage image;
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    context.Checkpoint("fluoroscopy",
                       static_cast<double>(i) / static_cast<double>(snapshots.size()));
    renderer.Render(snapshots[i], image, context.num_threads, times,
                    i > 0 ? &snapshots[i - 1] : nullptr);
    writer.Write(snapshots[i], image);
    const bool wanted =
        options.png == PngChoice::kAll || (options.png == PngChoice::kEvents && i == best);
    if (!wanted || folder.empty()) continue;
    log.pngs.push_back(writer.WritePicture(
        snapshots[i], image, static_cast<int>(i) + 1,
        Message("fluoroscopy at ", RoundedText(1e-9 * static_cast<double>(snapshots[i].time_ns), 4),
                " s")));
  }
  writer.Finish();
  context.Checkpoint("fluoroscopy", 1.0);
  return log;
}

}  // namespace acus::replay
