#include "acus/patient/registration/surface_warp.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/base/math/statistics.h"
#include "acus/data/mesh/nearest_triangle.h"
#include "acus/data/volume/labels.h"

namespace acus::registration {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr double kFacing = 0.3;       ///< Cosine between normals that still belong together.
constexpr double kEndMm = 6.0;        ///< The skin's cut edge at the CT's ends.
constexpr double kLungModulus = 0.3;  ///< Of soft tissue.

void Check(const WarpSettings& s, const MannequinSkin& mannequin) {
  ACUS_REQUIRE(mannequin.points_mm.cols() >= 100,
               "a warp needs at least 100 points of the mannequin, got ",
               mannequin.points_mm.cols());
  ACUS_REQUIRE(mannequin.points_mm.allFinite(), "a point of the mannequin is not finite");
  ACUS_REQUIRE(s.lattice_mm >= 2.0 && s.lattice_mm <= 50.0, "the lattice must be 2 to 50 mm, got ",
               s.lattice_mm);
  ACUS_REQUIRE(s.reach_mm > 0.0 && s.compliance_mm > 0.0,
               "reach and compliance must be above 0 mm");
  ACUS_REQUIRE(s.bone_modulus >= 1.0 && s.bone_modulus <= 1e5,
               "bone must be 1 to 100,000 times as stiff as soft tissue, got ", s.bone_modulus);
  ACUS_REQUIRE(s.air_modulus > 0.0 && s.air_modulus <= 1.0,
               "air must have a stiffness in (0, 1] of soft tissue, got ", s.air_modulus);
  ACUS_REQUIRE(s.num_rounds >= 1 && s.num_rounds <= 100 && s.most_points >= 100,
               "1 to 100 rounds and at least 100 points are needed");
  ACUS_REQUIRE(s.smallest_volume >= 0.0 && s.smallest_volume < 1.0,
               "the smallest volume must lie in [0, 1), got ", s.smallest_volume);
}

/// Labels by place in CT space.
class Tissues {
 public:
  explicit Tissues(const volume::LabelMap& labels)
      : labels_(labels),
        index_from_ct_(labels.geometry.index_from_ct()),
        bone_(volume::LabelOf("bone")),
        lung_(volume::LabelOf("lung")),
        gas_(volume::LabelOf("gas")) {}

  volume::Label At(const Vector3d& ct_mm) const {
    const Eigen::Array3i at = (index_from_ct_ * ct_mm).array().round().cast<int>();
    return labels_.geometry.Contains(at[0], at[1], at[2]) ? labels_.At(at[0], at[1], at[2])
                                                          : volume::Label{0};
  }
  bool IsBone(const Vector3d& ct_mm) const { return At(ct_mm) == bone_; }
  bool IsBody(const Vector3d& ct_mm) const { return At(ct_mm) != 0; }

  double Modulus(const Vector3d& ct_mm, const WarpSettings& settings) const {
    const volume::Label label = At(ct_mm);
    if (label == 0 || label == gas_) return settings.air_modulus;
    if (label == bone_) return settings.bone_modulus;
    return label == lung_ ? kLungModulus : 1.0;
  }

  /// Distance from the nearest end of the volume, mm; negative outside.
  double FromEndsMm(const Vector3d& ct_mm) const {
    const Eigen::Array3d at = (index_from_ct_ * ct_mm).array();
    const Eigen::Array3d last = labels_.geometry.size.cast<double>() - 1.0;
    return (at.min(last - at) * labels_.geometry.spacing_mm).minCoeff();
  }

