// Where the samples of all lines lie in the tissue at rest: straight pieces between depths.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/slicing/kernels.h"

namespace acus::ultrasound {

/// Lines of one elevation plane, in voxel indices and in the lattice of the speckle. Between knots
/// (in line and in depth) the motion of the tissue is linear; without motion and out of the central
/// plane there is one piece.
class BeamPath {
 public:
  struct Frame {
    const acoustics::ScanGrid* grid = nullptr;
    Eigen::Affine3d index_from_ct = Eigen::Affine3d::Identity();
    std::optional<Eigen::Matrix3d> lattice_from_index{};  ///< None: Lattice() is not used.
    /// Distance from the plane along the probe's z, by sample; empty: in the plane.
    std::vector<double> elevation_mm;
  };

  explicit BeamPath(const Frame& frame);

  /// @param rest  Null: the tissue has not moved. Allocates only if its spacing changes.
  /// @pre the pose is finite.
  void Set(const Eigen::Isometry3d& ct_from_probe, const slicing::RestMap* rest);

  /// Piece that sample `k` lies on; beyond the last sample: the last.
  int PieceAt(int k) const {
    const auto n = static_cast<std::size_t>(k);
    return n < piece_of_.size() ? piece_of_[n] : piece_of_.back();
  }
  /// From lane `first` on: place of sample k is start + k * step.
  slicing::kernels::Lines Voxels(int piece, int first) const {
    return LinesAt(sets_ * piece, first);
  }
  /// @pre the frame has a lattice.
  slicing::kernels::Lines Lattice(int piece, int first) const {
    return LinesAt(sets_ * piece + 1, first);
  }

 private:
  slicing::kernels::Lines LinesAt(int set, int first) const;
  void Lay(double spacing_mm);
  void AskAtKnots(const Eigen::Isometry3d& ct_from_probe, const slicing::RestMap* rest);
  void PlaceKnotRow(std::size_t row, std::array<float*, 3> place) const;
  void MakePiece(int piece, int first_sample, int last_sample);
  void TurnIntoLattice(int piece);
  std::ptrdiff_t FloatsPerPiece() const { return std::ptrdiff_t{6} * sets_ * lanes_; }

  Frame frame_;
  int lanes_;
  int sets_;  ///< By piece: voxels, and the lattice if there is one.
  double laid_for_mm_ = -1.0;
  bool straight_ = true;
  Eigen::Affine3d index_from_probe_ = Eigen::Affine3d::Identity();
  std::vector<int> knot_samples_;
  std::vector<int> knot_lines_;
  std::vector<int> cell_of_lane_;
  std::vector<float> share_of_lane_;     ///< Of the knot after.
  std::vector<int> piece_of_;            ///< By sample.
  std::vector<Eigen::Vector3d> offset_;  ///< By knot sample, then knot line, in voxels.
  std::vector<float> x_;                 ///< By lane: start and direction in the plane, mm.
  std::vector<float> y_;
  std::vector<float> dx_;
  std::vector<float> dy_;
  image::AlignedFloats places_;  ///< Two knot rows of 3 * lanes.
  image::AlignedFloats lines_;   ///< Sets of 6 * lanes.
};

}  // namespace acus::ultrasound
