#include "acus/physics/mechanics/elements/fibre_law.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace acus::mechanics {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;

/// Energy and its derivatives by e >= 0.
struct AtStretch {
  double energy_mpa = 0.0;
  double slope_mpa = 0.0;
  double curvature_mpa = 0.0;
};

AtStretch ValueAt(const Fibres& fibres, double e) {
  if (e <= 0.0) return {};
  const double k1 = fibres.k1_mpa;
  const double k2 = fibres.k2;
  if (k2 == 0.0) return {0.5 * k1 * e * e, k1 * e, k1};
  const double end = std::min(kLargestX, std::sqrt(std::log(kLargestStiffening) / k2));
  const double at = std::min(e, end);
  const double growth = std::exp(k2 * at * at);
  const double slope = k1 * at * growth;
  const double curvature = k1 * (1.0 + 2.0 * k2 * at * at) * growth;
  const double over = e - at;
  return {0.5 * k1 / k2 * (growth - 1.0) + over * (slope + 0.5 * curvature * over),
          slope + curvature * over, curvature};
}

/// F along the fibres.
struct Along {
  Along(const Fibres& fibres, const Eigen::Matrix3d& f)
      : cofactor(Cofactor(f)),
        volume(VolumeFactorAt(f.col(0).dot(cofactor.col(0)))),
        stretched(f * fibres.direction_in_ct),
        square(stretched.squaredNorm()),
        at(ValueAt(fibres, volume.value * square - 1.0)) {}

  Eigen::Matrix3d cofactor;
  VolumeFactor volume;
  Eigen::Vector3d stretched;  ///< F a.
  double square;
  AtStretch at;
};

}  // namespace

double FibreEnergyMpa(const Fibres& fibres, const Eigen::Matrix3d& f) {
  return Along(fibres, f).at.energy_mpa;
}

Eigen::Matrix3d FibreStressMpa(const Fibres& fibres, const Eigen::Matrix3d& f) {
  const Along along(fibres, f);
  const double slope = along.at.slope_mpa;
  return (2.0 * slope * along.volume.value) * along.stretched * fibres.direction_in_ct.transpose() +
         (slope * along.volume.slope * along.square) * along.cofactor;
}

Matrix9 FibreTangentMpa(const Fibres& fibres, const Eigen::Matrix3d& f) {
  const Along along(fibres, f);
  const Eigen::Matrix3d pulled = along.stretched * fibres.direction_in_ct.transpose();
  const Eigen::Map<const Vector9> pull(pulled.data());
  const Eigen::Map<const Vector9> cofactor(along.cofactor.data());
  const double slope = along.at.slope_mpa;
  const Vector9 e_by_f =
      2.0 * along.volume.value * pull + along.volume.slope * along.square * cofactor;
  Matrix9 out = along.at.curvature_mpa * e_by_f * e_by_f.transpose();
  out += (2.0 * slope * along.volume.slope) *
         (pull * cofactor.transpose() + cofactor * pull.transpose());
  out += (slope * along.volume.curvature * along.square) * cofactor * cofactor.transpose();
  // |F a|^2 has the second derivative 2 (a a^T) in each row of F.
  const Eigen::Vector3d& a = fibres.direction_in_ct;
  for (int column = 0; column < 3; ++column) {
    for (int other = 0; other < 3; ++other) {
      out.block<3, 3>(3 * column, 3 * other).diagonal().array() +=
          2.0 * slope * along.volume.value * a[column] * a[other];
    }
  }
  AddDeterminantCurvature(f, slope * along.volume.slope * along.square, out);
  return out;
}

}  // namespace acus::mechanics
