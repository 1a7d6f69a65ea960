#include "acus/patient/phantom/breath/breathing_scan.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/base/core/random.h"
#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kBeyondWallMm = 8.0;  // Nodes there serve points within.
constexpr double kSteepest = 2.0;      // Level over half a cell's diagonal (0.87), with a margin.
constexpr double kLungBelowHu = -300.0;

/// What the flow brings to each place of the cavity: where it came from, and by how much it grew.
class BackwardFlow {
 public:
  BackwardFlow(const BreathingMotion& motion, const breathing::Breath& breath,
               const Eigen::AlignedBox3d& box, double node_mm, int num_threads)
      : node_mm_(node_mm) {
    grid_.spacing_mm = Eigen::Array3d::Constant(node_mm_);
    grid_.origin_mm = box.min();
    grid_.size = (box.sizes().array() / node_mm_).ceil().cast<int>() + 1;
    shift_.assign(grid_.num_voxels(), Vector3f::Zero());
    wall_mm_.assign(grid_.num_voxels(), 0.0F);
    ParallelFor(grid_.size[2], num_threads, [&](int k) {
      for (int j = 0; j < grid_.size[1]; ++j) {
        for (int i = 0; i < grid_.size[0]; ++i) {
          const Vector3d p = grid_.origin_mm + node_mm_ * Vector3d(i, j, k);
          const double wall_mm = motion.cavity().wall.LevelMm(p);
          wall_mm_[grid_.Index(i, j, k)] = static_cast<float>(wall_mm);
          if (wall_mm > kBeyondWallMm) continue;
          shift_[grid_.Index(i, j, k)] = (motion.BeforeSlidingMm(p, breath) - p).cast<float>();
        }
      }
    });
  }

  /// Distance to the wall of a node that is at most half a cell away along each axis.
  double NearbyWallMm(const Vector3d& p) const {
    const Eigen::Array3i n = ((p - grid_.origin_mm).array() / node_mm_ + 0.5).cast<int>();
    const Eigen::Array3i at = n.max(0).min(grid_.size - 1);
    return static_cast<double>(wall_mm_[grid_.Index(at[0], at[1], at[2])]);
  }
  /// Where the level of a node has this size, all of its surroundings are on its side.
  double ClearMm() const { return kSteepest * node_mm_; }

  /// Value and, over a cell, determinant of the gradient of the map.
  Vector3d RestMm(const Vector3d& p, double& thinning) const {
    const Eigen::Array3d index =
        ((p - grid_.origin_mm).array() / node_mm_).max(0.0).min((grid_.size - 1).cast<double>());
    const Eigen::Array3i base = index.cast<int>().min(grid_.size - 2);
    const Eigen::Array3f t = (index - base.cast<double>()).cast<float>();
    std::array<Vector3f, 8> corner;
    for (int n = 0; n < 8; ++n) {
      corner[static_cast<std::size_t>(n)] =
          shift_[grid_.Index(base[0] + (n & 1), base[1] + ((n >> 1) & 1), base[2] + (n >> 2))];
    }
    const auto mixed = [](float s, const Vector3f& a, const Vector3f& b) -> Vector3f {
      return (1.0F - s) * a + s * b;
    };
    const Vector3f x00 = mixed(t[0], corner[0], corner[1]), x10 = mixed(t[0], corner[2], corner[3]);
    const Vector3f x01 = mixed(t[0], corner[4], corner[5]), x11 = mixed(t[0], corner[6], corner[7]);
    const Vector3f y0 = mixed(t[1], x00, x10), y1 = mixed(t[1], x01, x11);
    Eigen::Matrix3f gradient;
    gradient.col(0) = 0.25F * (corner[1] - corner[0] + corner[3] - corner[2] + corner[5] -
                               corner[4] + corner[7] - corner[6]);
    gradient.col(1) = 0.5F * (x10 - x00 + x11 - x01);
    gradient.col(2) = y1 - y0;
    gradient /= static_cast<float>(node_mm_);
    gradient += Eigen::Matrix3f::Identity();
    const auto& g = gradient;
    thinning = static_cast<double>(g.col(0).cross(g.col(1)).dot(g.col(2)));
    return p + mixed(t[2], y0, y1).cast<double>();
  }

