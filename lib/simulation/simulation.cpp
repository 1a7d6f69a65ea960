#include "simulation/simulation.h"

#include <cmath>

namespace acus::simulation {

volume::Label LabelAt(const volume::LabelMap& labels, const Eigen::Affine3d& index_from_ct,
                      const Eigen::Vector3d& point_in_ct_mm) noexcept {
  const Eigen::Array3d index = (index_from_ct * point_in_ct_mm).array() + 0.5;
  const Eigen::Array3d size = labels.geometry.size.cast<double>();
  // Written so that NaN fails it.
  if (!((index >= 0.0).all() && (index < size).all())) return 0;
  return labels.At(static_cast<int>(index[0]), static_cast<int>(index[1]),
                   static_cast<int>(index[2]));
}

Simulation::Simulation(const Scene& scene)
    : scene_(scene),
      runs_tissue_(scene.plan.Has(StageId::kTissueLookup)),
      runs_force_(scene.plan.Has(StageId::kNeedleForce)) {
  if (runs_tissue_) index_from_ct_ = scene.labels->geometry.index_from_ct();
}

StepOutput Simulation::Step(State& state, const NeedleSample& sample,
                            StageTimes* times) const noexcept {
  Stopwatch watch(times);
  ++state.steps;
  StepOutput out;
  out.time_ns = sample.time_ns;
  out.ct_from_needle = scene_.ct_from_reference * sample.reference_from_needle;
  const Eigen::Vector3d tip_in_ct_mm = out.ct_from_needle.translation();
  watch.EndOf(StageId::kNeedlePose);
  if (runs_tissue_) {
    out.tissue_at_tip = LabelAt(*scene_.labels, index_from_ct_, tip_in_ct_mm);
    watch.EndOf(StageId::kTissueLookup);
  }
  if (runs_force_) {
    // Nothing to do while the needle is in free space; the law itself then returns at once.
    const bool asleep = out.tissue_at_tip == 0 && !state.force.in_body;
    out.force =
        scene_.forces->Step(state.force, {.time_s = 1e-9 * static_cast<double>(sample.time_ns),
                                          .tip_in_ct_mm = tip_in_ct_mm,
                                          .axis_in_ct = out.ct_from_needle.linear().col(2),
                                          .tissue_at_tip = out.tissue_at_tip,
                                          .valid = sample.valid});
    watch.EndOf(StageId::kNeedleForce, asleep);
  }
  return out;
}

}  // namespace acus::simulation
