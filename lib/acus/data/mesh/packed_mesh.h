// Meshes as bytes: how a child process hands them over, and what their hashes are of.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "acus/base/core/bytes.h"
#include "acus/base/core/error.h"

namespace acus::mesh {

/// Little endian on every machine, so that hashes are the same.
constexpr std::endian kPackedOrder = std::endian::little;

/// All values of a matrix, column by column.
template <typename T, int Rows>
std::span<const T> ValuesOf(const Eigen::Matrix<T, Rows, Eigen::Dynamic>& columns) {
  return {columns.data(), static_cast<std::size_t>(columns.size())};
}

/// An array as columns of `Rows` values. @pre the reader holds one.
template <typename T, int Rows>
Eigen::Matrix<T, Rows, Eigen::Dynamic> TakeColumns(core::ByteReader& in) {
  const std::vector<T> values = in.Array<T>();
  ACUS_ASSERT(in.ok() && values.size() % Rows == 0);
  return Eigen::Map<const Eigen::Matrix<T, Rows, Eigen::Dynamic>>(
      values.data(), Rows, static_cast<Eigen::Index>(values.size() / Rows));
}

}  // namespace acus::mesh
