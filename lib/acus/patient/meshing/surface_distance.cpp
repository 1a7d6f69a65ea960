#include "acus/patient/meshing/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "acus/base/core/parallel.h"
#include "acus/data/mesh/quality.h"
#include "acus/data/mesh/triangle_distance.h"

namespace acus::meshing {
namespace {

constexpr double kFarthest = 64.0;       ///< Voxels or mm; farther counts as this.
constexpr std::size_t kSamples = 40000;  ///< About, per tissue and direction.
constexpr int kPiece = 1024;

/// A face between voxel `at` and the next one along `axis`; at[axis] may be -1: the first's near
/// face.
struct VoxelFace {
  std::array<std::int16_t, 3> at;
  std::int8_t axis;
};

/// Labels, with 0 beyond the volume, turned into yes and no for one tissue; 0 stands for the body.
struct Region {
  const volume::LabelMap& labels;
  volume::Label label;
  bool Holds(int i, int j, int k) const {
    const volume::Label here = labels.geometry.Contains(i, j, k) ? labels.At(i, j, k) : 0;
    return label == 0 ? here != 0 : here == label;
  }
};

struct Sample {
  Eigen::Vector3d x;  ///< Grid frame, mm.
  double area_mm2;
};

/// Faces between voxels of each label and others; entry 0: between the body and the rest.
std::array<std::vector<VoxelFace>, 256> BoundaryFaces(const volume::LabelMap& labels) {
  std::array<std::vector<VoxelFace>, 256> out;
  const Eigen::Array3i& size = labels.geometry.size;
  for (int k = -1; k < size[2]; ++k) {
    for (int j = -1; j < size[1]; ++j) {
      for (int i = -1; i < size[0]; ++i) {
        const bool is_inside = i >= 0 && j >= 0 && k >= 0;
        const volume::Label here = is_inside ? labels.At(i, j, k) : 0;
        for (int d = 0; d < 3; ++d) {
          std::array<int, 3> next{i, j, k};
          ++next[d];
          const volume::Label there = labels.geometry.Contains(next[0], next[1], next[2])
                                          ? labels.At(next[0], next[1], next[2])
                                          : 0;
          if (here == there) continue;
          const VoxelFace face{{static_cast<std::int16_t>(i), static_cast<std::int16_t>(j),
                                static_cast<std::int16_t>(k)},
                               static_cast<std::int8_t>(d)};
          if (here != 0) out[here].push_back(face);
          if (there != 0) out[there].push_back(face);
          if (here == 0 || there == 0) out[0].push_back(face);
        }
      }
    }
  }
  return out;
}

std::vector<Sample> SamplesOf(const std::vector<VoxelFace>& faces, const Eigen::Array3d& spacing) {
  std::vector<Sample> out;
  const std::size_t stride = faces.size() / kSamples + 1;
  for (std::size_t n = stride / 2; n < faces.size(); n += stride) {
    const VoxelFace& face = faces[n];
    Eigen::Vector3d x;
    for (int d = 0; d < 3; ++d) x[d] = (face.at[d] + (d == face.axis ? 0.5 : 0.0)) * spacing[d];
    out.push_back({x, spacing.prod() / spacing[face.axis]});
  }
  return out;
}

/// The faces of the mesh that have a tissue on one side only, as corners (three columns each, grid
/// frame) by label; entry 0: the faces without a neighbour.
std::array<std::vector<Eigen::Vector3d>, 256> MeshFaces(const Eigen::Matrix3Xd& nodes,
                                                        const mesh::TetraMesh& mesh) {
  struct Face {
    std::array<int, 3> nodes;
    volume::Label tissue;
  };
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tissue.size());
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    for (int c = 0; c < 4; ++c) {
      Face face{{}, mesh.tissue[static_cast<std::size_t>(t)]};
      for (int i = 0; i < 3; ++i) face.nodes[i] = mesh.tetrahedra((c + 1 + i) & 3, t);
      std::ranges::sort(face.nodes);
      faces.push_back(face);
    }
  }
  std::ranges::sort(faces, {}, &Face::nodes);
  std::array<std::vector<Eigen::Vector3d>, 256> out;
  const auto add = [&](int label, const Face& face) {
    for (const int n : face.nodes) out[label].push_back(nodes.col(n));
  };
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const bool is_shared = f + 1 < faces.size() && faces[f].nodes == faces[f + 1].nodes;
    if (!is_shared) {
      add(0, faces[f]);
      add(faces[f].tissue, faces[f]);
      continue;
    }
    if (faces[f].tissue != faces[f + 1].tissue) {
      add(faces[f].tissue, faces[f]);
      add(faces[f + 1].tissue, faces[f]);
    }
    ++f;
  }
  return out;
}

