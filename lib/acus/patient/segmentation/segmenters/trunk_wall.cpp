#include "acus/patient/segmentation/segmenters/trunk_wall.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/parallel.h"
#include "acus/base/math/statistics.h"
#include "acus/data/volume/labels.h"

namespace acus::segmentation {
namespace {

using volume::Label;

constexpr double kGridMm = TrunkWall::kGridMm;
constexpr double kStepMm = 1.5;  // Along a ray.
constexpr int kAngles = 96;
constexpr double kWallUnderFatMm = 12.0;

/// The labels on a grid along the axes of CT space.
volume::Grid<Label> Coarse(const volume::LabelMap& labels) {
  Eigen::AlignedBox3d box;
  const Eigen::Affine3d ct_from_index = labels.geometry.ct_from_index();
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d index((corner & 1) != 0 ? labels.geometry.size[0] - 1 : 0,
                                (corner & 2) != 0 ? labels.geometry.size[1] - 1 : 0,
                                (corner & 4) != 0 ? labels.geometry.size[2] - 1 : 0);
    box.extend(ct_from_index * index);
  }
  volume::Geometry g;
  g.spacing_mm = Eigen::Array3d::Constant(kGridMm);
  g.origin_mm = box.min();
  g.size = (box.sizes().array() / kGridMm).floor().cast<int>() + 1;
  volume::Grid<Label> out(g);
  const Eigen::Affine3d index_from_ct = labels.geometry.index_from_ct();
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = g.origin_mm + kGridMm * Eigen::Vector3d(i, j, k);
        const Eigen::Array3i n = (index_from_ct * p).array().round().cast<int>();
        if (labels.geometry.Contains(n[0], n[1], n[2]))
          out.At(i, j, k) = labels.At(n[0], n[1], n[2]);
      }
    }
  }
  return out;
}

struct WallKinds {
  Label bone = volume::LabelOf("bone");
  Label lung = volume::LabelOf("lung");
  Label fat = volume::LabelOf("fat");
  Label skin = volume::LabelOf("skin");
};

TrunkSlice LookAt(const volume::Grid<Label>& labels, int k, const WallKinds& kinds) {
  const volume::Geometry& g = labels.geometry;
  TrunkSlice slice;
  double count = 0.0, sum_x = 0.0, sum_y = 0.0;
  int front = g.size[1];
  for (int j = 0; j < g.size[1]; ++j) {
    for (int i = 0; i < g.size[0]; ++i) {
      if (labels.At(i, j, k) == 0) continue;
      count += 1.0;
      sum_x += i;
      sum_y += j;
      front = std::min(front, j);
    }
  }
  if (count < 400.0) return slice;
  slice.body = true;
  slice.middle_x = sum_x / count;
  slice.front_y = front;
  std::vector<double> bone_y;
  for (int j = std::max(0, static_cast<int>(sum_y / count) - 8); j < g.size[1]; ++j) {
    for (int i = 0; i < g.size[0]; ++i) {
      if (labels.At(i, j, k) == kinds.bone && std::abs(i - slice.middle_x) * kGridMm < 35.0) {
        bone_y.push_back(j);
      }
    }
  }
  slice.spine = bone_y.size() > 20;
  if (slice.spine) slice.spine_y = math::Quantile(bone_y, 0.03);
  return slice;
}

/// All slices, with the spine's front smoothed along the body; none without a spine.
std::vector<TrunkSlice> LookAlong(const volume::Grid<Label>& labels, const WallKinds& kinds) {
  std::vector<TrunkSlice> slices;
  for (int k = 0; k < labels.geometry.size[2]; ++k) slices.push_back(LookAt(labels, k, kinds));
  const std::vector<TrunkSlice> found = slices;
  const int count = static_cast<int>(found.size());
  for (int k = 0; k < count; ++k) {
    std::vector<double> spine, middle;
    for (int reach = 10; spine.empty() && reach <= count; reach *= 2) {
      for (int n = std::max(0, k - reach); n <= std::min(count - 1, k + reach); ++n) {
        const TrunkSlice& other = found[static_cast<std::size_t>(n)];
        if (other.body && other.spine) spine.push_back(other.spine_y);
        if (other.body) middle.push_back(other.middle_x);
      }
    }
    if (spine.empty()) return {};
    TrunkSlice& slice = slices[static_cast<std::size_t>(k)];
    slice.spine_y = math::Quantile(spine, 0.5);
    slice.middle_x = math::Quantile(middle, 0.5);
    // Behind the spine of its neighbours lies no trunk: an arm, or a head that bends back.
    slice.body = slice.body && slice.front_y < slice.spine_y;
  }
  return slices;
}

/// Distance of the wall from the middle, mm, with how sure it is.
struct WallSample {
  double radius_mm = 0.0;
  double weight = 0.0;
};

/// Labels along a ray, at multiples of kStepMm, up to the skin.
std::vector<Label> Ray(const volume::Grid<Label>& labels, const Eigen::Vector2d& centre, int k,
                       const Eigen::Vector2d& direction) {
  std::vector<Label> out;
  for (double r = 0.0;; r += kStepMm) {
    const Eigen::Array2i n = (centre + r / kGridMm * direction).array().round().cast<int>();
    if (!labels.geometry.Contains(n[0], n[1], k) || labels.At(n[0], n[1], k) == 0) return out;
    out.push_back(labels.At(n[0], n[1], k));
  }
}

