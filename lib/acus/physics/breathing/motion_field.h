// Displacement fields of a breathing patient, compact in memory: the parts that a motion model
// adds up.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "acus/data/volume/geometry.h"

namespace acus::breathing {

/// How much of each component moves the tissue at a moment. Empty: the patient is as in the
/// reference image.
struct MotionWeights {
  static constexpr int kMaxCount = 4;
  int count = 0;
  std::array<std::uint8_t, kMaxCount> component{};
  std::array<float, kMaxCount> weight{};

  /// Components of weight 0 are omitted. @pre fewer than kMaxCount so far.
  void Add(int index, double share) noexcept {
    if (share == 0.0) return;
    component[static_cast<std::size_t>(count)] = static_cast<std::uint8_t>(index);
    weight[static_cast<std::size_t>(count)] = static_cast<float>(share);
    ++count;
  }
  bool operator==(const MotionWeights&) const = default;
};

/// Displacements in mm at the nodes of a grid, 16 bits each. With a component's largest value m
/// they are good to m / 65,000: a micrometre at 64 mm. Trilinear between the nodes; beyond the
/// grid as at its border. A value; const access from any number of threads.
class MotionField {
 public:
  static constexpr int kMaxComponents = 64;

  MotionField() = default;
  /// Nothing moves yet.
  /// @throws InputError if the grid has fewer than two nodes along an axis, or for a number of
  ///     components outside [1, kMaxComponents].
  MotionField(const volume::Geometry& nodes, int num_components);

  /// @param displacement_in_ct_mm  (x, y, z) at each node, i fastest: 3 * nodes().num_voxels()
  ///     numbers, relative to the reference state.
  /// @throws InputError for another number of values, or if one is not finite or beyond 1000 mm.
  void SetComponent(int index, std::span<const float> displacement_in_ct_mm);
  std::vector<float> Component(int index) const;

  /// Where tissue that is at this place in the reference image has moved, relative to it, mm.
  Eigen::Vector3d DisplacementMm(const MotionWeights& weights,
                                 const Eigen::Vector3d& rest_in_ct_mm) const noexcept;

  const volume::Geometry& nodes() const { return nodes_; }
  int num_components() const { return static_cast<int>(mm_per_unit_.size()); }
  std::size_t bytes() const;
  /// A number that only fields with the same nodes and values have: copies. For what is derived of
  /// a field and kept. 0: no field.
  std::uint64_t identity() const { return identity_; }

  /// x, y, z of each node along a row of the grid, in 16 bits as stored.
  std::span<const std::int16_t> StoredRow(int index, int j, int k) const;
  /// What one unit of a stored value is, mm.
  double MmPerUnit(int index) const { return mm_per_unit_[static_cast<std::size_t>(index)]; }
  /// @param values  x, y, z of each node, i fastest.
  /// @throws InputError for another number of values.
  void SetStored(int index, std::span<const std::int16_t> values, double mm_per_unit);

 private:
  template <typename Row>
  void ForEachRow(const Row& row) const;
  std::size_t RowAt(int j, int k) const {
    return row_stride_ * static_cast<std::size_t>(j) + slice_stride_ * static_cast<std::size_t>(k);
  }
  std::size_t ValuesPerComponent() const;

  std::uint64_t identity_ = 0;
  volume::Geometry nodes_;
  Eigen::Matrix3d index_linear_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d index_offset_ = Eigen::Vector3d::Zero();
  std::vector<float> mm_per_unit_;
  // Rows and slices are longer than their nodes, see the constructor.
  std::size_t row_stride_ = 0;
  std::size_t slice_stride_ = 0;
  std::vector<std::vector<std::int16_t>> values_;  ///< x, y, z of each node, by component.
};

}  // namespace acus::breathing
