#include "acus/patient/phantom/anatomy/patient_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr double kSkinSigmaMm = 2.5;
constexpr double kKnownAirMm = 12.0;  ///< Beyond a border that takes the place of the skin.
constexpr double kCutMarginMm = 6.0;  ///< So near to a cut, the smoothed body bends towards it.

Box Extent(const volume::Geometry& g) {
  return Box(Vector3d::Zero(), (g.size - 1).cast<double>().matrix()).transformed(g.ct_from_index());
}

/// Around all voxels of the body; the volume's extent if there are none.
Box BodyExtent(const volume::LabelMap& labels) {
  Eigen::Array3i first = labels.geometry.size;
  Eigen::Array3i last = Eigen::Array3i::Constant(-1);
  for (int k = 0; k < labels.geometry.size[2]; ++k) {
    for (int j = 0; j < labels.geometry.size[1]; ++j) {
      for (int i = 0; i < labels.geometry.size[0]; ++i) {
        if (labels.At(i, j, k) == 0) continue;
        first = first.min(Eigen::Array3i(i, j, k));
        last = last.max(Eigen::Array3i(i, j, k));
      }
    }
  }
  if (last[0] < 0) return Extent(labels.geometry);
  return Box(first.cast<double>().matrix(), last.cast<double>().matrix())
      .transformed(labels.geometry.ct_from_index());
}

/// Distance from the middle of the slices, within them.
double RadiusMm(const volume::Geometry& g, const Eigen::Array3d& index) {
  const Eigen::Array3d from_middle = (index - 0.5 * (g.size - 1).cast<double>()) * g.spacing_mm;
  return std::hypot(from_middle[0], from_middle[1]);
}

/// Radius of the circle of reconstruction, if it cuts the body: no voxel of the body lies outside
/// of the circle that touches the sides of the slices, and a long arc of it bounds the body.
double CutRadiusMm(const volume::LabelMap& labels) {
  const volume::Geometry& g = labels.geometry;
  const double voxel_mm = std::max(g.spacing_mm[0], g.spacing_mm[1]);
  const double radius_mm = 0.5 * std::min(g.size[0] * g.spacing_mm[0], g.size[1] * g.spacing_mm[1]);
  constexpr double kMinArcMm = 40.0;  // In one slice: what a round back or belly never has.
  const double kNone = std::numeric_limits<double>::infinity();
  double longest_arc_mm = 0.0;
  for (int k = 0; k < g.size[2]; ++k) {
    std::size_t near = 0;
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (labels.At(i, j, k) == 0) continue;
        const double r = RadiusMm(g, Eigen::Array3d(i, j, k));
        if (r > radius_mm + voxel_mm) return kNone;
        near += r > radius_mm - 2.0 * voxel_mm ? 1 : 0;
      }
    }
    // The ring that is counted is two to three voxels wide.
    longest_arc_mm = std::max(longest_arc_mm, static_cast<double>(near) * g.spacing_mm[0] *
                                                  g.spacing_mm[1] / (2.5 * voxel_mm));
  }
  return longest_arc_mm > kMinArcMm ? radius_mm : kNone;
}

struct Stencil {
  std::array<Vector3d, 125> offset_mm;
  std::array<double, 125> weight;
};

/// Gaussian weights on a 5 x 5 x 5 lattice of spacing sigma.
const Stencil& SkinStencil() {
  static const Stencil kStencil = [] {
    Stencil stencil;
    double sum = 0.0;
    for (int n = 0; n < 125; ++n) {
      const Vector3d step(n % 5 - 2, n / 5 % 5 - 2, n / 25 - 2);
      stencil.offset_mm[n] = kSkinSigmaMm * step;
      stencil.weight[n] = std::exp(-0.5 * step.squaredNorm());
      sum += stencil.weight[n];
    }
    for (double& weight : stencil.weight) weight /= sum;
    return stencil;
  }();
  return kStencil;
}

}  // namespace

AnatomyField::AnatomyField(const Anatomy& anatomy, const volume::Geometry& geometry)
    : anatomy_(anatomy), bounds_(Extent(geometry)) {}

LabelMapField::LabelMapField(const volume::LabelMap& labels, Beyond beyond)
    : labels_(labels),
      beyond_(beyond),
      index_from_ct_(labels.geometry.index_from_ct()),
      bounds_(Extent(labels.geometry)),
      body_(BodyExtent(labels)),
      cut_radius_mm_(beyond == Beyond::kAir ? std::numeric_limits<double>::infinity()
                                            : CutRadiusMm(labels)) {
  if (beyond_ == Beyond::kAir) {
    const Vector3d more = Vector3d::Constant(kKnownAirMm);
    bounds_ = Box(bounds_.min() - more, bounds_.max() + more);
  }
}

