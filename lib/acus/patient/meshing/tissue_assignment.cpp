#include "acus/patient/meshing/tissue_assignment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/data/mesh/quality.h"

namespace acus::meshing {
namespace {

struct Share {
  std::uint8_t label;
  float part;  ///< Of the tetrahedron's volume, in (0, 1].
};

/// Barycentric coordinates of the centres of gravity of a regular division: 35 points.
std::vector<Eigen::Vector4d> SamplePoints() {
  constexpr int kOrder = 4;
  std::vector<Eigen::Vector4d> out;
  for (int a = 0; a <= kOrder; ++a) {
    for (int b = 0; a + b <= kOrder; ++b) {
      for (int c = 0; a + b + c <= kOrder; ++c) {
        out.push_back((Eigen::Vector4d(a, b, c, kOrder - a - b - c).array() + 0.25) /
                      (kOrder + 1.0));
      }
    }
  }
  return out;
}

std::vector<Share> SharesOf(const volume::LabelMap& labels,
                            const MaterialOfLabel& material_of_label, const mesh::Corners& x,
                            std::uint8_t material, const std::vector<Eigen::Vector4d>& points) {
  const volume::Geometry& g = labels.geometry;
  std::array<int, 256> hits{};
  int total = 0;
  for (const Eigen::Vector4d& w : points) {
    const Eigen::Vector3d p = w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3];
    Eigen::Vector3i v;
    for (int d = 0; d < 3; ++d) {
      v[d] = std::clamp(static_cast<int>(std::lround(p[d] / g.spacing_mm[d])), 0, g.size[d] - 1);
    }
    const std::uint8_t label = labels.At(v[0], v[1], v[2]);
    if (material_of_label[label] != material) continue;
    ++hits[label];
    ++total;
  }
  std::vector<Share> out;
  for (int label = 0; label < 256 && total > 0; ++label) {
    if (hits[label] > 0) {
      out.push_back({static_cast<std::uint8_t>(label),
                     static_cast<float>(hits[label]) / static_cast<float>(total)});
    }
  }
  return out;
}

class Assignment {
 public:
  Assignment(const volume::LabelMap& labels, const MaterialOfLabel& material_of_label,
             mesh::TetraMesh& mesh)
      : mesh_(mesh), material_(mesh.tissue) {
    for (const std::uint8_t label : labels.voxels) target_mm3_[label] += 1.0;
    for (int l = 0; l < 256; ++l) {
      target_mm3_[l] *= labels.geometry.voxel_volume_mm3();
      const std::uint8_t m = material_of_label[l];
      if (l == 0 || target_mm3_[l] <= 0.0) continue;
      if (commonest_[m] == 0 || target_mm3_[l] > target_mm3_[commonest_[m]]) {
        commonest_[m] = static_cast<std::uint8_t>(l);
      }
    }
  }

  void Choose(const std::vector<std::vector<Share>>& shares, const std::vector<double>& volume) {
    std::array<double, 256> bonus{};
    std::vector<std::uint8_t> best = mesh_.tissue;
    double best_error = 1e300;
    for (int round = 0; round < 80; ++round) {
      std::array<double, 256> got_mm3{};
      for (std::size_t t = 0; t < shares.size(); ++t) {
        std::uint8_t choice = commonest_[material_[t]];
        double most = -1e300;
        for (const Share& share : shares[t]) {
          if (share.part + bonus[share.label] > most) {
            most = share.part + bonus[share.label];
            choice = share.label;
          }
        }
        mesh_.tissue[t] = choice;
        got_mm3[choice] += volume[t];
      }
      double error = 0.0;
      const double step = round < 40 ? 0.15 : 0.04;
      for (int l = 1; l < 256; ++l) {
        if (target_mm3_[l] <= 0.0) continue;
        const double lack = 1.0 - got_mm3[l] / target_mm3_[l];
        error += std::min(std::abs(lack), 1.0);
        bonus[l] = std::clamp(bonus[l] + step * std::clamp(lack, -1.0, 1.0), -1.0, 1.0);
      }
      if (error < best_error) {
        best_error = error;
        best = mesh_.tissue;
      }
    }
    mesh_.tissue = best;
  }

  std::uint8_t material(std::size_t t) const { return material_[t]; }

 private:
  mesh::TetraMesh& mesh_;
  std::vector<std::uint8_t> material_;
  std::array<double, 256> target_mm3_{};
  std::array<std::uint8_t, 256> commonest_{};  ///< By material: where no sample says more.
};

}  // namespace

void AssignTissues(const volume::LabelMap& labels, const MaterialOfLabel& material_of_label,
                   const Eigen::Matrix3Xd& nodes_in_grid_mm, int num_threads,
                   mesh::TetraMesh& mesh) {
  const std::vector<Eigen::Vector4d> points = SamplePoints();
  Assignment assignment(labels, material_of_label, mesh);
  const std::size_t count = mesh.tissue.size();
  std::vector<std::vector<Share>> shares(count);
  std::vector<double> volume(count);
  constexpr std::size_t kPiece = 4096;
  ParallelFor(static_cast<int>((count + kPiece - 1) / kPiece), num_threads, [&](int piece) {
    const std::size_t end = std::min(count, (piece + 1) * kPiece);
    for (std::size_t t = piece * kPiece; t < end; ++t) {
      mesh::Corners x;
      for (int c = 0; c < 4; ++c) {
        x[c] = nodes_in_grid_mm.col(mesh.tetrahedra(c, static_cast<Eigen::Index>(t)));
      }
      volume[t] = std::abs(mesh::VolumeMm3(x));
      shares[t] = SharesOf(labels, material_of_label, x, assignment.material(t), points);
    }
  });
  assignment.Choose(shares, volume);
}

}  // namespace acus::meshing
