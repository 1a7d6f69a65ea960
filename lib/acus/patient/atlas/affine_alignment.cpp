#include "acus/patient/atlas/affine_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace acus::atlas {
namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;
using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

constexpr int kStride = 2;                                 // Every second node in each direction.
constexpr double kHeightStepMm = 20.0, kHeightMm = 600.0;  // Starts along the body.
constexpr double kLeastShared = 0.35;                      // Of the body that must be in the atlas.
constexpr std::size_t kStarts = 4;                         // That are refined.
constexpr int kAlignmentSteps = 30;
constexpr double kOutlier = 150.0;  // Differences far above this say nothing.
constexpr double kStiffness = 0.5;  // What a change of shape by 1 mm in 100 mm costs.
constexpr double kDamping = 1e-3;
constexpr double kLongestStep = 15.0, kShortestStep = 0.05;  // mm, or mm in 100 mm.

struct Node {
  Vector3d at_mm;
  float value = 0.0F;
};

std::vector<Node> NodesOf(const volume::Grid<float>& image, const segmentation::Mask& body) {
  const volume::Geometry& g = image.geometry;
  const Affine3d ct_from_index = g.ct_from_index();
  std::vector<Node> nodes;
  for (int k = 0; k < g.size[2]; k += kStride) {
    for (int j = 0; j < g.size[1]; j += kStride) {
      for (int i = 0; i < g.size[0]; i += kStride) {
        if (body.At(i, j, k) == 0) continue;
        nodes.push_back({.at_mm = ct_from_index * Vector3d(i, j, k), .value = image.At(i, j, k)});
      }
    }
  }
  return nodes;
}

Vector3d CentreOf(const segmentation::Mask& body) {
  const Affine3d ct_from_index = body.geometry.ct_from_index();
  Vector3d sum = Vector3d::Zero();
  double count = 0.0;
  for (int k = 0; k < body.geometry.size[2]; ++k) {
    for (int j = 0; j < body.geometry.size[1]; ++j) {
      for (int i = 0; i < body.geometry.size[0]; ++i) {
        if (body.At(i, j, k) == 0) continue;
        sum += ct_from_index * Vector3d(i, j, k);
        count += 1.0;
      }
    }
  }
  return sum / std::max(count, 1.0);
}

struct Fit {
  double difference = 0.0;  ///< Mean of the robust squared difference; less is better.
  double shared = 0.0;      ///< Share of the nodes that lie in the atlas.
};

class Aligner {
 public:
  Aligner(std::vector<Node> nodes, const breathing_registration::ModelImage& atlas)
      : nodes_(std::move(nodes)), atlas_(atlas), index_from_ct_(atlas.geometry().index_from_ct()) {
    for (const Node& node : nodes_) centre_ += node.at_mm / static_cast<double>(nodes_.size());
  }

  Fit FitOf(const Affine3d& map) const {
    double sum = 0.0, count = 0.0;
    for (const Node& node : nodes_) {
      const auto sample = atlas_.At((index_from_ct_ * (map * node.at_mm)).cast<float>());
      if (!sample.within) continue;
      const double r = sample.value - node.value;
      sum += r * r / (1.0 + r * r / (kOutlier * kOutlier));
      count += 1.0;
    }
    return {.difference = count > 0.0 ? sum / count : 1e9,
            .shared = count / std::max<double>(1.0, static_cast<double>(nodes_.size()))};
  }

  Affine3d Refined(Affine3d map) const {
    for (int iteration = 0; iteration < kAlignmentSteps; ++iteration) {
      Vector12d step = Step(map);
      const double longest = step.cwiseAbs().maxCoeff();
      if (longest > kLongestStep) step *= kLongestStep / longest;
      const Eigen::Matrix3d shape = step.head<9>().reshaped(3, 3) / 100.0;
      map.linear() += shape;
      map.translation() += step.tail<3>() - shape * centre_;
      if (longest < kShortestStep) break;
    }
    return map;
  }

 private:
  /// Changes of the linear part per 100 mm (by columns), then the shift of the centre, mm.
  Vector12d Step(const Affine3d& map) const {
    Matrix12d hessian = Matrix12d::Zero();
    Vector12d force = Vector12d::Zero();
    double count = 0.0;
    for (const Node& node : nodes_) {
      const auto sample = atlas_.At((index_from_ct_ * (map * node.at_mm)).cast<float>());
      if (!sample.within) continue;
      count += 1.0;
      const double r = sample.value - node.value;
      const double weight = 1.0 / std::pow(1.0 + r * r / (kOutlier * kOutlier), 2.0);
      const Vector3d slope = index_from_ct_.linear().transpose() * sample.gradient.cast<double>();
      const Vector3d arm = (node.at_mm - centre_) / 100.0;
      Vector12d row;
      row << slope * arm[0], slope * arm[1], slope * arm[2], slope;
      hessian += weight * row * row.transpose();
      force -= weight * r * row;
    }
    const Eigen::Matrix3d change = 100.0 * (map.linear() - Eigen::Matrix3d::Identity());
    force.head<9>() -= kStiffness * count * change.reshaped();
    hessian.diagonal().head<9>().array() += kStiffness * count;
    hessian.diagonal().array() += kDamping * std::max(count, 1.0);
    return hessian.ldlt().solve(force);
  }

  std::vector<Node> nodes_;
  const breathing_registration::ModelImage& atlas_;
  Affine3d index_from_ct_;
  Vector3d centre_ = Vector3d::Zero();
};

}  // namespace

std::optional<Affine3d> AlignBodies(const volume::Grid<float>& image,
                                    const segmentation::Mask& body,
                                    const breathing_registration::ModelImage& atlas,
                                    const segmentation::Mask& atlas_body) {
  const Aligner aligner(NodesOf(image, body), atlas);
  const Vector3d shift = CentreOf(atlas_body) - CentreOf(body);
  std::vector<std::pair<double, Affine3d>> starts;
  for (double height_mm = -kHeightMm; height_mm <= kHeightMm; height_mm += kHeightStepMm) {
    const Affine3d start(Eigen::Translation3d(shift + height_mm * Vector3d::UnitZ()));
    const Fit fit = aligner.FitOf(start);
    if (fit.shared >= kLeastShared) starts.emplace_back(fit.difference, start);
  }
  std::ranges::stable_sort(starts, {}, &std::pair<double, Affine3d>::first);
  std::optional<Affine3d> best;
  double least = 1e9;
  for (std::size_t n = 0; n < std::min(kStarts, starts.size()); ++n) {
    const Affine3d map = aligner.Refined(starts[n].second);
    const Fit fit = aligner.FitOf(map);
    if (fit.shared < kLeastShared || fit.difference >= least) continue;
    least = fit.difference;
    best = map;
  }
  return best;
}

}  // namespace acus::atlas
