// The images of a replay: rendered on several threads, written in order.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"
#include "acus/run/replay/labelled_images.h"
#include "acus/run/replay/replay.h"
#include "acus/run/replay/step_log.h"
#include "acus/scene/simulation/probe_image_renderer.h"

namespace acus::replay {

/// Snapshots at the times of images: from the first to the last reading of the probe, at the
/// scene's rate. Empty if the plan has no image. Adds the cost of the probe's poses to `times`, if
/// given.
std::vector<simulation::Snapshot> Snapshots(const simulation::Scene& scene,
                                            const session::Session& session,
                                            simulation::StageTimes* times);

/// The snapshot for an image of the session at a time, without the results of steps.
simulation::Snapshot SnapshotAt(const simulation::Scene& scene, const session::Session& session,
                                std::int64_t time_ns);

/// An image with a still image of its event.
struct EventImage {
  int index = 0;        ///< Index among the scene's snapshots.
  std::string caption;  ///< "bone contact at 17.80 s, 57.3 mm deep"
};

/// The first image after each event with a sudden force: punctures and bone contacts.
/// @param snapshots  For the scene's images, in order of time.
std::vector<EventImage> EventImages(const std::vector<simulation::Snapshot>& snapshots,
                                    const StepLog& log);

/// An image that was written as PNG.
struct WrittenPng {
  std::filesystem::path file;  ///< Relative to the run folder.
  std::string caption;
};

/// A video in the run folder.
struct WrittenFilm {
  std::string file;
  std::string title;
};

struct ImageLog {
  int num_images = 0;
  std::vector<WrittenPng> pngs;
  std::vector<WrittenFilm> films;
  /// Thread CPU time of the images of the probe that were rendered, s. The first image of each
  /// thread is excluded: it allocates buffers for the others.
  std::vector<double> cpu_s;
};

/// Renders all snapshots and writes `images.igs.mha`, `film.mp4` and PNG files into `folder`, or
/// nothing if `folder` is empty. The bytes do not depend on context.num_threads. Adds the cost of
/// the image stages to `times`, if given, and each image to `labelled`, if given.
ImageLog RenderImages(const simulation::Scene& scene,
                      const std::vector<simulation::Snapshot>& snapshots, const StepLog& steps,
                      const std::filesystem::path& folder, const ReplayOptions& options,
                      simulation::StageTimes* times, const RunContext& context,
                      LabelledImages* labelled = nullptr);

}  // namespace acus::replay
