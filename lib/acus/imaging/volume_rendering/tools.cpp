#include "acus/imaging/volume_rendering/tools.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

constexpr int kSides = 16;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Rings of equally many nodes, joined one after the other; ends closed by a node in their middle.
/// Seen along the way from the first ring to the last, nodes run clockwise.
mesh::Surface Joined(const std::vector<Eigen::Matrix3Xd>& rings) {
  const auto sides = rings.front().cols();
  const auto count = static_cast<Eigen::Index>(rings.size());
  mesh::Surface out;
  out.nodes_mm.resize(3, count * sides + 2);
  for (Eigen::Index n = 0; n < count; ++n) {
    out.nodes_mm.middleCols(n * sides, sides) = rings[static_cast<std::size_t>(n)];
  }
  const auto first = static_cast<int>(count * sides);
  out.nodes_mm.col(first) = rings.front().rowwise().mean();
  out.nodes_mm.col(first + 1) = rings.back().rowwise().mean();
  out.triangles.resize(3, 2 * count * sides);
  Eigen::Index next = 0;
  for (int s = 0; s < sides; ++s) {
    const int after = (s + 1) % static_cast<int>(sides);
    out.triangles.col(next++) << first, s, after;
    for (int n = 0; n + 1 < count; ++n) {
      const int low = n * static_cast<int>(sides);
      const int high = low + static_cast<int>(sides);
      out.triangles.col(next++) << low + s, high + s, low + after;
      out.triangles.col(next++) << low + after, high + s, high + after;
    }
    const int end = static_cast<int>((count - 1) * sides);
    out.triangles.col(next++) << first + 1, end + after, end + s;
  }
  return out;
}

/// A ring of a probe's body: half width along x, half thickness along z, how far up from the face,
/// and how much of the face's bend it shows.
struct ProbeRing {
  double half_width_mm;
  double half_thickness_mm;
  double up_mm;
  double bend;
};

double HalfFaceMm(const acoustics::Probe& probe) {
  const bool curved = probe.kind == acoustics::ProbeKind::kCurvilinear;
  return curved ? probe.radius_mm * std::sin(std::min(0.5 * probe.field_of_view_rad, 1.4))
                : 0.5 * probe.width_mm;
}

constexpr double kMarkShare = 1.15;  ///< Of the shaft's radius.
constexpr double kMarkMm = 0.8;
constexpr double kWideMarkMm = 2.4;

/// How far the face lies behind its middle.
double SagMm(const acoustics::Probe& probe, double x_mm) {
  if (probe.kind != acoustics::ProbeKind::kCurvilinear) return 0.0;
  const double r = probe.radius_mm;
  return r - std::sqrt(std::max(0.0, r * r - x_mm * x_mm));
}

/// From the tip on, without points that coincide. @throws InputError for a needle without length.
std::vector<Eigen::Vector3d> LineOf(const image::NeedleInImage& needle) {
  std::vector<Eigen::Vector3d> line;
  for (int n = 0; n < needle.shape.num_points; ++n) {
    const Eigen::Vector3d& point = needle.shape.At(n);
    if (line.empty() || (point - line.back()).norm() > 1e-3) line.push_back(point);
  }
  if (line.size() >= 2) return line;
  ACUS_REQUIRE(needle.length_mm > 0.0 && needle.axis_in_ct.norm() > 0.5,
               "needle in view: it has no length or no direction");
  return {needle.tip_in_ct_mm, needle.tip_in_ct_mm - needle.length_mm * needle.axis_in_ct};
}

void Append(const mesh::Surface& more, mesh::Surface& to) {
  const Eigen::Index nodes = to.nodes_mm.cols();
  const Eigen::Index triangles = to.triangles.cols();
  to.nodes_mm.conservativeResize(3, nodes + more.nodes_mm.cols());
  to.nodes_mm.rightCols(more.nodes_mm.cols()) = more.nodes_mm;
  to.triangles.conservativeResize(3, triangles + more.triangles.cols());
  to.triangles.rightCols(more.triangles.cols()) = more.triangles.array() + static_cast<int>(nodes);
}

}  // namespace