 private:
  const volume::LabelMap& labels_;
  Eigen::Affine3d index_from_ct_;
  volume::Label bone_, lung_, gas_;
};

Eigen::AlignedBox3d BoxOf(const volume::Geometry& geometry) {
  Eigen::AlignedBox3d box;
  for (int c = 0; c < 8; ++c) {
    const Vector3d corner((c & 1) * (geometry.size[0] - 1.0),
                          ((c >> 1) & 1) * (geometry.size[1] - 1.0),
                          ((c >> 2) & 1) * (geometry.size[2] - 1.0));
    box.extend(Vector3d(geometry.ct_from_index() * corner));
  }
  return box;
}

MannequinSkin Thinned(const MannequinSkin& all, Index most) {
  const Index step = std::max<Index>(1, (all.points_mm.cols() + most - 1) / most);
  const Index count = (all.points_mm.cols() + step - 1) / step;
  MannequinSkin few;
  few.points_mm.resize(3, count);
  few.normals.resize(3, all.normals.cols() > 0 ? count : 0);
  for (Index i = 0; i < count; ++i) {
    few.points_mm.col(i) = all.points_mm.col(i * step);
    if (few.normals.cols() > 0) few.normals.col(i) = all.normals.col(i * step);
  }
  return few;
}

/// A mannequin point and where it meets the CT's skin.
struct Pair {
  bool counts = false;
  Vector3d rest_mm = Vector3d::Zero();    ///< On the skin, before the warp.
  Vector3d direction = Vector3d::Zero();  ///< Normal of the warped skin.
  double gap_mm = 0.0;                    ///< From the warped skin to the point, along it.
  double pull_mm = 0.0;                   ///< From the place at rest.
};

mesh::Surface Warped(const mesh::Surface& skin, const LatticeField& field) {
  mesh::Surface warped = skin;
  for (Index i = 0; i < skin.nodes_mm.cols(); ++i) {
    warped.nodes_mm.col(i) += field.At(skin.nodes_mm.col(i));
  }
  return warped;
}

std::vector<Pair> Match(const mesh::Surface& skin, const MannequinSkin& mannequin,
                        const LatticeField& field, const Tissues& tissues, double reach_mm,
                        int num_threads) {
  const mesh::NearestTriangle nearest(Warped(skin, field));
  std::vector<Pair> pairs(static_cast<std::size_t>(mannequin.points_mm.cols()));
  constexpr int kChunk = 100;
  const int chunks = static_cast<int>((pairs.size() + kChunk - 1) / kChunk);
  ParallelFor(chunks, num_threads, [&](int chunk) {
    const std::size_t begin = static_cast<std::size_t>(chunk) * kChunk;
    for (std::size_t i = begin; i < std::min(pairs.size(), begin + kChunk); ++i) {
      const auto column = static_cast<Index>(i);
      const Vector3d q_mm = mannequin.points_mm.col(column);
      const mesh::NearestPoint found = nearest.Find(q_mm);
      Pair& pair = pairs[i];
      for (int k = 0; k < 3; ++k) {
        pair.rest_mm += found.weights[k] * skin.nodes_mm.col(skin.triangles(k, found.triangle));
      }
      pair.direction = nearest.Normal(found.triangle);
      pair.gap_mm = pair.direction.dot(q_mm - found.point_mm);
      pair.pull_mm = pair.direction.dot(q_mm - pair.rest_mm);
      const bool faces = mannequin.normals.cols() == 0 ||
                         mannequin.normals.col(column).dot(pair.direction) > kFacing;
      // A point beyond an edge of the skin is off its normal: it belongs to what the CT lacks.
      const double aside2 = std::max(0.0, found.squared_mm2 - pair.gap_mm * pair.gap_mm);
      pair.counts = faces && found.squared_mm2 <= reach_mm * reach_mm &&
                    aside2 <= std::max(4.0, 0.25 * found.squared_mm2) &&
                    tissues.FromEndsMm(pair.rest_mm) > kEndMm && pair.direction.norm() > 0.5;
    }
  });
  return pairs;
}

/// Points that stay far off when the others have arrived are not of this skin.
void DropStray(std::vector<Pair>& pairs) {
  std::vector<double> gaps_mm;
  for (const Pair& pair : pairs) {
    if (pair.counts) gaps_mm.push_back(std::abs(pair.gap_mm));
  }
  if (gaps_mm.empty()) return;
  const double limit_mm = std::max(3.0, 6.0 * math::Median(gaps_mm));
  for (Pair& pair : pairs) pair.counts = pair.counts && std::abs(pair.gap_mm) <= limit_mm;
}

double SkinAreaMm2(const mesh::Surface& skin) {
  double area = 0.0;
  for (Index t = 0; t < skin.triangles.cols(); ++t) {
    const Vector3d a = skin.nodes_mm.col(skin.triangles(0, t));
    area += 0.5 * Vector3d(skin.nodes_mm.col(skin.triangles(1, t)) - a)
                      .cross(Vector3d(skin.nodes_mm.col(skin.triangles(2, t)) - a))
                      .norm();
  }
  return area;
}

std::vector<Spring> Springs(const std::vector<Pair>& pairs, double stiffness) {
  std::vector<Spring> springs;
  for (const Pair& pair : pairs) {
    if (!pair.counts) continue;
    springs.push_back({.rest_mm = pair.rest_mm,
                       .direction = pair.direction,
                       .pull_mm = pair.pull_mm,
                       .stiffness = stiffness});
  }
  return springs;
}

std::vector<double> Gaps(const std::vector<Pair>& pairs) {
  std::vector<double> gaps_mm;
  for (const Pair& pair : pairs) {
    if (pair.counts) gaps_mm.push_back(std::abs(pair.gap_mm));
  }
  return gaps_mm;
}

/// Jacobians within the body, displacement, and how rigid bone stayed.
void MeasureInside(const LatticeField& field, const Tissues& tissues, WarpQuality& quality) {
  std::vector<Vector3d> bone_mm, moved_mm;
  std::vector<double> strains;
  const Eigen::Array3i& size = field.size();
  for (int k = 0; k + 1 < size[2]; ++k) {
    for (int j = 0; j + 1 < size[1]; ++j) {
      for (int i = 0; i + 1 < size[0]; ++i) {
        for (int c = 0; c < 8; ++c) {
          const Vector3d share(0.2 + 0.6 * (c & 1), 0.2 + 0.6 * ((c >> 1) & 1),
                               0.2 + 0.6 * ((c >> 2) & 1));
          const Vector3d place_mm = field.PlaceMm(i, j, k) + field.spacing_mm() * share;
          if (!tissues.IsBody(place_mm)) continue;
          const Matrix3d gradient = field.GradientAt(place_mm);
          const double volume = gradient.determinant();
          quality.smallest_volume = std::min(quality.smallest_volume, volume);
          quality.largest_volume = std::max(quality.largest_volume, volume);
          const Vector3d u_mm = field.At(place_mm);
          quality.largest_mm = std::max(quality.largest_mm, u_mm.norm());
          if (!tissues.IsBone(place_mm)) continue;
          bone_mm.push_back(place_mm);
          moved_mm.push_back(place_mm + u_mm);
          const Matrix3d strain = 0.5 * (gradient.transpose() * gradient - Matrix3d::Identity());
          strains.push_back(Eigen::SelfAdjointEigenSolver<Matrix3d>(strain, Eigen::EigenvaluesOnly)
                                .eigenvalues()
                                .cwiseAbs()
                                .maxCoeff());
        }
      }
    }
  }
  if (bone_mm.size() < 10) return;
  const Eigen::Map<const Matrix3Xd> from(bone_mm.front().data(), 3,
                                         static_cast<Index>(bone_mm.size()));
  const Eigen::Map<const Matrix3Xd> to(moved_mm.front().data(), 3,
                                       static_cast<Index>(bone_mm.size()));
  Isometry3d rigid;
  rigid.matrix() = Eigen::umeyama(from, to, false);
  const Matrix3Xd off_mm = to - rigid * Matrix3Xd(from);
  quality.bone_rms_mm = std::sqrt(off_mm.squaredNorm() / static_cast<double>(off_mm.cols()));
  quality.bone_strain = math::Quantile(strains, 0.95);
}

void Assess(const std::vector<Pair>& last, const WarpSettings& settings, WarpQuality& quality) {
  const auto gaps_mm = Gaps(last);
  quality.num_points = static_cast<Index>(gaps_mm.size());
  quality.num_left_out = static_cast<Index>(last.size() - gaps_mm.size());
  quality.after_rms_mm = math::RootMeanSquare(gaps_mm);
  quality.after_p95_mm = math::Quantile(gaps_mm, 0.95);
  quality.after_largest_mm = *std::ranges::max_element(gaps_mm);
  if (quality.smallest_volume < settings.smallest_volume) {
    throw NoAnswerError(Message("the warp squeezes tissue to ", quality.smallest_volume,
                                " of its volume (allowed: ", settings.smallest_volume,
                                "): it folds. The mannequin is too different from the patient, or "
                                "badly registered; register it better, take a smaller reach, or "
                                "softer bone (now ",
                                settings.bone_modulus, " times soft tissue)"));
  }
}

}  // namespace

