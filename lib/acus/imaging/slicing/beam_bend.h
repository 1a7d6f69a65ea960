// Images of deformed tissue: where the samples of straight beams lie in the CT, which shows the
// tissue at rest.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/kernels.h"

namespace acus::slicing {

/// Where tissue that is now at a place was when the CT was taken.
class RestMap {
 public:
  virtual ~RestMap() = default;
  /// Both in CT space. Places that have not moved come back as they are, bit for bit.
  /// @param guess_in_ct_mm  Where to begin to look: what a neighbour gave, moved along.
  virtual Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                     const Eigen::Vector3d& guess_in_ct_mm) const noexcept = 0;
  /// Distance over which the map may be taken as linear.
  virtual double SpacingMm() const noexcept = 0;
};

/// Scan lines in continuous voxel indices, one entry per line; rounded up to 16 entries by copies
/// of the last line.
struct BeamLines {
  image::AlignedFloats start[3];  ///< Of sample 0, along i, j, k.
  image::AlignedFloats step[3];   ///< Per sample.
};

/// The straight lines of `grid` as seen from a pose. Allocation-free once `lines` is large enough.
/// @throws InputError if the pose has a value that is not finite.
void PlaceLines(const acoustics::ScanGrid& grid, const Eigen::Affine3d& index_from_ct,
                const Eigen::Isometry3d& ct_from_probe, BeamLines& lines);

/// Offsets from the straight lines, bilinear in line and sample between the knots of a lattice.
/// Exact at the knots, continuous everywhere.
class BeamBend {
 public:
  /// Lanes that PlaceRow can place at a time.
  static constexpr int kMaxLanes = 256;
  struct Row {
    alignas(64) float place[3][kMaxLanes];
  };

  /// Places the knots and asks the map at each. Allocates only if the lattice grows.
  /// @param rest  Null: straight lines.
  void Set(const acoustics::ScanGrid& grid, const Eigen::Isometry3d& ct_from_probe,
           const Eigen::Affine3d& index_from_ct, const RestMap* rest);

  /// False if no knot moved: then the lines are straight, and nothing is computed for them.
  bool active() const { return active_; }

  /// Samples between which each bent line is straight, ascending, from the first to the last or
  /// beyond it. Of the last map that Set was given.
  const std::vector<int>& samples_of_knots() const { return along_.knot; }

  /// Positions of sample `k` of lanes [first, first + count) in the form that kernels take, and the
  /// sample number to give them. Straight lines are passed on; bent ones are written into `row`.
  /// @pre count <= kMaxLanes.
  kernels::Lines PlaceRow(const BeamLines& lines, int k, int first, int count, Row& row,
                          float& sample) const noexcept;

 private:
  struct Axis {
    std::vector<int> knot;      ///< Line (or sample) of each knot, ascending.
    std::vector<int> cell;      ///< Of each line: the knot before it.
    std::vector<float> weight;  ///< Of each line: share of the knot after it.
    void Spread(int count, int step, int rounded_count);
  };
  void Lay(const acoustics::ScanGrid& grid, double spacing_mm);
  void SpreadKnots(std::size_t row);

  bool active_ = false;
  double laid_for_mm_ = 0.0;
  int lanes_ = 0;
  Axis across_;                     ///< Lines.
  Axis along_;                      ///< Samples.
  std::vector<float> at_knot_[3];   ///< Offsets of one row of knots, in voxels.
  image::AlignedFloats offset_[3];  ///< By sample knot, then lane, in voxels.
};

}  // namespace acus::slicing
