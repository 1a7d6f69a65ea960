#include "acus/data/transforms/transform_graph.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cctype>
#include <cmath>

namespace acus::transforms {
namespace {

constexpr std::string_view kSuffix = "Transform";

std::optional<Eigen::Matrix4d> Inverse(const Eigen::Matrix4d& affine) {
  const double determinant = affine.topLeftCorner<3, 3>().determinant();
  if (!affine.allFinite() || !(std::abs(determinant) > 1e-12)) return {};
  return affine.inverse();
}

}  // namespace

std::optional<TransformName> ParseTransformName(std::string_view name) {
  if (name.size() > kSuffix.size() && name.ends_with(kSuffix)) name.remove_suffix(kSuffix.size());
  std::optional<TransformName> found;
  for (std::size_t at = name.find("To", 1); at != name.npos; at = name.find("To", at + 1)) {
    const std::size_t next = at + 2;
    if (next >= name.size()) break;
    const auto letter = static_cast<unsigned char>(name[next]);
    if (std::isupper(letter) == 0 && std::isdigit(letter) == 0) continue;
    if (found) return {};
    found = TransformName{std::string(name.substr(0, at)), std::string(name.substr(next))};
  }
  return found;
}

void TransformGraph::Set(const TransformName& name, const Eigen::Matrix4d& to_from_from,
                         bool valid) {
  if (name.from == name.to) return;
  for (Edge& edge : edges_) {
    if (edge.name.from == name.from && edge.name.to == name.to) {
      edge.to_from_from = to_from_from;
      edge.valid = valid;
      return;
    }
  }
  edges_.push_back({name, to_from_from, valid});
}

void TransformGraph::AddMissing(const TransformGraph& other) {
  for (const Edge& edge : other.edges_) {
    const bool known = std::ranges::any_of(edges_, [&](const Edge& own) {
      return own.name.from == edge.name.from && own.name.to == edge.name.to;
    });
    if (!known) Set(edge.name, edge.to_from_from, edge.valid);
  }
}

std::optional<TrackedTransform> TransformGraph::Find(std::string_view from,
                                                     std::string_view to) const {
  struct Reached {
    std::string_view frame;
    TrackedTransform frame_from_start;
  };
  std::vector<Reached> reached = {{from, {}}};
  for (std::size_t i = 0; i < reached.size(); ++i) {  // Breadth first: `reached` is the queue.
    const Reached here = reached[i];
    if (here.frame == to) return here.frame_from_start;
    for (const Edge& edge : edges_) {
      const bool forward = edge.name.from == here.frame;
      if (!forward && edge.name.to != here.frame) continue;
      const std::string_view next = forward ? edge.name.to : edge.name.from;
      if (std::ranges::find(reached, next, &Reached::frame) != reached.end()) continue;
      const auto step = forward ? std::optional(edge.to_from_from) : Inverse(edge.to_from_from);
      if (!step) continue;
      reached.push_back({next,
                         {*step * here.frame_from_start.to_from_from,
                          here.frame_from_start.valid && edge.valid}});
    }
  }
  return {};
}

bool TransformGraph::HasFrame(std::string_view frame) const {
  return std::ranges::any_of(
      edges_, [&](const Edge& edge) { return edge.name.from == frame || edge.name.to == frame; });
}

std::string TransformGraph::Names() const {
  std::string names;
  for (const Edge& edge : edges_) {
    names += (names.empty() ? "" : ", ") + edge.name.from + "To" + edge.name.to;
  }
  return names.empty() ? "none" : names;
}

std::optional<ScaledPose> PoseAndScale(const Eigen::Matrix4d& affine, double tolerance) {
  if (!affine.allFinite()) return {};
  const Eigen::Matrix3d linear = affine.topLeftCorner<3, 3>();
  ScaledPose result;
  result.scale = linear.colwise().norm();
  if (!(result.scale.minCoeff() > 1e-9) || linear.determinant() <= 0.0) return {};
  const Eigen::Matrix3d axes = linear * result.scale.cwiseInverse().asDiagonal();
  const Eigen::Matrix3d skew = axes.transpose() * axes - Eigen::Matrix3d::Identity();
  if (skew.cwiseAbs().maxCoeff() > tolerance) return {};
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = svd.matrixU() * svd.matrixV().transpose();
  pose.translation() = affine.topRightCorner<3, 1>();
  result.pose = pose;
  return result;
}

}  // namespace acus::transforms