 private:
  double node_mm_;
  volume::Geometry grid_;
  std::vector<Vector3f> shift_;
  std::vector<float> wall_mm_;
};

double HuAt(const volume::CtVolume& ct, const Vector3d& index) {
  const Eigen::Array3i& size = ct.geometry.size;
  const Eigen::Array3d last = (size - 1).cast<double>();
  // Beyond the border as in a mirror: an extended border would make stripes, which look as if
  // nothing had moved.
  const Eigen::Array3d at = (last - (last - index.array().abs()).abs()).max(0.0);
  const Eigen::Array3i base = at.cast<int>().min(size - 2).max(0);
  const Eigen::Array3d t = at - base.cast<double>();
  double sum = 0.0;
  for (int n = 0; n < 8; ++n) {
    const int a = n & 1, b = (n >> 1) & 1, c = n >> 2;
    const double weight =
        (a != 0 ? t[0] : 1.0 - t[0]) * (b != 0 ? t[1] : 1.0 - t[1]) * (c != 0 ? t[2] : 1.0 - t[2]);
    sum += weight * ct.At(std::min(base[0] + a, size[0] - 1), std::min(base[1] + b, size[1] - 1),
                          std::min(base[2] + c, size[2] - 1));
  }
  return sum;
}

Eigen::AlignedBox3d BoxOf(const volume::Geometry& geometry) {
  Eigen::AlignedBox3d box;
  const Eigen::Affine3d ct_from_index = geometry.ct_from_index();
  for (int n = 0; n < 8; ++n) {
    box.extend(ct_from_index * Vector3d((n & 1) != 0 ? geometry.size[0] - 1 : 0,
                                        (n & 2) != 0 ? geometry.size[1] - 1 : 0,
                                        (n & 4) != 0 ? geometry.size[2] - 1 : 0));
  }
  return box;
}

/// Liver where it is labelled; otherwise soft tissue under the right dome.
bool IsLiver(const volume::LabelMap& labels, std::size_t voxel, bool has_liver, const Vector3d& p,
             const Cavity& cavity) {
  static const volume::Label liver = volume::LabelOf("liver");
  static const volume::Label soft = volume::LabelOf("soft_tissue");
  if (has_liver) return labels.voxels[voxel] == liver;
  const double below = cavity.dome_z_mm - p.z();
  return labels.voxels[voxel] == soft && below > 10.0 && below < 120.0 &&
         cavity.middle_x_mm - p.x() > 25.0 && cavity.wall.LevelMm(p) < 0.0;
}

}  // namespace

