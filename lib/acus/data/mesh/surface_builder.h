// Collects nodes and triangles of unknown number into a Surface.
#pragma once

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/data/mesh/surface.h"

namespace acus::mesh {

class SurfaceBuilder {
 public:
  int num_nodes() const { return static_cast<int>(nodes_.size() / 3); }

  int AddNode(double x, double y, double z) {
    nodes_.insert(nodes_.end(), {x, y, z});
    return num_nodes() - 1;
  }
  /// The node at exactly this place; made if there is none.
  int AddSharedNode(double x, double y, double z) {
    const auto key = std::make_tuple(x + 0.0, y + 0.0, z + 0.0);  // -0 and 0 are one place.
    const auto [entry, is_new] = by_place_.try_emplace(key, num_nodes());
    if (is_new) AddNode(x, y, z);
    return entry->second;
  }
  void AddTriangle(int a, int b, int c) { triangles_.insert(triangles_.end(), {a, b, c}); }

  /// A polygon with corners `corners`, as a fan. Indices are checked in Finish().
  void AddPolygon(const std::vector<long long>& corners, const std::string& where) {
    ACUS_REQUIRE(corners.size() >= 3, where, ": a face has ", corners.size(),
                 " corners; it needs at least 3");
    for (const long long corner : corners) {
      ACUS_REQUIRE(corner >= 0 && corner <= 0x7fffffff, where, ": node number ", corner,
                   " is out of range");
    }
    for (std::size_t i = 2; i < corners.size(); ++i) {
      AddTriangle(static_cast<int>(corners[0]), static_cast<int>(corners[i - 1]),
                  static_cast<int>(corners[i]));
    }
  }

  /// @throws InputError if there is no triangle or one names a node that does not exist.
  Surface Finish(const std::string& label) const {
    ACUS_REQUIRE(!triangles_.empty(), label, ": holds no triangle; a surface is needed");
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      ACUS_REQUIRE(triangles_[i] >= 0 && triangles_[i] < num_nodes(), label, ": triangle ", i / 3,
                   " names node ", triangles_[i], ", but there are ", num_nodes(),
                   " nodes; is the file cut off?");
    }
    Surface out;
    out.nodes_mm = Eigen::Map<const Eigen::Matrix3Xd>(nodes_.data(), 3, num_nodes());
    out.triangles = Eigen::Map<const Eigen::Matrix3Xi>(
        triangles_.data(), 3, static_cast<Eigen::Index>(triangles_.size() / 3));
    return out;
  }

 private:
  std::vector<double> nodes_;
  std::vector<int> triangles_;
  std::map<std::tuple<double, double, double>, int> by_place_;
};

}  // namespace acus::mesh