/// Centres of equal parts of each triangle.
std::vector<Sample> SamplesOf(const std::vector<Eigen::Vector3d>& corners) {
  const auto area_mm2 = [&](std::size_t t) {
    return 0.5 * (corners[t + 1] - corners[t]).cross(corners[t + 2] - corners[t]).norm();
  };
  double total = 0.0;
  for (std::size_t t = 0; t < corners.size(); t += 3) total += area_mm2(t);
  std::vector<Sample> out;
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    const double area = area_mm2(t);
    const double wanted = kSamples * area / std::max(total, 1e-12);
    const int n = std::clamp(static_cast<int>(std::lround(std::sqrt(wanted))), 1, 64);
    const auto place = [&](double u, double v) {
      return Eigen::Vector3d(corners[t] + u / n * (corners[t + 1] - corners[t]) +
                             v / n * (corners[t + 2] - corners[t]));
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        out.push_back({place(i + 1.0 / 3.0, j + 1.0 / 3.0), area / (n * n)});
        if (i + j + 1 < n) out.push_back({place(i + 2.0 / 3.0, j + 2.0 / 3.0), area / (n * n)});
      }
    }
  }
  return out;
}

/// Distance of x to the nearest face between voxels inside and outside, with axis d measured in
/// units of unit_mm[d]: all faces within a box around x are looked at, until none outside the box
/// can be nearer.
double DistanceToBoundary(const Region& region, const Eigen::Vector3d& x,
                          const Eigen::Array3d& unit_mm) {
  const Eigen::Array3d spacing = region.labels.geometry.spacing_mm;
  const Eigen::Array3d voxel = spacing / unit_mm;  // Size of a voxel in those units.
  const Eigen::Array3d place = x.array() / spacing;
  const Eigen::Array3i centre = place.round().cast<int>();
  double best = kFarthest * kFarthest;
  for (double reach = voxel.minCoeff(); reach < 2.0 * kFarthest; reach *= 2.0) {
    const Eigen::Array3i radius = (reach / voxel).ceil().cast<int>();
    const Eigen::Array3i from = (centre - radius).max(-1);
    const Eigen::Array3i to = (centre + radius).min(region.labels.geometry.size);
    for (int k = from[2]; k <= to[2]; ++k) {
      for (int j = from[1]; j <= to[1]; ++j) {
        bool here = region.Holds(from[0], j, k);
        for (int i = from[0]; i <= to[0]; ++i) {
          const std::array<bool, 3> next{region.Holds(i + 1, j, k), region.Holds(i, j + 1, k),
                                         region.Holds(i, j, k + 1)};
          const Eigen::Array3d off = place - Eigen::Array3d(i, j, k);
          for (int d = 0; d < 3; ++d) {
            if (next[d] == here) continue;
            Eigen::Array3d gap = (off.abs() - 0.5).max(0.0);
            gap[d] = off[d] - 0.5;
            best = std::min(best, (gap * voxel).square().sum());
          }
          here = next[0];
        }
      }
    }
    if (best <= reach * reach) break;
  }
  return std::sqrt(best);
}

struct Statistics {
  double mean = 0.0;
  double p95 = 0.0;
};

