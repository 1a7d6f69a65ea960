#include "acus/physics/breathing/motion_field.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sys/mman.h>

#include "acus/base/core/error.h"

namespace acus::breathing {
namespace {

// Four lanes of the baseline instruction set (GCC and Clang): x, y, z, and one that is not used.
using Float4 = float __attribute__((vector_size(16)));
using Short4 = std::int16_t __attribute__((vector_size(8)));

constexpr double kLargestMm = 1000.0;
constexpr double kUnits = 32767.0;

/// The node before a position along one axis, and the way to the next one.
struct Cell {
  std::size_t node;
  float fraction;
};

Cell CellAt(double position, int size) noexcept {
  // NaN ends up at the first node: std::max returns its first argument then.
  const double inside = std::min(std::max(0.0, position), static_cast<double>(size - 1));
  const double low = std::min(std::floor(inside), static_cast<double>(size - 2));
  return {static_cast<std::size_t>(low), static_cast<float>(inside - low)};
}

Float4 Load(const std::int16_t* node) noexcept {
  Short4 values;
  std::memcpy(&values, node, sizeof(values));
  return __builtin_convertvector(values, Float4);
}

Float4 Lerp(Float4 a, Float4 b, float fraction) noexcept {
  return a + fraction * (b - a);
}

/// An image looks at places all over a field that may have a gigabyte: with pages of 4 kB most
/// looks would first have to look up the page. Where large pages are not to be had, it is slower.
std::vector<std::int16_t> ZerosOnLargePages(std::size_t count) {
  constexpr std::uintptr_t kLargePage = std::uintptr_t{1} << 21;
  std::vector<std::int16_t> values;
  values.reserve(count);
  const auto begin = reinterpret_cast<std::uintptr_t>(values.data());
  const std::uintptr_t first = (begin + kLargePage - 1) / kLargePage * kLargePage;
  const std::uintptr_t end = (begin + count * sizeof(std::int16_t)) / kLargePage * kLargePage;
  if (end > first) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
  values.resize(count);
  return values;
}

/// Slices whose size is a multiple of a power of two put the same row of each into the same few
/// lines of the cache, and a needle across them would throw out one node for the next. Five lines
/// of 64 bytes more place 50 slices beside each other.
std::size_t SpreadOverCache(std::size_t values_per_slice) {
  constexpr std::size_t kLineValues = 32;
  const std::size_t lines = (values_per_slice + kLineValues - 1) / kLineValues;
  return (lines % 16 == 0 ? lines + 5 : lines) * kLineValues;
}

std::uint64_t NextIdentity() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

MotionField::MotionField(const volume::Geometry& nodes, int num_components)
    : identity_(NextIdentity()), nodes_(nodes) {
  ACUS_REQUIRE((nodes.size >= 2).all(), "motion field of ", nodes.size[0], " x ", nodes.size[1],
               " x ", nodes.size[2], " nodes; at least 2 are needed along each axis");
  ACUS_REQUIRE(num_components >= 1 && num_components <= kMaxComponents, "motion field of ",
               num_components, " components; allowed is 1 to ", kMaxComponents);
  const Eigen::Affine3d index_from_ct = nodes.index_from_ct();
  index_linear_ = index_from_ct.linear();
  index_offset_ = index_from_ct.translation();
  mm_per_unit_.assign(static_cast<std::size_t>(num_components), 0.0F);
  row_stride_ = 3 * static_cast<std::size_t>(nodes.size[0]);
  slice_stride_ = SpreadOverCache(row_stride_ * static_cast<std::size_t>(nodes.size[1]));
  for (int n = 0; n < num_components; ++n) {
    values_.push_back(ZerosOnLargePages(ValuesPerComponent()));
  }
}

std::size_t MotionField::ValuesPerComponent() const {
  // Nodes are read by two and eight values at a time: two more than the last two have.
  return slice_stride_ * static_cast<std::size_t>(nodes_.size[2]) + 2;
}

template <typename Row>
void MotionField::ForEachRow(const Row& row) const {
  std::size_t first_packed = 0;
  for (int k = 0; k < nodes_.size[2]; ++k) {
    for (int j = 0; j < nodes_.size[1]; ++j, first_packed += row_stride_) {
      row(RowAt(j, k), first_packed);
    }
  }
}

void MotionField::SetComponent(int index, std::span<const float> displacement_in_ct_mm) {
  ACUS_REQUIRE(displacement_in_ct_mm.size() == 3 * nodes_.num_voxels(), "motion component ", index,
               " has ", displacement_in_ct_mm.size(), " values for ", nodes_.num_voxels(),
               " nodes; three are needed for each");
  double largest_mm = 0.0;
  for (const float value : displacement_in_ct_mm) {
    ACUS_REQUIRE(std::abs(value) <= kLargestMm, "motion component ", index,
                 " has a displacement of ", value, " mm; allowed is up to ", kLargestMm,
                 " mm. Is the field in mm, and relative to the reference image?");
    largest_mm = std::max(largest_mm, static_cast<double>(std::abs(value)));
  }
  const auto n = static_cast<std::size_t>(index);
  identity_ = NextIdentity();
  mm_per_unit_[n] = static_cast<float>(largest_mm / kUnits);
  const double units_per_mm = largest_mm > 0.0 ? kUnits / largest_mm : 0.0;
  std::int16_t* values = values_[n].data();
  ForEachRow([&](std::size_t stored, std::size_t packed) {
    std::ranges::transform(
        displacement_in_ct_mm.subspan(packed, row_stride_), values + stored, [=](float mm) {
          return static_cast<std::int16_t>(std::lround(units_per_mm * static_cast<double>(mm)));
        });
  });
}

std::vector<float> MotionField::Component(int index) const {
  const auto n = static_cast<std::size_t>(index);
  const float unit_mm = mm_per_unit_[n];
  std::vector<float> mm(3 * nodes_.num_voxels());
  ForEachRow([&](std::size_t stored, std::size_t packed) {
    std::transform(&values_[n][stored], &values_[n][stored] + row_stride_, &mm[packed],
                   [=](std::int16_t units) { return unit_mm * static_cast<float>(units); });
  });
  return mm;
}

std::span<const std::int16_t> MotionField::StoredRow(int index, int j, int k) const {
  return std::span(values_[static_cast<std::size_t>(index)]).subspan(RowAt(j, k), row_stride_);
}

void MotionField::SetStored(int index, std::span<const std::int16_t> values, double mm_per_unit) {
  ACUS_REQUIRE(values.size() == 3 * nodes_.num_voxels(), "motion component ", index, " has ",
               values.size(), " values for ", nodes_.num_voxels(),
               " nodes; three are needed for each");
  ACUS_REQUIRE(mm_per_unit >= 0.0 && mm_per_unit * kUnits <= 1.001 * kLargestMm,
               "motion component ", index, " has ", mm_per_unit, " mm per unit; allowed is 0 to ",
               kLargestMm / kUnits);
  std::int16_t* of_component = values_[static_cast<std::size_t>(index)].data();
  ForEachRow([&](std::size_t stored, std::size_t packed) {
    std::ranges::copy(values.subspan(packed, row_stride_), of_component + stored);
  });
  identity_ = NextIdentity();
  mm_per_unit_[static_cast<std::size_t>(index)] = static_cast<float>(mm_per_unit);
}

std::size_t MotionField::bytes() const {
  return values_.size() * ValuesPerComponent() * sizeof(std::int16_t);
}

Eigen::Vector3d MotionField::DisplacementMm(const MotionWeights& weights,
                                            const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  if (weights.count == 0) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d position = index_linear_ * rest_in_ct_mm + index_offset_;
  const Cell i = CellAt(position[0], nodes_.size[0]);
  const Cell j = CellAt(position[1], nodes_.size[1]);
  const Cell k = CellAt(position[2], nodes_.size[2]);
  const std::size_t row = row_stride_;
  const std::size_t slice = slice_stride_;
  const std::size_t corner = 3 * i.node + row * j.node + slice * k.node;
  Float4 sum{};
  for (int n = 0; n < weights.count; ++n) {
    const auto at = static_cast<std::size_t>(n);
    const std::int16_t* node = values_[weights.component[at]].data() + corner;
    const auto along_i = [&](const std::int16_t* first) {
      return Lerp(Load(first), Load(first + 3), i.fraction);
    };
    const Float4 near = Lerp(along_i(node), along_i(node + row), j.fraction);
    const Float4 far = Lerp(along_i(node + slice), along_i(node + slice + row), j.fraction);
    const float unit_mm = weights.weight[at] * mm_per_unit_[weights.component[at]];
    sum += unit_mm * Lerp(near, far, k.fraction);
  }
  return {sum[0], sum[1], sum[2]};
}

}  // namespace acus::breathing
