#include "acus/imaging/volume_rendering/pressed_tissue.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"

namespace acus::volume_rendering {
namespace {

constexpr std::int64_t kMostKnots = 4'000'000;
/// Shorter offsets are what remains of an inversion, not of a tool.
constexpr double kLeastMm = 1e-3;

}  // namespace

PressedTissue::PressedTissue(const Eigen::AlignedBox3d& box_in_ct_mm, double spacing_mm,
                             const Breathed& breathed, int num_threads) {
  ACUS_REQUIRE(spacing_mm > 0.0, "pressed tissue: knots are ", spacing_mm,
               " mm apart; it must be above 0");
  if (box_in_ct_mm.isEmpty()) return;
  const Eigen::Array3d cells = (box_in_ct_mm.sizes().array() / spacing_mm).ceil().max(1.0);
  // One more knot all around, without offset.
  ACUS_REQUIRE((cells + 3.0).prod() <= static_cast<double>(kMostKnots), "pressed tissue: a box of ",
               box_in_ct_mm.sizes().transpose(), " mm has too many knots every ", spacing_mm,
               " mm; allowed are ", kMostKnots);
  size_ = cells.cast<int>() + 3;
  spacing_mm_ = static_cast<float>(spacing_mm);
  const Eigen::Vector3d first = box_in_ct_mm.min() - Eigen::Vector3d::Constant(spacing_mm);
  box_ = {first.cast<float>(),
          (first + spacing_mm * (size_ - 1).cast<double>().matrix()).cast<float>()};
  knots_.assign(static_cast<std::size_t>(size_.cast<std::int64_t>().prod()),
                Eigen::Vector3f::Zero());
  std::vector<double> largest(static_cast<std::size_t>(size_[2]), 0.0);
  ParallelFor(size_[2] - 2, num_threads, [&](int slice) {
    const int k = slice + 1;
    for (int j = 1; j < size_[1] - 1; ++j) {
      Eigen::Vector3d offset = Eigen::Vector3d::Zero();
      for (int i = 1; i < size_[0] - 1; ++i) {
        const Eigen::Vector3d place = first + spacing_mm * Eigen::Vector3d(i, j, k);
        offset = breathed(place, place + offset) - place;
        if (!offset.allFinite() || offset.norm() < kLeastMm) offset.setZero();
        const auto at = (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) +
                         static_cast<std::size_t>(j)) *
                            static_cast<std::size_t>(size_[0]) +
                        static_cast<std::size_t>(i);
        knots_[at] = offset.cast<float>();
        double& most = largest[static_cast<std::size_t>(k)];
        most = std::max(most, offset.norm());
      }
    }
  });
  largest_mm_ = static_cast<float>(*std::ranges::max_element(largest));
  if (largest_mm_ == 0.0F) *this = PressedTissue();
}

Eigen::Vector3f PressedTissue::OffsetMm(const Eigen::Vector3f& world_mm) const noexcept {
  if (!Contains(world_mm)) return Eigen::Vector3f::Zero();
  const Eigen::Array3f at = (world_mm - box_.min()).array() / spacing_mm_;
  const Eigen::Array3i cell = at.cast<int>().min(size_ - 2);
  const Eigen::Array3f share = at - cell.cast<float>();
  const std::ptrdiff_t row = size_[0];
  const std::ptrdiff_t slice = row * size_[1];
  const Eigen::Vector3f* corner = knots_.data() + slice * cell[2] + row * cell[1] + cell[0];
  const auto along = [&](const Eigen::Vector3f* a) {
    return Eigen::Vector3f(a[0] + share[0] * (a[1] - a[0]));
  };
  const Eigen::Vector3f near_low = along(corner);
  const Eigen::Vector3f near = near_low + share[1] * (along(corner + row) - near_low);
  const Eigen::Vector3f far_low = along(corner + slice);
  const Eigen::Vector3f far = far_low + share[1] * (along(corner + slice + row) - far_low);
  return near + share[2] * (far - near);
}

Eigen::Matrix3f PressedTissue::GradientAt(const Eigen::Vector3f& world_mm) const noexcept {
  Eigen::Matrix3f gradient = Eigen::Matrix3f::Identity();
  if (!Contains(world_mm)) return gradient;
  const float half_mm = 0.5F * spacing_mm_;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3f aside = half_mm * Eigen::Vector3f::Unit(axis);
    gradient.col(axis) += (OffsetMm(world_mm + aside) - OffsetMm(world_mm - aside)) / spacing_mm_;
  }
  return gradient;
}

math::InversePoint PressedTissue::WorldMm(const Eigen::Vector3d& breathed_mm) const noexcept {
  const auto offset = [this](const Eigen::Vector3d& world_mm) {
    return Eigen::Vector3d(OffsetMm(world_mm.cast<float>()).cast<double>());
  };
  return math::InvertDisplacement(offset, breathed_mm,
                                  Eigen::Vector3d(breathed_mm - offset(breathed_mm)), kInverse);
}

}  // namespace acus::volume_rendering
