#include "acus/imaging/fluoroscopy/attenuation_volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"

namespace acus::fluoroscopy {
namespace {

/// Voxels of the CT per voxel along each axis.
Eigen::Array3i BoxOf(const volume::Geometry& geometry, int detail) {
  const double target_mm = detail * geometry.spacing_mm.minCoeff();
  return (target_mm / geometry.spacing_mm + 0.5).floor().cast<int>().max(1).min(geometry.size);
}

/// The axis of the CT along the beam, which becomes the last one.
int SliceAxis(const volume::Geometry& geometry, const Eigen::Vector3d& beam_in_ct) {
  int axis = 0;
  (geometry.direction.transpose() * beam_in_ct).cwiseAbs().maxCoeff(&axis);
  return axis;
}

}  // namespace

AttenuationVolume::AttenuationVolume(const volume::CtVolume& ct, int detail,
                                     const Eigen::Vector3d& beam_in_ct, int num_threads) {
  const volume::Geometry& g = ct.geometry;
  ACUS_REQUIRE((g.size > 0).all() && ct.voxels.size() == g.num_voxels(),
               "fluoroscopy: the CT is empty");
  const Eigen::Array3i box = BoxOf(g, detail);
  const int n_axis = SliceAxis(g, beam_in_ct);
  const int a_axis = n_axis == 0 ? 1 : 0;
  const int b_axis = n_axis == 2 ? 1 : 2;
  const Eigen::Array3i count = (g.size + box - 1) / box;
  size_ = {count[a_axis] + 2, count[b_axis] + 2, count[n_axis]};
  const double per_slice = static_cast<double>(size_[0]) * size_[1];
  ACUS_REQUIRE(per_slice < 1 << 29, "fluoroscopy: a slice of the CT has ", per_slice,
               " voxels; allowed is below 2^29. Take a higher detail number (2 or 4)");
  base_.assign(static_cast<std::size_t>(per_slice) * static_cast<std::size_t>(size_[2]), 0);

  // Box (i, j, k) has its middle at index box * i + (box - 1) / 2.
  Eigen::Affine3d permuted = Eigen::Affine3d::Identity();
  permuted.linear().setZero();
  const int axes[3] = {a_axis, b_axis, n_axis};
  for (int t = 0; t < 3; ++t) {
    const int axis = axes[t];
    permuted.linear()(t, axis) = 1.0 / box[axis];
    permuted.translation()[t] = -0.5 * (box[axis] - 1) / box[axis] + (t < 2 ? 1.0 : 0.0);
    voxel_mm_[t] = box[axis] * g.spacing_mm[axis];
  }
  slices_from_ct_ = permuted * g.index_from_ct();

  const std::int32_t in_box = box.prod();
  ParallelFor(size_[2], num_threads, [&](int n) {
    Eigen::Array3i first;
    first[n_axis] = n * box[n_axis];
    for (int b = 0; b < count[b_axis]; ++b) {
      first[b_axis] = b * box[b_axis];
      for (int a = 0; a < count[a_axis]; ++a) {
        first[a_axis] = a * box[a_axis];
        const Eigen::Array3i end = (first + box).min(g.size);
        std::int64_t sum = 0;  // What is beyond the edge of the CT is air: 0.
        for (int k = first[2]; k < end[2]; ++k) {
          for (int j = first[1]; j < end[1]; ++j) {
            const std::int16_t* row = ct.voxels.data() + g.Index(first[0], j, k);
            for (int i = 0; i < end[0] - first[0]; ++i) sum += std::max(0, row[i] + 1000);
          }
        }
        base_[Index(a + 1, b + 1, n)] =
            static_cast<std::int16_t>(std::min<std::int64_t>(32767, (sum + in_box / 2) / in_box));
      }
    }
  });
}

std::size_t AttenuationVolume::Index(int a, int b, int n) const {
  return (static_cast<std::size_t>(n) * static_cast<std::size_t>(size_[1]) +
          static_cast<std::size_t>(b)) *
             static_cast<std::size_t>(size_[0]) +
         static_cast<std::size_t>(a);
}

kernels::Slices AttenuationVolume::slices() const {
  return {.data = now_.empty() ? base_.data() : now_.data(),
          .last_a = static_cast<float>(size_[0] - 1),
          .last_b = static_cast<float>(size_[1] - 1),
          .row_bytes = static_cast<std::int32_t>(size_[0] * sizeof(std::int16_t)),
          .elements = static_cast<std::ptrdiff_t>(size_[0]) * size_[1]};
}

void AttenuationVolume::EvaluateKnots(const slicing::RestMap& rest, int num_threads) {
  const Eigen::Array3i block = (rest.SpacingMm() / voxel_mm_).floor().max(1.0).min(1e6).cast<int>();
  if ((block != block_).any()) {
    block_ = block;
    blocks_ = (size_ + block - 1) / block;
    const auto knots = static_cast<std::size_t>((blocks_ + 1).prod());
    offset_.assign(knots, Eigen::Vector3f::Zero());
    knot_moved_.assign(knots, 0);
    if (!now_.empty()) now_ = base_;
    block_moved_.assign(static_cast<std::size_t>(blocks_.prod()), 0);
  }
  const Eigen::Affine3d ct_from_slices = slices_from_ct_.inverse();
  ParallelFor(blocks_[2] + 1, num_threads, [&](int n) {
    std::size_t knot =
        static_cast<std::size_t>(n) * static_cast<std::size_t>((blocks_[0] + 1) * (blocks_[1] + 1));
    for (int b = 0; b <= blocks_[1]; ++b) {
      for (int a = 0; a <= blocks_[0]; ++a, ++knot) {
        const Eigen::Vector3d place_mm =
            ct_from_slices * (Eigen::Array3i(a, b, n) * block_).cast<double>().matrix().eval();
        const Eigen::Vector3d rest_mm = rest.RestInCtMm(place_mm, place_mm);
        knot_moved_[knot] = rest_mm != place_mm;
        offset_[knot] = (slices_from_ct_.linear() * (rest_mm - place_mm)).cast<float>();
      }
    }
  });
}

void AttenuationVolume::Deform(const slicing::RestMap* rest, int num_threads) {
  if (rest == nullptr && now_.empty()) return;
  if (rest != nullptr) {
    EvaluateKnots(*rest, num_threads);
  } else {
    std::ranges::fill(knot_moved_, std::uint8_t{0});
  }
  const bool moves = std::ranges::find(knot_moved_, std::uint8_t{1}) != knot_moved_.end();
  if (now_.empty()) {
    if (!moves) return;
    now_ = base_;
  }
  // Blocks of one layer write slices of their own.
  ParallelFor(blocks_[2], num_threads, [&](int n) {
    for (int b = 0; b < blocks_[1]; ++b) {
      for (int a = 0; a < blocks_[0]; ++a) {
        const Eigen::Array3i block(a, b, n);
        bool moved = false;
        for (int corner = 0; corner < 8; ++corner) {
          const int ka = a + (corner & 1);
          const int kb = b + ((corner >> 1) & 1);
          const int kn = n + (corner >> 2);
          moved |= knot_moved_[static_cast<std::size_t>(
                       (kn * (blocks_[1] + 1) + kb) * (blocks_[0] + 1) + ka)] != 0;
        }
        std::uint8_t& before =
            block_moved_[static_cast<std::size_t>((n * blocks_[1] + b) * blocks_[0] + a)];
        if (moved) MoveBlock(block);
        if (!moved && before != 0) RestoreBlock(block);
        before = moved;
      }
    }
  });
}

void AttenuationVolume::RestoreBlock(const Eigen::Array3i& block) {
  const Eigen::Array3i first = block * block_;
  const Eigen::Array3i end = (first + block_).min(size_);
  for (int n = first[2]; n < end[2]; ++n) {
    for (int b = first[1]; b < end[1]; ++b) {
      const std::size_t at = Index(first[0], b, n);
      std::copy_n(base_.begin() + static_cast<std::ptrdiff_t>(at), end[0] - first[0],
                  now_.begin() + static_cast<std::ptrdiff_t>(at));
    }
  }
}

void AttenuationVolume::MoveBlock(const Eigen::Array3i& block) {
  const Eigen::Array3i first = block * block_;
  const Eigen::Array3i end = (first + block_).min(size_);
  const auto knot = [&](int da, int db, int dn) -> const Eigen::Vector3f& {
    return offset_[static_cast<std::size_t>(
        ((block[2] + dn) * (blocks_[1] + 1) + block[1] + db) * (blocks_[0] + 1) + block[0] + da)];
  };
  const Eigen::Array3f per_voxel = 1.0F / block_.cast<float>();
  // The borders of a and b stay 0.
  for (int n = first[2]; n < end[2]; ++n) {
    const float tn = static_cast<float>(n - first[2]) * per_voxel[2];
    for (int b = std::max(first[1], 1); b < std::min(end[1], size_[1] - 1); ++b) {
      const float tb = static_cast<float>(b - first[1]) * per_voxel[1];
      const auto edge = [&](int da) -> Eigen::Vector3f {
        return (1 - tn) * ((1 - tb) * knot(da, 0, 0) + tb * knot(da, 1, 0)) +
               tn * ((1 - tb) * knot(da, 0, 1) + tb * knot(da, 1, 1));
      };
      const Eigen::Vector3f left = edge(0);
      const Eigen::Vector3f right = edge(1);
      std::int16_t* row = now_.data() + Index(0, b, n);
      for (int a = std::max(first[0], 1); a < std::min(end[0], size_[0] - 1); ++a) {
        const float ta = static_cast<float>(a - first[0]) * per_voxel[0];
        const Eigen::Vector3f place(static_cast<float>(a), static_cast<float>(b),
                                    static_cast<float>(n));
        row[a] = SampleBase(place + (1 - ta) * left + ta * right);
      }
    }
  }
}

/// Trilinear; 0 beyond the first and last slice, and beyond the borders.
std::int16_t AttenuationVolume::SampleBase(const Eigen::Vector3f& place) const {
  const Eigen::Array3f last = (size_ - 1).cast<float>();
  const bool inside = (place.array() >= Eigen::Array3f(0, 0, -0.5F)).all() &&
                      (place.array() <= last + Eigen::Array3f(0, 0, 0.5F)).all();
  if (!inside) return 0;  // Also what is not finite.
  const Eigen::Array3f in = place.array().max(0.0F).min(last);
  const Eigen::Array3i cell = in.floor().cast<int>().min((size_ - 2).max(0));
  const Eigen::Array3f t = in - cell.cast<float>();
  const std::ptrdiff_t next_slice =
      size_[2] > 1 ? static_cast<std::ptrdiff_t>(size_[0]) * size_[1] : 0;
  const std::int16_t* v = base_.data() + Index(cell[0], cell[1], cell[2]);
  const auto plane = [&](const std::int16_t* p) {
    const float v0 = static_cast<float>(p[0]) + t[0] * static_cast<float>(p[1] - p[0]);
    const std::int16_t* q = p + size_[0];
    const float v1 = static_cast<float>(q[0]) + t[0] * static_cast<float>(q[1] - q[0]);
    return v0 + t[1] * (v1 - v0);
  };
  const float v0 = plane(v);
  return static_cast<std::int16_t>(std::lround(v0 + t[2] * (plane(v + next_slice) - v0)));
}

}  // namespace acus::fluoroscopy
