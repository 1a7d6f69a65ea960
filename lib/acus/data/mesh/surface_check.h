// What is wrong with a triangle surface, said in plain words, and mending of the simple defects.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <string>
#include <vector>

#include "acus/data/mesh/surface.h"

namespace acus::mesh {

/// One kind of defect: how often, and where it was seen first.
struct Defect {
  std::size_t count = 0;
  Eigen::Vector3d first_mm = Eigen::Vector3d::Zero();
};

struct SurfaceReport {
  Eigen::Index num_nodes = 0;
  Eigen::Index num_triangles = 0;
  Eigen::Index num_edges = 0;
  Defect open_edges;              ///< Edges with one triangle: holes.
  Defect crowded_edges;           ///< Edges with more than two triangles: not a manifold.
  Defect crowded_nodes;           ///< Nodes where two sheets touch: not a manifold.
  Defect flipped_edges;           ///< Edges whose two triangles face different ways.
  Defect flat_triangles;          ///< A node twice, or no area.
  Defect duplicate_nodes;         ///< At exactly the place of another node.
  Defect duplicate_triangles;     ///< Of the same three nodes as another.
  Defect loose_nodes;             ///< Part of no triangle.
  Defect intersections;           ///< Pairs of triangles that cut each other.
  int num_components = 0;         ///< Joined by edges.
  Eigen::Index euler_number = 0;  ///< Nodes in use - edges + triangles; 2 for each sphere.
  double volume_mm3 = 0.0;        ///< Signed: negative if the surface faces inwards.

  bool is_closed() const { return open_edges.count == 0; }
  bool is_manifold() const { return crowded_edges.count == 0 && crowded_nodes.count == 0; }
  bool is_oriented() const { return flipped_edges.count == 0; }
  bool is_fit_for_meshing() const {
    return num_triangles > 0 && is_closed() && is_manifold() && is_oriented() &&
           intersections.count == 0 && flat_triangles.count == 0 && duplicate_nodes.count == 0;
  }

  /// Every defect as a sentence with its number and place; empty if there is none.
  std::vector<std::string> Sentences() const;
};

/// Examines everything. Intersections are found by a sweep over boxes: 100 000 triangles take about
/// a second. @pre triangles name nodes that exist; coordinates are finite.
SurfaceReport CheckSurface(const Surface& surface);

struct RepairLimits {
  double weld_share = 1e-6;  ///< Of the bounding box' diagonal: nodes nearer than this become one.
  int longest_hole = 60;     ///< Holes with more edges are left open.
  double folded_share = 0.01;  ///< Of the triangles: more that cut each other are left as they are.
};

struct Repair {
  Surface surface;
  std::vector<std::string> done;  ///< What was changed, as sentences.
};

/// Welds nodes, drops flat and doubled triangles and loose nodes, turns triangles the same way and
/// outwards, closes holes and smooths small folds in which triangles cut each other. What it cannot
/// repair, CheckSurface() of the result reports.
Repair RepairSurface(const Surface& surface, const RepairLimits& limits = {});

}  // namespace acus::mesh