volume::CtVolume ScanAt(const volume::CtVolume& ct, const BreathingMotion& motion,
                        const breathing::Breath& breath, const BreathingScanSettings& settings,
                        const RunContext& context) {
  const double node_mm = std::clamp(0.8 * ct.geometry.spacing_mm.maxCoeff(), 2.0, 4.0);
  const BackwardFlow flow(motion, breath, BoxOf(ct.geometry), node_mm, context.num_threads);
  const Eigen::Affine3d ct_from_index = ct.geometry.ct_from_index();
  const Eigen::Affine3d index_from_ct = ct.geometry.index_from_ct();
  volume::CtVolume out(ct.geometry);
  ParallelFor(ct.geometry.size[2], context.num_threads, [&](int k) {
    RandomStream random(context.seed, Message("noise of phase ", settings.noise_index),
                        static_cast<std::uint64_t>(k));
    for (int j = 0; j < ct.geometry.size[1]; ++j) {
      for (int i = 0; i < ct.geometry.size[0]; ++i) {
        const Vector3d world = ct_from_index * Vector3d(i, j, k);
        const Vector3d slid = motion.BeforeChestMm(world, breath);
        Vector3d rest = slid;
        double thinning = 1.0;
        // The wall itself is only asked where it is near: it is the costly part of a voxel.
        const double wall_mm = flow.NearbyWallMm(rest);
        const bool in = std::abs(wall_mm) > flow.ClearMm() ? wall_mm < 0.0 : motion.InCavity(rest);
        if (in) rest = flow.RestMm(rest, thinning);
        double hu = HuAt(ct, index_from_ct * rest);
        if (hu < kLungBelowHu) {
          hu = -1000.0 + (hu + 1000.0) * thinning * motion.ChestThinning(slid, breath);
        }
        if (settings.noise_sd_hu > 0.0) hu += settings.noise_sd_hu * random.Normal();
        out.At(i, j, k) = static_cast<std::int16_t>(std::clamp(std::round(hu), -1024.0, 32767.0));
      }
    }
  });
  return out;
}

std::vector<float> DisplacementsOn(const volume::Geometry& nodes, const BreathingMotion& motion,
                                   const breathing::Breath& breath, int num_threads) {
  std::vector<float> out(3 * nodes.num_voxels());
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  ParallelFor(nodes.size[2], num_threads, [&](int k) {
    for (int j = 0; j < nodes.size[1]; ++j) {
      for (int i = 0; i < nodes.size[0]; ++i) {
        const Vector3d p = ct_from_index * Vector3d(i, j, k);
        const Vector3f u = (motion.WorldMm(p, breath) - p).cast<float>();
        std::ranges::copy(u, out.begin() + static_cast<std::ptrdiff_t>(3 * nodes.Index(i, j, k)));
      }
    }
  });
  return out;
}

std::vector<TissueLandmark> RandomLandmarks(const volume::LabelMap& labels,
                                            const BreathingMotion& motion,
                                            const breathing::Breath& breath, int count,
                                            const RunContext& context) {
  const volume::Label lung = volume::LabelOf("lung");
  const bool has_liver = std::ranges::count(labels.voxels, volume::LabelOf("liver")) > 1000;
  const Eigen::AlignedBox3d box = BoxOf(labels.geometry);
  const Eigen::Affine3d ct_from_index = labels.geometry.ct_from_index();
  RandomStream random(context.seed, "landmarks");
  std::vector<TissueLandmark> out;
  std::array<int, 2> found{};
  for (long tries = 0; tries < 4'000'000 && std::ssize(out) < count; ++tries) {
    Eigen::Array3i n;
    for (int axis = 0; axis < 3; ++axis) {
      n[axis] = static_cast<int>(random.Uniform(0.0, labels.geometry.size[axis]));
    }
    const std::size_t voxel = labels.geometry.Index(n[0], n[1], n[2]);
    const Vector3d p = ct_from_index * n.cast<double>().matrix();
    const bool in_lung = labels.voxels[voxel] == lung && motion.InCavity(p);
    if (!in_lung && !IsLiver(labels, voxel, has_liver, p, motion.cavity())) continue;
    const std::size_t kind = in_lung ? 0 : 1;
    if (found[kind] >= (count + static_cast<int>(kind)) / 2) continue;
    if (!box.contains(motion.WorldMm(p, breath))) continue;
    ++found[kind];
    const std::string tissue = in_lung ? "lung" : "liver";
    out.push_back({.name = tissue + "_" + std::to_string(found[kind]),
                   .tissue = tissue,
                   .rest_mm = p,
                   .wall_mm = std::abs(motion.cavity().wall.LevelMm(p))});
  }
  ACUS_REQUIRE(std::ssize(out) == count, "landmarks: only ", out.size(), " of ", count,
               " points are found in lung and liver; the volume holds too little of them");
  return out;
}

}  // namespace acus::phantom
