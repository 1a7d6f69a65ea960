#include "acus/imaging/ultrasound/beams/beam_march.h"

#include <algorithm>
#include <cmath>

namespace acus::ultrasound {

Eigen::Vector3d Refracted(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                          double speed_ratio) {
  const double cosine = direction.dot(normal);
  const Eigen::Vector3d along = speed_ratio * (direction - cosine * normal);
  const double sine2 = along.squaredNorm();
  if (sine2 >= 1.0) return direction;
  return along + std::copysign(std::sqrt(1.0 - sine2), cosine) * normal;
}

void BeamMarch::Start() {
  std::fill_n(travelled_, kLanes, 0.0F);
  std::fill_n(before_, kLanes, -1.0F);
  std::fill_n(shift_[0], 3 * kLanes, 0.0F);
  std::fill_n(turn_[0], 3 * kLanes, 0.0F);
}

void BeamMarch::Place(const BeamPath& path, const Eigen::Matrix3f& lattice_from_index, int first,
                      int lanes) {
  int piece = -1;
  slicing::kernels::Lines lines{};
  for (int l = 0; l < lanes; ++l) {
    const float s = travelled_[l];
    const int here = path.PieceAt(static_cast<int>(s));
    if (here != piece) {
      piece = here;
      lines = path.Voxels(piece, first);
    }
    for (int a = 0; a < 3; ++a) {
      voxel_place_[a][l] = lines.start[a][l] + s * lines.step[a][l] + shift_[a][l];
      voxel_step_[a][l] = lines.step[a][l] + turn_[a][l];
    }
  }
  for (Eigen::Index a = 0; a < 3; ++a) {
    const Eigen::RowVector3f row = lattice_from_index.row(a);
    for (int l = 0; l < lanes; ++l) {
      lattice_place_[a][l] =
          row[0] * voxel_place_[0][l] + row[1] * voxel_place_[1][l] + row[2] * voxel_place_[2][l];
      lattice_step_[a][l] =
          row[0] * voxel_step_[0][l] + row[1] * voxel_step_[1][l] + row[2] * voxel_step_[2][l];
    }
  }
}

void BeamMarch::Advance(const float* speed_ratio, int lanes) {
  for (int l = 0; l < lanes; ++l) {
    before_[l] = travelled_[l];
    travelled_[l] += speed_ratio[l];
    for (int a = 0; a < 3; ++a) shift_[a][l] += speed_ratio[l] * turn_[a][l];
  }
}

void BeamMarch::Bend(int lane, const Eigen::Vector3d& normal, const Eigen::Array3d& spacing_mm,
                     double speed_ratio, double samples_ago) {
  Eigen::Vector3d step_mm;
  for (int a = 0; a < 3; ++a) step_mm[a] = voxel_step_[a][lane] * spacing_mm[a];
  const double length_mm = step_mm.norm();
  const Eigen::Vector3d bent_mm = length_mm * Refracted(step_mm / length_mm, normal, speed_ratio);
  for (int a = 0; a < 3; ++a) {
    const auto change = static_cast<float>((bent_mm[a] - step_mm[a]) / spacing_mm[a]);
    turn_[a][lane] += change;
    voxel_step_[a][lane] += change;
    shift_[a][lane] += static_cast<float>(samples_ago) * change;
  }
}

}  // namespace acus::ultrasound