WallSample WallAlong(const std::vector<Label>& ray, bool to_front, double spine_mm,
                     const WallKinds& kinds) {
  const auto count = static_cast<int>(ray.size());
  const auto is = [&](int n, Label label) { return ray[static_cast<std::size_t>(n)] == label; };
  // Bone near the middle is calcified or contrasted vessel.
  const int nearest = static_cast<int>(std::min(0.4 * count, 0.7 * spine_mm / kStepMm));
  int bone = count;
  for (int n = count - 1; n >= nearest; --n) {
    if (is(n, kinds.bone)) bone = n;
  }
  int muscle =
      count;  // Its outer surface: the first six millimetres that are neither skin nor fat.
  for (int n = count - 1, run = 0; n >= 0 && run < 4; --n) {
    run = is(n, kinds.skin) || is(n, kinds.fat) ? 0 : run + 1;
    if (run == 4) muscle = n + 3;
  }
  int lung = -1;
  for (int n = 0; n < std::min(bone, count); ++n) {
    if (is(n, kinds.lung)) lung = n;
  }
  const int limit = std::min(bone, muscle);
  if (lung >= 0 && limit - lung <= 14) return {(lung + 1) * kStepMm, 1.0};
  if (bone < count) return {bone * kStepMm - 3.0, 1.0};
  if (to_front) return {std::max(muscle * kStepMm - kWallUnderFatMm, 20.0), 0.03};
  return {};
}

/// wall[k * kAngles + a], smoothed and without gaps.
std::vector<double> WallRadii(const std::vector<WallSample>& samples, int num_slices) {
  std::vector<double> out(samples.size());
  for (int k = 0; k < num_slices; ++k) {
    for (int a = 0; a < kAngles; ++a) {
      double sum = 0.0, weight = 0.0;
      for (int reach = 1; weight < 0.02 && reach <= 8; reach *= 2) {
        sum = weight = 0.0;
        const int dk_max = 9 * reach;
        const int da_max = 3 * reach;
        for (int dk = -dk_max; dk <= dk_max; ++dk) {
          if (k + dk < 0 || k + dk >= num_slices) continue;
          for (int da = -da_max; da <= da_max; ++da) {
            const int angle = (a + da + kAngles) % kAngles;
            const WallSample& s = samples[static_cast<std::size_t>((k + dk) * kAngles + angle)];
            if (s.weight == 0.0) continue;
            const double u = 3.0 * dk / dk_max, v = 3.0 * da / da_max;
            const double w = s.weight * std::exp(-0.5 * (u * u + v * v));
            sum += w * s.radius_mm;
            weight += w;
          }
        }
      }
      out[static_cast<std::size_t>(k * kAngles + a)] = weight > 0.0 ? sum / weight : 60.0;
    }
  }
  return out;
}

Eigen::Vector2d Centre(const TrunkSlice& slice) {
  return {slice.middle_x, slice.spine_y - 0.3 * (slice.spine_y - slice.front_y)};
}

Mask WithinWall(const volume::Grid<Label>& labels, const std::vector<TrunkSlice>& slices,
                const WallKinds& kinds, int num_threads) {
  const volume::Geometry& g = labels.geometry;
  std::vector<WallSample> samples(static_cast<std::size_t>(g.size[2] * kAngles));
  ParallelFor(g.size[2], num_threads, [&](int k) {
    const TrunkSlice& slice = slices[static_cast<std::size_t>(k)];
    if (!slice.body) return;
    const double spine_mm = 0.3 * (slice.spine_y - slice.front_y) * kGridMm;
    for (int a = 0; a < kAngles; ++a) {
      const double angle = 2.0 * std::numbers::pi * a / kAngles;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      samples[static_cast<std::size_t>(k * kAngles + a)] =
          WallAlong(Ray(labels, Centre(slice), k, direction), direction.y() < 0.3, spine_mm, kinds);
    }
  });
  const std::vector<double> radii = WallRadii(samples, g.size[2]);
  Mask inside(g);
  ParallelFor(g.size[2], num_threads, [&](int k) {
    const TrunkSlice& slice = slices[static_cast<std::size_t>(k)];
    if (!slice.body) return;
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (labels.At(i, j, k) == 0) continue;
        const Eigen::Vector2d from = Eigen::Vector2d(i, j) - Centre(slice);
        const double turn = std::atan2(from.y(), from.x()) / (2.0 * std::numbers::pi) * kAngles;
        const double place = turn < 0.0 ? turn + kAngles : turn;
        const int a = static_cast<int>(place) % kAngles;
        const double t = place - std::floor(place);
        const auto row = static_cast<std::size_t>(k * kAngles);
        const double wall = (1.0 - t) * radii[row + static_cast<std::size_t>(a)] +
                            t * radii[row + static_cast<std::size_t>((a + 1) % kAngles)];
        if (from.norm() * kGridMm < wall) inside.At(i, j, k) = 1;
      }
    }
  });
  return inside;
}

}  // namespace

std::optional<TrunkWall> FindTrunkWall(const volume::LabelMap& labels, int num_threads) {
  const WallKinds kinds;
  TrunkWall wall{.labels = Coarse(labels), .slices = {}, .inside = {}};
  wall.slices = LookAlong(wall.labels, kinds);
  if (wall.slices.empty()) return std::nullopt;
  wall.inside = WithinWall(wall.labels, wall.slices, kinds, num_threads);
  return wall;
}

}  // namespace acus::segmentation
