#include "acus/run/replay/run_warnings.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/imaging/acoustics/probe.h"

namespace acus::replay {
namespace {

using simulation::Scene;
using simulation::Snapshot;

constexpr double kAirHu = -400.0;

/// True if there is tissue at a place of the patient at rest.
class BodyAt {
 public:
  explicit BodyAt(const Scene& scene)
      : scene_(scene),
        index_from_ct_(scene.ct ? scene.ct->geometry.index_from_ct()
                                : scene.labels->geometry.index_from_ct()) {}

  bool operator()(const Eigen::Vector3d& in_ct_mm) const {
    if (!scene_.ct) return volume::LabelAt(*scene_.labels, index_from_ct_, in_ct_mm) != 0;
    const Eigen::Vector3d index = index_from_ct_ * in_ct_mm;
    const auto& size = scene_.ct->geometry.size;
    for (int k = 0; k < 3; ++k) {
      if (!(index[k] > -0.5 && index[k] < size[static_cast<std::size_t>(k)] - 0.5)) return false;
    }
    const Eigen::Vector3i voxel = index.array().round().cast<int>();
    return scene_.ct->At(voxel.x(), voxel.y(), voxel.z()) > kAirHu;
  }

 private:
  const Scene& scene_;
  Eigen::Affine3d index_from_ct_;
};

/// True if some of the images, evenly over the session, have tissue on some of their beams.
bool ShowBody(const Scene& scene, std::span<const Snapshot> images) {
  constexpr std::size_t kMostImages = 50;
  constexpr int kMostLines = 16;
  constexpr double kStepMm = 2.0;
  const BodyAt is_body(scene);
  const acoustics::ScanGrid grid = acoustics::ScanGridOf(*scene.probe);
  const int line_step = std::max(1, grid.lines() / kMostLines);
  const double length_mm = grid.step_mm * grid.samples;
  for (std::size_t i = 0; i < images.size(); i += images.size() / kMostImages + 1) {
    if (!images[i].probe_valid) continue;
    for (int line = 0; line < grid.lines(); line += line_step) {
      const auto n = static_cast<std::size_t>(line);
      for (double along_mm = 0.0; along_mm < length_mm; along_mm += kStepMm) {
        const Eigen::Vector2d at = grid.start_mm[n] + along_mm * grid.direction[n];
        if (is_body(images[i].ct_from_probe * Eigen::Vector3d(at.x(), at.y(), 0.0))) return true;
      }
    }
  }
  return false;
}

void AddOfNeedle(const Scene& scene, const StepLog& log, std::vector<std::string>& warnings) {
  const auto& state = forces::TrackOf(log.final_state.force);
  if (state.num_rejected > 0) {
    warnings.push_back(Message(state.num_rejected, " needle samples were not finite"));
  }
  const bool is_in_body =
      std::ranges::any_of(log.steps, [](const auto& step) { return step.force.depth_mm > 0.0; });
  if (scene.plan.Writes(effects::ports::kForce) && log.final_state.needle_seen && !is_in_body) {
    warnings.emplace_back(
        "the needle was never in the body, so that it felt no force: is the transform right?");
  }
  const auto& rod = log.final_state.shape.needle.rod;
  if (rod.num_not_converged > 0) {
    warnings.push_back(Message("the bendable needle was not quite at rest in ",
                               rod.num_not_converged, " steps; it continued in the next"));
  }
}

void AddOfProbe(const Scene& scene, const StepLog& log, std::span<const Snapshot> images,
                std::vector<std::string>& warnings) {
  const auto& probe = forces::GateOf(log.final_state.probe);
  if (probe.num_rejected > 0) {
    warnings.push_back(Message(probe.num_rejected, " probe samples were no poses in a room"));
  }
  const bool felt = std::ranges::any_of(log.steps, [](const auto& s) { return s.probe.on_skin; });
  if (scene.plan.Writes(effects::ports::kProbeForce) && !felt) {
    warnings.emplace_back(
        "the probe never touched the skin: is the transform right? On a mannequin that does not "
        "yield it only lies on it; /effects/probe_force/press_mm takes it deeper");
  }
  const bool has_images = scene.probe && (scene.ct || scene.labels) &&
                          std::ranges::any_of(images, &Snapshot::probe_valid);
  if (has_images && !ShowBody(scene, images)) {
    warnings.emplace_back(
        "no image shows the body: all beams of the probe were in air. Is the transform right?");
  }
}

}  // namespace

std::vector<std::string> RunWarnings(const Scene& scene, const StepLog& log,
                                     std::span<const Snapshot> images) {
  std::vector<std::string> warnings;
  AddOfNeedle(scene, log, warnings);
  AddOfProbe(scene, log, images, warnings);
  return warnings;
}

}  // namespace acus::replay
