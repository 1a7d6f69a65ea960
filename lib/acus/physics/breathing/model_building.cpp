#include "acus/physics/breathing/model_building.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::breathing {
namespace {

constexpr std::size_t kFewestPhases = 3;

/// Value n of a phase; 0 for the reference.
double At(const MotionPhase& phase, std::size_t n) {
  return phase.displacement_in_ct_mm.empty() ? 0.0
                                             : static_cast<double>(phase.displacement_in_ct_mm[n]);
}

/// sum over phases of share[j] * u_j.
std::vector<float> Mixed(const MotionPhases& phases, const Eigen::VectorXd& share) {
  std::vector<float> out(phases.num_values());
  for (std::size_t n = 0; n < out.size(); ++n) {
    double sum = 0.0;
    for (std::size_t j = 0; j < phases.phases.size(); ++j) {
      sum += share[static_cast<Eigen::Index>(j)] * At(phases.phases[j], n);
    }
    out[n] = static_cast<float>(sum);
  }
  return out;
}

/// Gram matrix of the fields about their mean.
Eigen::MatrixXd Covariance(const MotionPhases& phases) {
  const auto count = static_cast<Eigen::Index>(phases.phases.size());
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd value(count);
  for (std::size_t n = 0; n < phases.num_values(); ++n) {
    for (Eigen::Index j = 0; j < count; ++j) {
      value[j] = At(phases.phases[static_cast<std::size_t>(j)], n);
    }
    value.array() -= value.mean();
    gram.noalias() += value * value.transpose();
  }
  return gram;
}

/// A field that holds fields of phases, and which component each phase has become.
MotionField FieldOf(const MotionPhases& phases, std::span<const std::size_t> which,
                    std::vector<int>& component) {
  component.clear();
  int count = 0;
  for (const std::size_t j : which) {
    const bool reference = phases.phases[j].displacement_in_ct_mm.empty();
    component.push_back(reference ? KeyFrame::kReference : count++);
  }
  MotionField field(phases.nodes, std::max(1, count));
  for (std::size_t n = 0; n < which.size(); ++n) {
    if (component[n] == KeyFrame::kReference) continue;
    field.SetComponent(component[n], phases.phases[which[n]].displacement_in_ct_mm);
  }
  return field;
}

MotionModel BuildSinusoid(const MotionPhases& phases) {
  // Least squares: u_j = (reference - level_j) F.
  double reference = phases.phases.front().breath.level;
  for (const auto& phase : phases.phases) {
    if (phase.displacement_in_ct_mm.empty()) reference = phase.breath.level;
  }
  Eigen::VectorXd share(static_cast<Eigen::Index>(phases.phases.size()));
  for (Eigen::Index j = 0; j < share.size(); ++j) {
    share[j] = reference - phases.phases[static_cast<std::size_t>(j)].breath.level;
  }
  ACUS_REQUIRE(share.norm() > 0.0, "motion model: the signal is the same in all phases");
  share /= share.squaredNorm();
  MotionField field(phases.nodes, 1);
  field.SetComponent(0, Mixed(phases, share));
  return MotionModel::Sinusoid(std::move(field), reference);
}

MotionModel BuildFrames(MotionKind kind, const MotionPhases& phases) {
  const bool full = kind == MotionKind::kFullCycle;
  const auto place = [&](std::size_t j) {
    const Breath& breath = phases.phases[j].breath;
    return full ? breath.cycle : breath.level;
  };
  std::vector<std::size_t> which;
  for (std::size_t j = 0; j < phases.phases.size(); ++j) {
    // From inspiration to expiration only: expiration has another path.
    if (full || phases.phases[j].breath.cycle <= 0.5 + 1e-9) which.push_back(j);
  }
  std::ranges::sort(which, {}, place);
  std::vector<int> component;
  MotionField field = FieldOf(phases, which, component);
  std::vector<KeyFrame> frames;
  for (std::size_t n = 0; n < which.size(); ++n) {
    frames.push_back({.at = place(which[n]), .component = component[n]});
  }
  return full ? MotionModel::FullCycle(std::move(field), std::move(frames))
              : MotionModel::HalfCycle(std::move(field), std::move(frames));
}

/// Multivariate regression of eq. 11: the same for every node.
MotionModel BuildSurrogate(const MotionPhases& phases) {
  const auto count = static_cast<Eigen::Index>(phases.phases.size());
  Eigen::MatrixXd signal(count, 3);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Breath& breath = phases.phases[static_cast<std::size_t>(j)].breath;
    signal.row(j) << breath.level, breath.level_per_s, 1.0;
  }
  // Scaled, so that the test of the rank does not depend on the signal's unit.
  const Eigen::RowVector3d scale = signal.cwiseAbs().colwise().maxCoeff().cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = signal.array().rowwise() / scale.array();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(scaled, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& strength = svd.singularValues();
  ACUS_REQUIRE(strength[2] > 1e-6 * strength[0], "motion model: the signal and its rate in ", count,
               " phases do not determine a surrogate model; at least three phases with different "
               "signals and rates are needed");
  const Eigen::MatrixXd inverse =
      scale.cwiseInverse().asDiagonal() * svd.solve(Eigen::MatrixXd::Identity(count, count));
  MotionField field(phases.nodes, 3);
  for (int n = 0; n < 3; ++n) {
    field.SetComponent(n, Mixed(phases, inverse.row(n).transpose()));
  }
  return MotionModel::Surrogate(std::move(field));
}

}  // namespace

