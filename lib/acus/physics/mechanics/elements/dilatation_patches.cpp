#include "acus/physics/mechanics/elements/dilatation_patches.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <tuple>

#include "acus/physics/mechanics/elements/face_neighbours.h"

namespace acus::mechanics {
namespace {

// A star is worth a patch if so much of it is free: first whole stars only, then what remains.
constexpr double kFreeShare[] = {1.0, 0.5};
constexpr int kSmallestPatch = 6;

/// All tetrahedra of one tissue at one node.
struct Star {
  int node = 0;
  std::vector<int> tetrahedra;
};

/// Rank of each node among all by place (z, then y, then x): the order in which ties are broken.
std::vector<int> RankByPlace(const Eigen::Matrix3Xd& nodes_mm) {
  std::vector<int> order(static_cast<std::size_t>(nodes_mm.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](int a, int b) {
    return std::tuple(nodes_mm(2, a), nodes_mm(1, a), nodes_mm(0, a), a) <
           std::tuple(nodes_mm(2, b), nodes_mm(1, b), nodes_mm(0, b), b);
  });
  std::vector<int> rank(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<int>(i);
  return rank;
}

class Packing {
 public:
  Packing(const mesh::TetraMesh& mesh, std::span<const int> tetrahedra)
      : mesh_(mesh),
        neighbours_(FaceNeighbours(mesh)),
        rank_(RankByPlace(mesh.nodes_mm)),
        patch_(static_cast<std::size_t>(mesh.tetrahedra.cols()), kNotOurs) {
    for (const int t : tetrahedra) patch_[t] = kFree;
    MakeStars(tetrahedra);
    for (const double share : kFreeShare) PackStars(share);
    JoinLeftovers(tetrahedra);
  }

  std::vector<std::vector<int>> Take() && { return std::move(patches_); }

 private:
  static constexpr int kFree = -1;
  static constexpr int kNotOurs = -2;
  struct Place {
    double touching;  ///< Share of the star's surface against what is taken; first if larger.
    int rank;         ///< Of the star.
    bool operator<(const Place& other) const {
      return std::tie(other.touching, rank) < std::tie(touching, other.rank);
    }
  };

  void MakeStars(std::span<const int> tetrahedra) {
    std::vector<std::tuple<int, int, int>> members;
    for (const int t : tetrahedra) {
      for (const int node : mesh_.tetrahedra.col(t)) {
        members.emplace_back(rank_[node], mesh_.tissue[t], t);
      }
    }
    std::ranges::sort(members);
    stars_at_node_.resize(rank_.size());
    for (std::size_t i = 0; i < members.size(); ++i) {
      const auto& [rank, tissue, t] = members[i];
      const bool is_new =
          i == 0 || std::get<0>(members[i - 1]) != rank || std::get<1>(members[i - 1]) != tissue;
      if (is_new) {
        const auto corners = mesh_.tetrahedra.col(t);
        const int node = *std::ranges::find_if(corners, [&](int c) { return rank_[c] == rank; });
        stars_at_node_[node].push_back(static_cast<int>(stars_.size()));
        stars_.push_back({node, {}});
      }
      stars_.back().tetrahedra.push_back(t);
    }
  }

  /// Share of the star's surface that touches no free tetrahedron of its tissue; -1 if too little
  /// of the star is free.
  double Touching(const Star& star, double free_share) const {
    int num_free = 0;
    for (const int t : star.tetrahedra) num_free += patch_[t] == kFree;
    const auto size = static_cast<double>(star.tetrahedra.size());
    if (num_free < kSmallestPatch || num_free < free_share * size) return -1.0;
    int touching = 0;
    int open = 0;
    for (const int t : star.tetrahedra) {
      if (patch_[t] != kFree) continue;
      for (const int next : neighbours_.col(t)) {
        const bool is_free =
            next >= 0 && patch_[next] == kFree && mesh_.tissue[next] == mesh_.tissue[t];
        touching += !is_free;
        open += is_free && !IsAt(next, star.node);
      }
    }
    // Torn stars that are more whole come first.
    return touching / std::max(1.0, static_cast<double>(touching + open)) +
           (num_free < size ? num_free / size : 1.0);
  }

  bool IsAt(int t, int node) const { return (mesh_.tetrahedra.col(t).array() == node).any(); }

  void PackStars(double free_share) {
    std::set<Place> queue;
    std::vector<double> queued(stars_.size(), -1.0);
    const auto update = [&](int s) {
      const double touching = Touching(stars_[s], free_share);
      if (touching == queued[s]) return;
      if (queued[s] >= 0.0) queue.erase({queued[s], s});
      if (touching >= 0.0) queue.insert({touching, s});
      queued[s] = touching;
    };
    for (std::size_t s = 0; s < stars_.size(); ++s) update(static_cast<int>(s));
    std::vector<int> nodes;
    while (!queue.empty()) {
      nodes.clear();
      const int chosen = queue.begin()->rank;
      for (const int t : TakeFree(stars_[chosen])) {
        for (const int node : mesh_.tetrahedra.col(t)) nodes.push_back(node);
        for (const int next : neighbours_.col(t)) {
          if (next < 0 || patch_[next] != kFree) continue;
          for (const int node : mesh_.tetrahedra.col(next)) nodes.push_back(node);
        }
      }
      std::ranges::sort(nodes);
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
      for (const int node : nodes) {
        for (const int s : stars_at_node_[node]) update(s);
      }
    }
  }

  /// Makes a patch of what is free of a star.
  const std::vector<int>& TakeFree(const Star& star) {
    std::vector<int>& patch = patches_.emplace_back();
    for (const int t : star.tetrahedra) {
      if (patch_[t] != kFree) continue;
      patch_[t] = static_cast<int>(patches_.size()) - 1;
      patch.push_back(t);
    }
    return patch;
  }

  /// Ranks of a tetrahedron's nodes: its place among all, whatever its number.
  std::array<int, 4> Key(int t) const {
    std::array<int, 4> key{};
    for (int c = 0; c < 4; ++c) key[c] = rank_[mesh_.tetrahedra(c, t)];
    std::ranges::sort(key);
    return key;
  }

  void JoinLeftovers(std::span<const int> tetrahedra) {
    std::vector<int> left;
    for (const int t : tetrahedra) {
      if (patch_[t] == kFree) left.push_back(t);
    }
    std::ranges::sort(left, {}, [&](int t) { return Key(t); });
    while (!left.empty()) {
      const std::size_t before = left.size();
      std::erase_if(left, [&](int t) {
        const int best = BestPatchBeside(t);
        if (best < 0) return false;
        patch_[t] = best;
        patches_[best].push_back(t);
        return true;
      });
      if (left.size() < before) continue;
      // None is beside a patch of its tissue: a tissue of few tetrahedra.
      patch_[left[0]] = static_cast<int>(patches_.size());
      patches_.push_back({left[0]});
      left.erase(left.begin());
    }
  }

  /// The small patch with many faces in common, -1 if there is none of the same tissue.
  int BestPatchBeside(int t) const {
    int best = -1;
    double best_score = 0.0;
    for (const int next : neighbours_.col(t)) {
      if (next < 0 || patch_[next] < 0 || mesh_.tissue[next] != mesh_.tissue[t]) continue;
      const int patch = patch_[next];
      int common = 0;
      for (const int other : neighbours_.col(t)) common += other >= 0 && patch_[other] == patch;
      const double score = static_cast<double>(patches_[patch].size()) - 4.0 * common;
      if (best < 0 || std::tie(score, patch) < std::tie(best_score, best)) {
        best = patch;
        best_score = score;
      }
    }
    return best;
  }

  const mesh::TetraMesh& mesh_;
  Eigen::Matrix4Xi neighbours_;
  std::vector<int> rank_;
  std::vector<int> patch_;   ///< Of each tetrahedron, kFree or kNotOurs.
  std::vector<Star> stars_;  ///< By rank of the node, then tissue.
  std::vector<std::vector<int>> stars_at_node_;
  std::vector<std::vector<int>> patches_;
};

}  // namespace

std::vector<std::vector<int>> DilatationPatches(const mesh::TetraMesh& mesh,
                                                std::span<const int> tetrahedra) {
  return Packing(mesh, tetrahedra).Take();
}

}  // namespace acus::mechanics
