#include "acus/physics/forces/probe/palpation_tool.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::forces {
namespace {

constexpr double kGoldenShare = 1.0 / std::numbers::phi;

double Fraction(double x) {
  return x - std::floor(x);
}

void CheckCount(int num_nodes) {
  ACUS_REQUIRE(num_nodes >= 1 && num_nodes <= PalpationTool::kMostNodes, "a tool has 1 to ",
               PalpationTool::kMostNodes, " proxies, not ", num_nodes);
}

}  // namespace

PalpationTool ProbeFaceNodes(double length_mm, double width_mm, double radius_mm, int num_nodes) {
  CheckCount(num_nodes);
  ACUS_REQUIRE(length_mm > 0.0 && width_mm > 0.0, "the face of a probe is ", length_mm, " x ",
               width_mm, " mm; both must be above 0");
  ACUS_REQUIRE(radius_mm == 0.0 || radius_mm >= 0.5 * length_mm, "the face of a probe has a radius",
               " of ", radius_mm, " mm; it must be 0 (flat) or at least half its length, ",
               0.5 * length_mm, " mm");
  PalpationTool tool;
  tool.num_nodes = num_nodes;
  for (int i = 0; i < num_nodes; ++i) {
    const double from_middle = i - 0.5 * (num_nodes - 1);
    const double along = from_middle / num_nodes;
    const double across = Fraction(kGoldenShare * from_middle + 0.5) - 0.5;
    const double x_mm = length_mm * along;
    const double behind_mm =
        radius_mm > 0.0 ? radius_mm - std::sqrt(radius_mm * radius_mm - x_mm * x_mm) : 0.0;
    tool.node_mm[static_cast<std::size_t>(i)] = {x_mm, -behind_mm, width_mm * across};
  }
  return tool;
}

PalpationTool FingertipNodes(double radius_mm, int num_nodes) {
  CheckCount(num_nodes);
  ACUS_REQUIRE(radius_mm > 0.0, "a fingertip has a radius above 0, not ", radius_mm, " mm");
  PalpationTool tool;
  tool.num_nodes = num_nodes;
  for (int i = 0; i < num_nodes; ++i) {
    // Equal areas of a sphere are equal heights.
    const double height = num_nodes == 1 ? 1.0 : 1.0 - (i + 0.5) / num_nodes;
    const double aside = std::sqrt(1.0 - height * height);
    const double turn_rad = 2.0 * std::numbers::pi * kGoldenShare * i;
    tool.node_mm[static_cast<std::size_t>(i)] =
        radius_mm *
        Eigen::Vector3d(aside * std::cos(turn_rad), height - 1.0, aside * std::sin(turn_rad));
  }
  return tool;
}

}  // namespace acus::forces