template <typename Distance>
Statistics Measure(const std::vector<Sample>& samples, int num_threads, const Distance& distance) {
  std::vector<std::pair<double, double>> found(samples.size());  // Distance, area.
  const int count = static_cast<int>(samples.size());
  ParallelFor((count + kPiece - 1) / kPiece, num_threads, [&](int piece) {
    for (int n = piece * kPiece; n < std::min(count, (piece + 1) * kPiece); ++n) {
      found[n] = {distance(samples[n].x), samples[n].area_mm2};
    }
  });
  std::ranges::sort(found);
  Statistics out;
  double total = 0.0;
  for (const auto& [value, area] : found) {
    total += area;
    out.mean += area * value;
  }
  out.mean /= std::max(total, 1e-300);
  double below = 0.0;
  for (const auto& [value, area] : found) {
    below += area;
    out.p95 = value;
    if (below >= 0.95 * total) break;
  }
  return out;
}

/// The larger of both directions.
Statistics Symmetric(const Region& region, const std::vector<Sample>& on_map,
                     const std::vector<Sample>& on_mesh,
                     const std::vector<Eigen::Vector3d>& corners, const Eigen::Array3d& unit_mm,
                     int num_threads) {
  Eigen::Matrix3Xd scaled(3, static_cast<Eigen::Index>(corners.size()));
  for (std::size_t n = 0; n < corners.size(); ++n) {
    scaled.col(static_cast<Eigen::Index>(n)) = corners[n].array() / unit_mm;
  }
  const mesh::TriangleDistance triangles(std::move(scaled));
  const Statistics there = Measure(on_map, num_threads, [&](const Eigen::Vector3d& x) {
    return triangles.At((x.array() / unit_mm).matrix(), kFarthest);
  });
  const Statistics back = Measure(on_mesh, num_threads, [&](const Eigen::Vector3d& x) {
    return DistanceToBoundary(region, x, unit_mm);
  });
  return {std::max(there.mean, back.mean), std::max(there.p95, back.p95)};
}

}  // namespace

std::vector<SurfaceDistance> MeasureSurfaceDistances(const volume::LabelMap& labels,
                                                     const mesh::TetraMesh& mesh, int num_threads) {
  const volume::Geometry& g = labels.geometry;
  ACUS_REQUIRE(g.size.maxCoeff() < 32767, "a label map of ", g.size.maxCoeff(),
               " voxels along an axis is too long; allowed: 32766");
  const Eigen::Matrix3Xd nodes = g.direction.transpose() * (mesh.nodes_mm.colwise() - g.origin_mm);
  const auto map_faces = BoundaryFaces(labels);
  const auto mesh_faces = MeshFaces(nodes, mesh);
  std::vector<SurfaceDistance> out;
  for (int l = 0; l < 256; ++l) {
    if (map_faces[l].empty()) continue;
    SurfaceDistance entry;
    entry.label = static_cast<volume::Label>(l);
    if (mesh_faces[l].empty()) {
      entry.mean_mm = entry.p95_mm = entry.p95_voxels = std::numeric_limits<double>::infinity();
      out.push_back(entry);
      continue;
    }
    const Region region{labels, entry.label};
    const auto on_map = SamplesOf(map_faces[l], g.spacing_mm);
    const auto on_mesh = SamplesOf(mesh_faces[l]);
    const auto in_units = [&](const Eigen::Array3d& unit_mm) {
      return Symmetric(region, on_map, on_mesh, mesh_faces[l], unit_mm, num_threads);
    };
    const Statistics in_mm = in_units(Eigen::Array3d::Ones());
    entry.mean_mm = in_mm.mean;
    entry.p95_mm = in_mm.p95;
    entry.p95_voxels = in_units(g.spacing_mm).p95;
    entry.num_samples = on_map.size() + on_mesh.size();
    out.push_back(entry);
  }
  return out;
}

}  // namespace acus::meshing
