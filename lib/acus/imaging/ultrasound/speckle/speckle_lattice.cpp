#include "acus/imaging/ultrasound/speckle/speckle_lattice.h"

#include <Eigen/Geometry>

#include "acus/base/core/random.h"

namespace acus::ultrasound {

Eigen::Matrix3d SpeckleLatticeFromIndex(const volume::Geometry& geometry, double grain_mm,
                                        std::uint64_t seed) {
  Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.9273, Eigen::Vector3d(0.36, 0.48, 0.8)).toRotationMatrix();
  if (seed != 0) {
    RandomStream random(seed, "lattice of the speckle");
    const Eigen::Vector3d axis(random.Normal(), random.Normal(), random.Normal());
    turn = Eigen::AngleAxisd(random.Uniform(0.3, 2.8), axis.normalized()) * turn;
  }
  const Eigen::Matrix3d shear = Eigen::Matrix3d::Identity() + Eigen::Matrix3d::Constant(1.0 / 3.0);
  return shear * turn * geometry.direction * geometry.spacing_mm.matrix().asDiagonal() / grain_mm;
}

}  // namespace acus::ultrasound
