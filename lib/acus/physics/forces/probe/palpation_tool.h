// Where the surface of a tool touches: points on the face of a probe or on a fingertip.
#pragma once

#include <Eigen/Core>
#include <array>

namespace acus::forces {

/// Each point stands for the same share of the surface. A plain value of fixed size.
struct PalpationTool {
  static constexpr int kMostNodes = 64;

  /// In the tool's frame, mm: x along the face, +y into the body, the origin is the middle of the
  /// face (or the foremost point of the fingertip).
  std::array<Eigen::Vector3d, kMostNodes> node_mm{};
  int num_nodes = 0;
};

/// The face of a probe: a rectangle, bent about an axis along z if the radius is not 0. The points
/// are a lattice that is even for any number and symmetric to the middle, so that a probe held
/// square to a plane feels no torque.
/// @throws InputError unless 1 <= num_nodes <= kMostNodes, length and width are > 0 and a radius
/// other than 0 is at least half the length.
PalpationTool ProbeFaceNodes(double length_mm, double width_mm, double radius_mm, int num_nodes);

/// The end of a finger that points along +y: a hemisphere, all parts of which count the same.
/// @throws InputError unless 1 <= num_nodes <= kMostNodes and radius_mm > 0.
PalpationTool FingertipNodes(double radius_mm, int num_nodes);

}  // namespace acus::forces
