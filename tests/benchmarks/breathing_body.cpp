#include "benchmarks/breathing_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/random.h"

namespace acus::benchmarks {
namespace {

using Eigen::Vector3d;

constexpr double kHalfWidthMm = 150.0;  // Of the cavity.
constexpr double kHalfDepthMm = 100.0;
constexpr double kLoopMm = 2.0;
constexpr double kChestMm = 5.0;
const Vector3d kHalfBoxMm(180.0, 130.0, 180.0);

double Bell(double z_mm, double middle_mm) {
  const double z = (z_mm - middle_mm) / 60.0;
  return std::exp(-0.5 * z * z);
}

template <typename Keep>
std::vector<Vector3d> RandomPlaces(int count, const Keep& keep) {
  RandomStream random(1, "breathing body", 0);
  std::vector<Vector3d> places;
  while (static_cast<int>(places.size()) < count) {
    Vector3d place;
    for (double& x : place) x = random.Uniform(-0.95, 0.95);
    place = place.cwiseProduct(kHalfBoxMm);
    if (keep(BreathingBody::FromWallMm(place))) places.push_back(place);
  }
  return places;
}

}  // namespace

breathing::Breath BreathingBody::BreathAt(double cycle, double depth) {
  const double angle = std::numbers::pi * cycle;
  const double cosine = std::cos(angle);
  const double fall = 1.0 - std::pow(cosine, 4);
  const double fall_per_s =
      4.0 * std::pow(cosine, 3) * std::sin(angle) * std::numbers::pi / kPeriodS;
  return {.cycle = cycle - std::floor(cycle),
          .level = 1.0 - depth * fall,
          .level_per_s = -depth * fall_per_s};
}

Vector3d BreathingBody::DisplacementMm(const breathing::Breath& breath, const Vector3d& rest_mm) {
  const double out = (1.0 - breath.level) * (1.0 + 0.2 * breath.level);
  const double rate = breath.level_per_s * kPeriodS / std::numbers::pi;
  const double front = std::clamp(0.5 - 0.5 * rest_mm.y() / kHalfBoxMm.y(), 0.0, 1.0);
  Vector3d moved(0.0, kChestMm * out * front * Bell(rest_mm.z(), -20.0), 0.0);
  if (FromWallMm(rest_mm) < 0.0) {
    const double back = 1.0 - 0.3 * front;
    moved.z() =
        kSlidingMm * out * back * Bell(rest_mm.z(), 0.0) + kLoopMm * rate * Bell(rest_mm.z(), 40.0);
  }
  return moved;
}

double BreathingBody::FromWallMm(const Vector3d& rest_mm) {
  return (std::hypot(rest_mm.x() / kHalfWidthMm, rest_mm.y() / kHalfDepthMm) - 1.0) * kHalfDepthMm;
}

volume::Geometry BreathingBody::Nodes(int per_axis) {
  volume::Geometry nodes;
  nodes.size.setConstant(per_axis);
  nodes.spacing_mm = 2.0 * kHalfBoxMm.array() / (per_axis - 1);
  nodes.origin_mm = -kHalfBoxMm;
  return nodes;
}

std::vector<float> BreathingBody::Field(const volume::Geometry& nodes,
                                        const breathing::Breath& breath) {
  std::vector<float> values;
  values.reserve(3 * nodes.num_voxels());
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (int k = 0; k < nodes.size[2]; ++k) {
    for (int j = 0; j < nodes.size[1]; ++j) {
      for (int i = 0; i < nodes.size[0]; ++i) {
        for (const double mm : DisplacementMm(breath, ct_from_index * Vector3d(i, j, k))) {
          values.push_back(static_cast<float>(mm));
        }
      }
    }
  }
  return values;
}

breathing::MotionPhases BreathingBody::Phases(int per_axis, int count) {
  breathing::MotionPhases phases{.nodes = Nodes(per_axis), .phases = {}};
  for (int n = 0; n < count; ++n) {
    const breathing::Breath breath = BreathAt(static_cast<double>(n) / count);
    phases.phases.push_back({.breath = breath, .displacement_in_ct_mm = {}});
    if (n > 0) phases.phases.back().displacement_in_ct_mm = Field(phases.nodes, breath);
  }
  return phases;
}

std::vector<Vector3d> BreathingBody::Places(int count, double off_wall_mm) {
  return RandomPlaces(count, [&](double from_mm) { return std::abs(from_mm) >= off_wall_mm; });
}

std::vector<Vector3d> BreathingBody::PlacesAtWall(int count, double off_wall_mm) {
  return RandomPlaces(count, [&](double from_mm) { return std::abs(from_mm) < off_wall_mm; });
}

}  // namespace acus::benchmarks
