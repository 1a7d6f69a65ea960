#include "acus/physics/breathing/model_errors.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::breathing {
namespace {

void AddErrors(const MotionModel& model, const MotionPhases& known, const MotionPhase& phase,
               std::span<const std::uint8_t> where, std::vector<double>& errors_mm) {
  const MotionWeights weights = model.WeightsAt(phase.breath);
  const Eigen::Affine3d ct_from_index = known.nodes.ct_from_index();
  std::size_t n = 0;
  for (int k = 0; k < known.nodes.size[2]; ++k) {
    for (int j = 0; j < known.nodes.size[1]; ++j) {
      for (int i = 0; i < known.nodes.size[0]; ++i, ++n) {
        if (!where.empty() && where[n] == 0) continue;
        Eigen::Vector3d truth = Eigen::Vector3d::Zero();
        if (!phase.displacement_in_ct_mm.empty()) {
          truth =
              Eigen::Map<const Eigen::Vector3f>(&phase.displacement_in_ct_mm[3 * n]).cast<double>();
        }
        const Eigen::Vector3d place = ct_from_index * Eigen::Vector3d(i, j, k);
        errors_mm.push_back((model.field().DisplacementMm(weights, place) - truth).norm());
      }
    }
  }
}

ModelError Summary(const std::vector<double>& errors_mm) {
  ACUS_REQUIRE(!errors_mm.empty(), "motion model: no node to judge it by");
  return {.mean_mm = math::Mean(errors_mm),
          .p95_mm = math::Quantile(errors_mm, 0.95),
          .largest_mm = std::ranges::max(errors_mm)};
}

}  // namespace

ModelError ErrorOf(const MotionModel& model, const MotionPhases& known,
                   std::span<const std::uint8_t> where) {
  ACUS_REQUIRE(where.empty() || where.size() == known.nodes.num_voxels(),
               "motion model: a mask of ", where.size(), " nodes for ", known.nodes.num_voxels());
  std::vector<double> errors_mm;
  for (const MotionPhase& phase : known.phases) AddErrors(model, known, phase, where, errors_mm);
  return Summary(errors_mm);
}

ModelError LeaveOneOutError(MotionKind kind, const MotionPhases& known,
                            std::span<const std::uint8_t> where) {
  std::vector<double> errors_mm;
  for (std::size_t left_out = 0; left_out < known.phases.size(); ++left_out) {
    const MotionPhase& phase = known.phases[left_out];
    if (phase.displacement_in_ct_mm.empty()) continue;
    MotionPhases others = known;
    others.phases.erase(others.phases.begin() + static_cast<std::ptrdiff_t>(left_out));
    AddErrors(BuildModel(kind, others), known, phase, where, errors_mm);
  }
  return Summary(errors_mm);
}

}  // namespace acus::breathing