volume::Label LabelMapField::LabelAt(const Vector3d& p) const {
  const Vector3d index = index_from_ct_ * p;
  const auto i = static_cast<int>(std::floor(index.x() + 0.5));
  const auto j = static_cast<int>(std::floor(index.y() + 0.5));
  const auto k = static_cast<int>(std::floor(index.z() + 0.5));
  return labels_.geometry.Contains(i, j, k) ? labels_.At(i, j, k) : volume::Label{0};
}

bool LabelMapField::IsCut(const Vector3d& p) const {
  if (RadiusMm(labels_.geometry, index_from_ct_ * p) > cut_radius_mm_ - kCutMarginMm) return true;
  static const volume::Label kCut = volume::LabelOf("cut");
  if (!labels_.names.contains(kCut)) return false;
  constexpr double kStepMm = 1.5;  // The layer is 2 mm thick.
  for (double x = -kCutMarginMm; x <= kCutMarginMm; x += kStepMm) {
    for (double y = -kCutMarginMm; y <= kCutMarginMm; y += kStepMm) {
      for (double z = -kCutMarginMm; z <= kCutMarginMm; z += kStepMm) {
        if (LabelAt(p + Vector3d(x, y, z)) == kCut) return true;
      }
    }
  }
  return false;
}

double LabelMapField::BodyAt(const Vector3d& p) const {
  const Eigen::Array3d last = (labels_.geometry.size - 1).cast<double>();
  const Eigen::Array3d unbounded = (index_from_ct_ * p).array();
  const Eigen::Array3d index = unbounded.max(0.0).min(last);
  if (beyond_ == Beyond::kAir && (unbounded - index).abs().maxCoeff() > 0.5) return 0.0;
  const Eigen::Array3i low = index.floor().cast<int>().min((labels_.geometry.size - 2).max(0));
  const Eigen::Array3d t = index - low.cast<double>();
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    Eigen::Array3i at = low;
    for (int axis = 0; axis < 3; ++axis) {
      const bool up = (corner >> axis & 1) != 0;
      weight *= up ? t[axis] : 1.0 - t[axis];
      at[axis] += up ? 1 : 0;
    }
    if (weight > 0.0 && labels_.At(at[0], at[1], at[2]) != 0) sum += weight;
  }
  return sum;
}

double LabelMapField::SkinDistanceMm(const Vector3d& p) const {
  const Stencil& stencil = SkinStencil();
  double body = 0.0;
  for (std::size_t n = 0; n < stencil.weight.size(); ++n) {
    body += stencil.weight[n] * BodyAt(p + stencil.offset_mm[n]);
  }
  // Across a flat skin the smoothed body falls by 1 / (sigma sqrt(2 pi)) per mm.
  return (0.5 - body) * kSkinSigmaMm * std::sqrt(2.0 * std::numbers::pi);
}

std::optional<Vector3d> SkinAlong(const PatientField& field, const Vector3d& start,
                                  const Vector3d& direction, double reach_mm) {
  constexpr double kStepMm = 1.0;
  const auto outside = [&](double s) { return field.SkinDistanceMm(start + s * direction) > 0.0; };
  const int steps = static_cast<int>(std::ceil(reach_mm / kStepMm));
  for (int n = 0; n < steps; ++n) {
    for (const double low : {n * kStepMm, -(n + 1) * kStepMm}) {
      if (outside(low) || !outside(low + kStepMm)) continue;
      double in = low;
      double out = low + kStepMm;
      for (int i = 0; i < 24; ++i) (outside(0.5 * (in + out)) ? out : in) = 0.5 * (in + out);
      return start + out * direction;
    }
  }
  return std::nullopt;
}

Vector3d SkinNormal(const PatientField& field, const Vector3d& point_ct_mm) {
  constexpr double kStepMm = 2.0;
  Vector3d gradient = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step = kStepMm * Vector3d::Unit(axis);
    gradient[axis] =
        field.SkinDistanceMm(point_ct_mm + step) - field.SkinDistanceMm(point_ct_mm - step);
  }
  if (gradient.norm() < 1e-9) return Vector3d::UnitY();
  const Vector3d local = gradient.normalized();
  // Across voxels the gradient leans with every stair: a plane through skin further away does not.
  constexpr double kPatchMm = 10.0;
  const Vector3d u = local.unitOrthogonal();
  const Vector3d v = local.cross(u);
  std::array<Vector3d, 4> around;
  for (int side = 0; side < 4; ++side) {
    const Vector3d out = (side < 2 ? 1.0 : -1.0) * (side % 2 == 0 ? u : v);
    const auto skin = SkinAlong(field, point_ct_mm + kPatchMm * out, local, kPatchMm);
    if (!skin) return local;
    around[side] = *skin;
  }
  return (around[0] - around[2]).cross(around[1] - around[3]).normalized();
}

}  // namespace acus::phantom