MannequinSkin PointsOf(const mesh::Surface& mannequin, const Isometry3d& ct_from_reference) {
  const mesh::NearestTriangle triangles(mannequin);
  MannequinSkin skin;
  skin.points_mm.resize(3, mannequin.triangles.cols());
  skin.normals.resize(3, mannequin.triangles.cols());
  for (Index t = 0; t < mannequin.triangles.cols(); ++t) {
    Vector3d centre_mm = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      centre_mm += mannequin.nodes_mm.col(mannequin.triangles(k, t)) / 3.0;
    skin.points_mm.col(t) = ct_from_reference * centre_mm;
    skin.normals.col(t) = ct_from_reference.linear() * triangles.Normal(static_cast<int>(t));
  }
  return skin;
}

SurfaceWarp WarpToMannequin(const volume::LabelMap& labels, const mesh::Surface& skin,
                            const MannequinSkin& mannequin, const WarpSettings& settings,
                            const RunContext& context) {
  Check(settings, mannequin);
  const MannequinSkin points = Thinned(mannequin, settings.most_points);
  const Tissues tissues(labels);
  Eigen::AlignedBox3d box = BoxOf(labels.geometry);
  box.extend(Vector3d(box.min() - Vector3d::Constant(settings.lattice_mm)));
  box.extend(Vector3d(box.max() + Vector3d::Constant(settings.lattice_mm)));
  SurfaceWarp warp;
  warp.field = LatticeField(box, settings.lattice_mm);
  const ElasticLattice body(
      warp.field, [&](const Vector3d& x_mm) { return tissues.Modulus(x_mm, settings); },
      context.num_threads);
  const double area_mm2 = SkinAreaMm2(skin);
  std::vector<Pair> pairs;
  for (int round = 0; round <= settings.num_rounds; ++round) {
    context.Checkpoint("warping", static_cast<double>(round) / (settings.num_rounds + 1));
    pairs = Match(skin, points, warp.field, tissues, settings.reach_mm, context.num_threads);
    if (2 * round > settings.num_rounds) DropStray(pairs);
    const auto gaps_mm = Gaps(pairs);
    if (4 * gaps_mm.size() < pairs.size() || gaps_mm.size() < 50) {
      throw NoAnswerError(Message("only ", gaps_mm.size(), " of ", pairs.size(),
                                  " points of the mannequin lie within ", settings.reach_mm,
                                  " mm of the CT's skin and face it; is the registration right?"));
    }
    if (round == 0) warp.quality.before_rms_mm = math::RootMeanSquare(gaps_mm);
    if (round == settings.num_rounds) break;
    // Softer first: the nearest points are still wrong.
    const double softness = round < settings.num_rounds / 2
                                ? std::pow(4.0, 1.0 - 2.0 * round / settings.num_rounds)
                                : 1.0;
    const double stiffness =
        area_mm2 / static_cast<double>(gaps_mm.size()) / (settings.compliance_mm * softness);
    body.Solve(Springs(pairs, stiffness), warp.field, context.num_threads);
  }
  MeasureInside(warp.field, tissues, warp.quality);
  Assess(pairs, settings, warp.quality);
  context.Checkpoint("warping", 1.0);
  return warp;
}

}  // namespace acus::registration