void MotionPhases::Check() const {
  ACUS_REQUIRE(phases.size() >= kFewestPhases, "motion model: ", phases.size(),
               " phases; at least ", kFewestPhases, " are needed");
  int references = 0;
  for (std::size_t j = 0; j < phases.size(); ++j) {
    const MotionPhase& phase = phases[j];
    ACUS_REQUIRE(std::isfinite(phase.breath.cycle) && std::isfinite(phase.breath.level) &&
                     std::isfinite(phase.breath.level_per_s),
                 "motion model: phase ", j, ": its signal is not finite");
    if (phase.displacement_in_ct_mm.empty()) {
      ++references;
      continue;
    }
    ACUS_REQUIRE(phase.displacement_in_ct_mm.size() == num_values(), "motion model: phase ", j,
                 " has ", phase.displacement_in_ct_mm.size() / 3, " displacements for ",
                 nodes.num_voxels(), " nodes");
    ACUS_REQUIRE(std::ranges::all_of(phase.displacement_in_ct_mm,
                                     [](float value) { return std::isfinite(value); }),
                 "motion model: phase ", j, " has a displacement that is not finite");
  }
  ACUS_REQUIRE(references <= 1, "motion model: ", references,
               " phases without a field; only the reference has none");
}

volume::Geometry NodesOver(const volume::Geometry& box, int per_axis) {
  volume::Geometry nodes = box;
  nodes.size = Eigen::Array3i::Constant(per_axis);
  nodes.spacing_mm =
      box.spacing_mm * (box.size - 1).cast<double>() / static_cast<double>(per_axis - 1);
  return nodes;
}

MotionPhases Resampled(const MotionPhases& phases, const volume::Geometry& nodes) {
  phases.Check();
  MotionPhases out{.nodes = nodes, .phases = {}};
  MotionField field(phases.nodes, 1);
  MotionWeights weights;
  weights.Add(0, 1.0);
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (const MotionPhase& phase : phases.phases) {
    out.phases.push_back({.breath = phase.breath, .displacement_in_ct_mm = {}});
    if (phase.displacement_in_ct_mm.empty()) continue;
    field.SetComponent(0, phase.displacement_in_ct_mm);
    auto& values = out.phases.back().displacement_in_ct_mm;
    values.reserve(out.num_values());
    for (int k = 0; k < nodes.size[2]; ++k) {
      for (int j = 0; j < nodes.size[1]; ++j) {
        for (int i = 0; i < nodes.size[0]; ++i) {
          for (const double mm :
               field.DisplacementMm(weights, ct_from_index * Eigen::Vector3d(i, j, k))) {
            values.push_back(static_cast<float>(mm));
          }
        }
      }
    }
  }
  return out;
}

std::vector<double> VarianceOfModes(const MotionPhases& phases) {
  phases.Check();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(Covariance(phases),
                                                             Eigen::EigenvaluesOnly);
  const Eigen::VectorXd values = modes.eigenvalues().cwiseMax(0.0).reverse();
  const double sum = values.sum();
  std::vector<double> share;
  for (const double value : values) share.push_back(sum > 0.0 ? value / sum : 0.0);
  return share;
}

MotionPhases FilteredInTime(const MotionPhases& phases, int num_modes) {
  phases.Check();
  const auto count = static_cast<Eigen::Index>(phases.phases.size());
  ACUS_REQUIRE(num_modes >= 1, "motion model: ", num_modes,
               " principal components; at least 1 must be kept");
  if (num_modes >= count - 1) return phases;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(Covariance(phases));
  const Eigen::MatrixXd kept = modes.eigenvectors().rightCols(num_modes);
  // u_j becomes the mean and its part in the kept modes: a mix of all phases.
  const Eigen::MatrixXd mean = Eigen::MatrixXd::Constant(count, count, 1.0 / double(count));
  const Eigen::MatrixXd centre = Eigen::MatrixXd::Identity(count, count) - mean;
  const Eigen::MatrixXd share = mean + kept * kept.transpose() * centre;
  MotionPhases out{.nodes = phases.nodes, .phases = {}};
  for (Eigen::Index j = 0; j < count; ++j) {
    const MotionPhase& phase = phases.phases[static_cast<std::size_t>(j)];
    const bool reference = phase.displacement_in_ct_mm.empty();
    out.phases.push_back({.breath = phase.breath,
                          .displacement_in_ct_mm = reference
                                                       ? std::vector<float>{}
                                                       : Mixed(phases, share.row(j).transpose())});
  }
  return out;
}

MotionModel BuildModel(MotionKind kind, const MotionPhases& phases) {
  phases.Check();
  switch (kind) {
    case MotionKind::kFullCycle:
    case MotionKind::kHalfCycle:
      return BuildFrames(kind, phases);
    case MotionKind::kSurrogate:
      return BuildSurrogate(phases);
    case MotionKind::kSinusoid:
      break;
  }
  return BuildSinusoid(phases);
}

}  // namespace acus::breathing
