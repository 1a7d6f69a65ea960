// Sums over entries of a compliance, for either storage. Private to this module.
#pragma once

#include <Eigen/Core>

#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/tissue/contact_system.h"

namespace acus::tissue {

/// Displacements of one place by unit forces on another, CT axes, mm/N.
template <class T>
Eigen::Matrix3d SumBetween(const mechanics::Compliance& compliance, const ContactPlace& a,
                           const ContactPlace& b) noexcept {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < a.num_rows; ++i) {
    const T* x = compliance.Values<T>(3 * a.row[i]);
    const T* y = compliance.Values<T>(3 * a.row[i] + 1);
    const T* z = compliance.Values<T>(3 * a.row[i] + 2);
    for (int j = 0; j < b.num_rows; ++j) {
      const int column = 3 * b.row[j];
      const double weight = a.weight[i] * b.weight[j];
      for (int d = 0; d < 3; ++d) {
        sum(0, d) += weight * static_cast<double>(x[column + d]);
        sum(1, d) += weight * static_cast<double>(y[column + d]);
        sum(2, d) += weight * static_cast<double>(z[column + d]);
      }
    }
  }
  return sum;
}

/// Displacement of one node by 1 N along a direction, spread over a place.
template <class T>
Eigen::Vector3d SumAtNode(const mechanics::Compliance& compliance, int row,
                          const ContactPlace& place, const Eigen::Vector3d& direction) noexcept {
  Eigen::Vector3d sum;
  for (int axis = 0; axis < 3; ++axis) {
    const T* values = compliance.Values<T>(3 * row + axis);
    double moved = 0.0;
    for (int i = 0; i < place.num_rows; ++i) {
      const T* at = values + 3 * place.row[i];
      moved += place.weight[i] * (direction[0] * static_cast<double>(at[0]) +
                                  direction[1] * static_cast<double>(at[1]) +
                                  direction[2] * static_cast<double>(at[2]));
    }
    sum[axis] = moved;
  }
  return sum;
}

/// Compliance of one place with itself, along a direction: half of the blocks, as the compliance is
/// symmetric.
template <class T>
double SumWithin(const mechanics::Compliance& compliance, const ContactPlace& place,
                 const Eigen::Vector3d& direction) noexcept {
  double sum = 0.0;
  for (int i = 0; i < place.num_rows; ++i) {
    const T* x = compliance.Values<T>(3 * place.row[i]);
    const T* y = compliance.Values<T>(3 * place.row[i] + 1);
    const T* z = compliance.Values<T>(3 * place.row[i] + 2);
    for (int j = 0; j <= i; ++j) {
      const int column = 3 * place.row[j];
      double block = 0.0;
      for (int d = 0; d < 3; ++d) {
        block += direction[d] * (direction[0] * static_cast<double>(x[column + d]) +
                                 direction[1] * static_cast<double>(y[column + d]) +
                                 direction[2] * static_cast<double>(z[column + d]));
      }
      sum += (i == j ? 1.0 : 2.0) * place.weight[i] * place.weight[j] * block;
    }
  }
  return sum;
}

}  // namespace acus::tissue