mesh::Surface Tube(const Eigen::Matrix3Xd& points_mm, const Eigen::VectorXd& radius_mm) {
  const Eigen::Index count = points_mm.cols();
  ACUS_REQUIRE(count >= 2 && radius_mm.size() == count, "tube: ", count, " points and ",
               radius_mm.size(), " radii; at least two of both are needed, equally many");
  ACUS_REQUIRE(points_mm.allFinite() && radius_mm.allFinite(),
               "tube: a point or radius is not finite");
  std::vector<Eigen::Matrix3Xd> rings;
  Eigen::Vector3d across = Eigen::Vector3d::Zero();
  for (Eigen::Index n = 0; n < count; ++n) {
    const Eigen::Vector3d along = (points_mm.col(std::min(n + 1, count - 1)) -
                                   points_mm.col(std::max<Eigen::Index>(n - 1, 0)))
                                      .normalized();
    // Carried on from ring to ring: the tube does not twist.
    across -= across.dot(along) * along;
    if (across.norm() < 1e-6) across = along.unitOrthogonal();
    across.normalize();
    const Eigen::Vector3d up = along.cross(across);
    Eigen::Matrix3Xd ring(3, kSides);
    for (int s = 0; s < kSides; ++s) {
      const double angle = -kTwoPi * s / kSides;
      ring.col(s) =
          points_mm.col(n) + radius_mm[n] * (std::cos(angle) * across + std::sin(angle) * up);
    }
    rings.push_back(ring);
  }
  return Joined(rings);
}

mesh::Surface NeedleShaft(const image::NeedleInImage& needle, double least_radius_mm) {
  const double radius_mm = std::max(needle.radius_mm, least_radius_mm);
  std::vector<Eigen::Vector3d> line = LineOf(needle);
  // The point: three radii long.
  const Eigen::Vector3d back = line[1] - line[0];
  const double point_mm = std::min(3.0 * radius_mm, 0.5 * back.norm());
  line.insert(line.begin() + 1, line[0] + point_mm * back.normalized());
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(line.size()));
  for (std::size_t n = 0; n < line.size(); ++n) points.col(static_cast<Eigen::Index>(n)) = line[n];
  Eigen::VectorXd radius = Eigen::VectorXd::Constant(points.cols(), radius_mm);
  radius[0] = 0.0;
  return Tube(points, radius);
}

mesh::Surface NeedleMarks(const image::NeedleInImage& needle, double least_radius_mm,
                          double distance_mm) {
  const double radius_mm = kMarkShare * std::max(needle.radius_mm, least_radius_mm);
  const std::vector<Eigen::Vector3d> line = LineOf(needle);
  mesh::Surface marks;
  int number = 1;
  double passed_mm = 0.0;
  for (std::size_t n = 1; n < line.size(); ++n) {
    const Eigen::Vector3d way = line[n] - line[n - 1];
    const double length_mm = way.norm();
    for (; number * distance_mm <= passed_mm + length_mm; ++number) {
      const double width_mm = number % 5 == 0 ? kWideMarkMm : kMarkMm;
      const Eigen::Vector3d middle =
          line[n - 1] + (number * distance_mm - passed_mm) / length_mm * way;
      Eigen::Matrix3Xd ends(3, 2);
      ends.col(0) = middle - 0.5 * width_mm / length_mm * way;
      ends.col(1) = middle + 0.5 * width_mm / length_mm * way;
      Append(Tube(ends, Eigen::Vector2d::Constant(radius_mm)), marks);
    }
    passed_mm += length_mm;
  }
  return marks;
}

mesh::Surface NeedleHub(const image::NeedleInImage& needle) {
  Eigen::Vector3d end = needle.tip_in_ct_mm - needle.length_mm * needle.axis_in_ct;
  Eigen::Vector3d back = -needle.axis_in_ct;
  if (const int count = needle.shape.num_points; count >= 2) {
    end = needle.shape.At(count - 1);
    back = (end - needle.shape.At(count - 2)).normalized();
  }
  const double up_mm[] = {0.0, 3.0, 3.5, 14.0, 14.5, 20.0, 20.5};
  const double radius_mm[] = {1.0, 1.6, 3.0, 3.4, 2.6, 2.6, 1.0};
  Eigen::Matrix3Xd points(3, 7);
  for (Eigen::Index n = 0; n < 7; ++n) points.col(n) = end + up_mm[n] * back;
  return Tube(points, Eigen::Map<const Eigen::VectorXd>(radius_mm, 7));
}

