// Label map to smooth fields, one per material; a material's region is where its field is largest.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::meshing {

/// What the mesh must separate by its faces: 0 is outside the body, then groups of tissues.
using MaterialOfLabel = std::array<std::uint8_t, 256>;

/// Field m is the share of material m in the neighbourhood (Gaussian) plus an offset b_m, sampled
/// trilinearly. Interfaces between m and n are the zero set of phi_m + b_m - phi_n - b_n: smooth
/// where the voxels are steps, and shared by both sides. The offsets give back the volume that
/// smoothing takes from convex shapes.
///
/// All positions are in the *grid frame*: mm along the volume's own axes from the first voxel's
/// centre. Beyond the volume everything is outside.
class MaterialField {
 public:
  /// @param spacing_mm  Voxels are averaged in blocks to about this spacing (never refined).
  /// @param smoothing_mm  Standard deviation of the Gaussian; 0 for none.
  /// @param padding_mm  The field reaches so far beyond the volume.
  MaterialField(const volume::LabelMap& labels, const MaterialOfLabel& material_of_label,
                int num_materials, double spacing_mm, double smoothing_mm, double padding_mm,
                int num_threads);

  int num_materials() const { return static_cast<int>(fields_.size()); }
  int MaterialAt(const Eigen::Vector3d& x) const;
  double Value(const Eigen::Vector3d& x, int material) const;  ///< phi + b.
  /// phi_a + b_a - phi_b - b_b.
  double Difference(const Eigen::Vector3d& x, int a, int b) const;
  Eigen::Vector3d Gradient(const Eigen::Vector3d& x, int a, int b) const;  ///< Per mm.
  /// Moves x along the gradient to the interface of a and b. False if none is within reach_mm.
  bool Project(Eigen::Vector3d& x, int a, int b, double reach_mm) const;

  double offset(int material) const { return offsets_[material]; }
  void set_offset(int material, double value) { offsets_[material] = value; }

  /// Whether the box holds a voxel of the body; of the body's outside; of another interface.
  enum class What { kBody = 0, kSkin = 1, kInterface = 2 };
  bool BoxHolds(const Eigen::Vector3d& low, const Eigen::Vector3d& high, What what) const;

  const Eigen::Vector3d& low_mm() const { return low_; }
  Eigen::Vector3d high_mm() const;
  const Eigen::Vector3d& spacing_mm() const { return spacing_; }
  const Eigen::Vector3i& size() const { return size_; }  ///< Of the field, in its own voxels.
  /// The material at the centre of a voxel of the field, before any offset was changed.
  std::uint8_t MaterialOfVoxel(const Eigen::Vector3i& v) const {
    return material_[Index(v[0], v[1], v[2])];
  }

 private:
  struct Cell {
    std::array<std::size_t, 8> index;
    std::array<double, 8> weight;
  };
  Cell Locate(const Eigen::Vector3d& x) const;
  double Sample(const Cell& cell, int material) const;
  std::size_t Index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(i);
  }
  void Average(const volume::LabelMap& labels, const MaterialOfLabel& material_of_label,
               const Eigen::Array3i& block, int num_threads);
  void Smooth(double smoothing_mm, int num_threads);
  void MatchVolumes(const std::vector<double>& voxels_of_material, int num_threads);
  /// Volume of the trilinear field by value from 0 to 1, in voxels.
  void AddToHistogram(const std::vector<float>& field, std::vector<double>& histogram) const;
  void FindInterfaces();

  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  Eigen::Vector3i padding_ = Eigen::Vector3i::Zero();
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();      ///< Centre of the first field voxel.
  Eigen::Vector3d spacing_ = Eigen::Vector3d::Ones();  ///< Of the field.
  std::vector<std::vector<float>> fields_;
  std::vector<double> offsets_;
  std::vector<std::uint8_t> material_;               ///< By voxel of the field.
  std::array<std::vector<std::int32_t>, 3> counts_;  ///< Summed-volume tables, by What.
};

}  // namespace acus::meshing