mesh::Surface ProbeBody(const acoustics::Probe& probe) {
  const double half_mm = HalfFaceMm(probe) + 3.0;
  const double thick_mm = 9.0;
  const double grip_mm = std::min(half_mm, 15.0);
  const std::vector<ProbeRing> shape = {{half_mm - 2.0, thick_mm - 2.5, 0.0, 1.0},
                                        {half_mm - 0.6, thick_mm - 0.7, 0.8, 1.0},
                                        {half_mm, thick_mm, 3.0, 1.0},
                                        {half_mm + 0.5, thick_mm + 1.0, 24.0, 0.6},
                                        {half_mm - 0.5, thick_mm + 2.0, 36.0, 0.2},
                                        {0.5 * (half_mm + grip_mm), 12.0, 46.0, 0.0},
                                        {grip_mm, 12.5, 58.0, 0.0},
                                        {grip_mm - 1.0, 12.5, 100.0, 0.0},
                                        {grip_mm - 2.5, 11.0, 106.0, 0.0},
                                        {5.0, 5.0, 109.0, 0.0}};
  constexpr int kPoints = 48;
  std::vector<Eigen::Matrix3Xd> rings;
  for (const ProbeRing& ring : shape) {
    Eigen::Matrix3Xd nodes(3, kPoints);
    for (int n = 0; n < kPoints; ++n) {
      // A rectangle with round corners: a superellipse.
      const double angle = -kTwoPi * n / kPoints;
      const auto round = [](double value) {
        return std::copysign(std::pow(std::abs(value), 0.5), value);
      };
      const double x_mm = ring.half_width_mm * round(std::cos(angle));
      nodes.col(n) << x_mm, -ring.up_mm - ring.bend * SagMm(probe, x_mm),
          ring.half_thickness_mm * round(std::sin(angle));
    }
    rings.push_back(nodes);
  }
  return Joined(rings);
}

mesh::Surface ProbeMark(const acoustics::Probe& probe) {
  const double x_mm = HalfFaceMm(probe) + 3.4;
  const double sag_mm = 0.6 * SagMm(probe, HalfFaceMm(probe));
  Eigen::Matrix3Xd points(3, 4);
  points << x_mm, x_mm, x_mm, x_mm,                                    //
      -22.0 - sag_mm, -23.0 - sag_mm, -30.0 - sag_mm, -31.0 - sag_mm,  //
      0.0, 0.0, 0.0, 0.0;
  return Tube(points, Eigen::Vector4d(0.4, 1.8, 1.8, 0.4));
}

ImagePlane PlaneOf(const acoustics::Probe& probe) {
  const image::ImageGeometry image = acoustics::ImageOf(probe);
  const acoustics::ScanGrid grid = acoustics::ScanGridOf(probe);
  // A strip of lines from the face to the depth.
  constexpr int kMostLines = 64;
  const int stride = std::max(1, (grid.lines() - 1) / kMostLines);
  std::vector<std::size_t> lines;
  for (int n = 0; n < grid.lines() - 1; n += stride) lines.push_back(static_cast<std::size_t>(n));
  lines.push_back(static_cast<std::size_t>(grid.lines() - 1));
  const auto count = static_cast<Eigen::Index>(lines.size());
  const double depth_mm = grid.step_mm * (grid.samples - 1);
  ImagePlane out;
  out.surface.nodes_mm.setZero(3, 2 * count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const std::size_t line = lines[static_cast<std::size_t>(n)];
    out.surface.nodes_mm.col(n).head<2>() = grid.start_mm[line];
    out.surface.nodes_mm.col(count + n).head<2>() =
        grid.start_mm[line] + depth_mm * grid.direction[line];
  }
  out.surface.triangles.resize(3, 2 * (count - 1));
  const auto across = static_cast<int>(count);
  for (int n = 0; n + 1 < across; ++n) {
    out.surface.triangles.col(2 * n) << n, across + n, n + 1;
    out.surface.triangles.col(2 * n + 1) << n + 1, across + n, across + n + 1;
  }
  out.pixel_of_node =
      (image.probe_from_image().inverse() * out.surface.nodes_mm).topRows<2>().cast<float>();
  Eigen::Matrix3Xd around(3, 2 * count + 1);
  around << out.surface.nodes_mm.leftCols(count),
      out.surface.nodes_mm.rightCols(count).rowwise().reverse(), out.surface.nodes_mm.col(0);
  // All lines of a phased probe begin at one point.
  Eigen::Index kept = 1;
  for (Eigen::Index n = 1; n < around.cols(); ++n) {
    if ((around.col(n) - around.col(kept - 1)).norm() > 1e-3) around.col(kept++) = around.col(n);
  }
  out.outline_mm = around.leftCols(kept);
  return out;
}

}  // namespace acus::volume_rendering
