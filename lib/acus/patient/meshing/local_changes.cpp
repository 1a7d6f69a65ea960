#include "acus/patient/meshing/local_changes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace acus::meshing {
namespace {

constexpr double kLeastGain =
    1e-5;  ///< In score; keeps two changes from undoing each other forever.
constexpr double kLeastGainDeg = 0.1;
constexpr std::size_t kLongestRing = 7;

/// The 26 directions to the neighbours in a cube.
const std::array<Eigen::Vector3d, 26>& Directions() {
  static const std::array<Eigen::Vector3d, 26> directions = [] {
    std::array<Eigen::Vector3d, 26> out;
    int count = 0;
    for (int n = 0; n < 27; ++n) {
      if (n == 13) continue;
      out[count++] = Eigen::Vector3d(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1).normalized();
    }
    return out;
  }();
  return directions;
}

}  // namespace

double MeanEdgeMm(const TetraEditor& editor, int node) {
  double sum = 0.0;
  const std::vector<int> around = editor.NodesAround(node);
  for (const int other : around) sum += (editor.node(other) - editor.node(node)).norm();
  return around.empty() ? 0.0 : sum / static_cast<double>(around.size());
}

LocalChanges::LocalChanges(TetraEditor& editor, const MaterialField* field, double drift_share)
    : editor_(editor), field_(field), drift_share_(drift_share), is_on_hull_(editor.num_nodes()) {
  for (int t = 0; t < editor.num_slots(); ++t) {
    if (!editor.is_alive(t)) continue;
    for (int c = 0; c < 4; ++c) {
      if (editor.Neighbour(t, c) >= 0) continue;
      for (int i = 1; i < 4; ++i) is_on_hull_[editor.tetrahedron(t)[(c + i) & 3]] = true;
    }
  }
}

bool LocalChanges::Replace(const std::vector<int>& old, const std::vector<New>& fresh) {
  double old_least = 0.0;
  double volume = 0.0;
  for (const int t : old) {
    old_least = std::min(old_least, editor_.Score(t));
    volume += mesh::VolumeMm3(editor_.CornersOf(editor_.tetrahedron(t)));
  }
  double difference = -volume;
  for (const New& n : fresh) {
    if (editor_.Score(n.corners, n.material) < old_least + kLeastGain) return false;
    difference += mesh::VolumeMm3(editor_.CornersOf(n.corners));
  }
  if (std::abs(difference) > 1e-7 * volume) return false;  // Does not fill the same room.
  for (const int t : old) editor_.Remove(t);
  for (const New& n : fresh) editor_.Add(n.corners, n.material);
  return true;
}

/// Nodes around the edge, so that (a, b, ring[i], ring[i + 1]) is the i-th tetrahedron, with
/// positive volume. Empty if the edge is on the hull.
std::vector<int> LocalChanges::Ring(int a, int b, const std::vector<int>& around) const {
  std::vector<std::array<int, 2>> links;
  for (const int t : around) {
    std::array<int, 2> rest{};
    int count = 0;
    for (const int n : editor_.tetrahedron(t)) {
      if (n != a && n != b) rest[count++] = n;
    }
    if (mesh::VolumeMm3(editor_.CornersOf({a, b, rest[0], rest[1]})) < 0.0) {
      std::swap(rest[0], rest[1]);
    }
    links.push_back(rest);
  }
  std::vector<int> ring{links[0][0]};
  for (int next = links[0][1]; next != ring[0];) {
    ring.push_back(next);
    if (ring.size() > links.size()) return {};
    const auto link = std::ranges::find(links, next, [](const auto& l) { return l[0]; });
    if (link == links.end()) return {};
    next = (*link)[1];
  }
  return ring.size() == links.size() ? ring : std::vector<int>{};
}

/// Whether the quadrilateral of two triangles abc and abd is so flat that its diagonal may be c-d.
bool LocalChanges::IsFlat(int a, int b, int c, int d) const {
  const Eigen::Vector3d ab = editor_.node(b) - editor_.node(a);
  const Eigen::Vector3d cd = editor_.node(d) - editor_.node(c);
  const Eigen::Vector3d normal = ab.cross(cd);
  const double length = normal.norm();
  if (!(length > 0.0)) return false;
  const double gap_mm = std::abs(normal.dot(editor_.node(c) - editor_.node(a))) / length;
  return gap_mm <= drift_share_ * 0.5 * (ab.norm() + cd.norm());
}

bool LocalChanges::RemoveEdge(int a, int b) {
  const std::vector<int> around = editor_.AtEdge(a, b);
  if (around.size() < 3 || around.size() > kLongestRing) return false;
  const std::vector<int> ring = Ring(a, b, around);
  if (ring.empty()) return false;
  const int count = static_cast<int>(ring.size());
  std::vector<std::uint8_t> material(count);  // Of the tetrahedron between ring[i] and ring[i + 1].
  for (const int t : around) {
    for (int i = 0; i < count; ++i) {
      if (editor_.Has(t, ring[i]) && editor_.Has(t, ring[(i + 1) % count])) {
        material[i] = editor_.material(t);
      }
    }
  }
  std::vector<int> hinges;  // Where an interface meets the ring.
  for (int i = 0; i < count; ++i) {
    if (material[i] != material[(i + count - 1) % count]) hinges.push_back(i);
  }
  if (hinges.size() > 2 ||
      (hinges.size() == 2 && !IsFlat(a, b, ring[hinges[0]], ring[hinges[1]]))) {
    return false;
  }
  for (int first = 0; first < count; ++first) {
    if (!hinges.empty() && first != hinges[0] && first != hinges[1]) continue;
    std::vector<New> fresh;
    for (int i = 1; i + 1 < count; ++i) {
      const int r = ring[(first + i) % count];
      const int s = ring[(first + i + 1) % count];
      const std::uint8_t m = material[(first + i) % count];
      fresh.push_back({{ring[first], r, s, b}, m});
      fresh.push_back({{ring[first], s, r, a}, m});
    }
    if (Replace(around, fresh)) return true;
  }
  return false;
}

bool LocalChanges::SwapFace(int t, int c) {
  const int other = editor_.Neighbour(t, c);
  if (other < 0 || editor_.material(other) != editor_.material(t)) return false;
  const TetraEditor::Tetrahedron corners = editor_.tetrahedron(t);
  int far = -1;
  for (const int n : editor_.tetrahedron(other)) {
    if (std::ranges::find(corners, n) == corners.end()) far = n;
  }
  std::vector<New> fresh;
  for (int i = 0; i < 4; ++i) {
    if (i == c) continue;
    TetraEditor::Tetrahedron n = corners;  // The corner of the face yields to the far node.
    n[i] = far;
    fresh.push_back({n, editor_.material(t)});
  }
  return Replace({t, other}, fresh);
}

bool LocalChanges::MoveNode(int n) {
  if (is_on_hull_[n]) return false;
  const std::vector<std::uint8_t> materials = editor_.MaterialsAt(n);
  if (materials.size() > 1 && field_ == nullptr) return false;
  if (materials.size() == 1 && materials[0] == 0) return false;
  const Eigen::Vector3d start = editor_.node(n);
  const double edge_mm = MeanEdgeMm(editor_, n);
  Eigen::Vector3d best = start;
  double best_score = editor_.StarScore(n);
  const double first_score = best_score;
  const auto attempt = [&](Eigen::Vector3d x) {
    const bool is_free = materials.size() > 2 || (is_loose_ && materials.size() == 2);
    if (materials.size() == 2 && !is_free &&
        !field_->Project(x, materials[0], materials[1], 0.5 * edge_mm)) {
      return;
    }
    // Where three materials meet there is no surface to follow: the node keeps near.
    const double drift_mm = (is_loose_ ? 3.0 : 1.0) * drift_share_ * edge_mm;
    if (is_free && (x - start).norm() > drift_mm) return;
    editor_.set_node(n, x);
    const double score = editor_.StarScore(n);
    if (score > best_score + kLeastGain) {
      best_score = score;
      best = x;
    }
  };
  for (double step_mm = 0.3 * edge_mm; step_mm > 0.02 * edge_mm; step_mm *= 0.5) {
    const Eigen::Vector3d centre = best;
    for (const Eigen::Vector3d& direction : Directions()) attempt(centre + step_mm * direction);
  }
  editor_.set_node(n, best);
  // Smaller steps are kept, but are no reason to continue.
  return mesh::DegreesOfScore(best_score) > mesh::DegreesOfScore(first_score) + kLeastGainDeg;
}

bool LocalChanges::Collapse(int from, int to) {
  if (is_on_hull_[from]) return false;
  const std::vector<int> around = editor_.AtEdge(from, to);
  if (around.empty()) return false;
  const std::vector<std::uint8_t> materials = editor_.MaterialsAt(from);
  if (materials.size() > 1) {
    std::vector<std::uint8_t> at_edge;
    for (const int t : around) at_edge.push_back(editor_.material(t));
    std::ranges::sort(at_edge);
    at_edge.erase(std::unique(at_edge.begin(), at_edge.end()), at_edge.end());
    if (at_edge != materials) return false;  // The interface must hold the whole edge.
  }
  const std::vector<int> old = editor_.star(from);
  std::vector<New> fresh;
  std::array<double, 256> moved_mm3{};
  for (const int t : old) {
    TetraEditor::Tetrahedron corners = editor_.tetrahedron(t);
    moved_mm3[editor_.material(t)] -= mesh::VolumeMm3(editor_.CornersOf(corners));
    if (editor_.Has(t, to)) continue;
    std::ranges::replace(corners, from, to);
    moved_mm3[editor_.material(t)] += mesh::VolumeMm3(editor_.CornersOf(corners));
    fresh.push_back({corners, editor_.material(t)});
  }
  const double edge_mm = MeanEdgeMm(editor_, from);
  for (const double volume : moved_mm3) {
    if (std::abs(volume) > drift_share_ * edge_mm * edge_mm * edge_mm) return false;
  }
  return Replace(old, fresh);
}

bool LocalChanges::GiveAway(int t) {
  const std::uint8_t mine = editor_.material(t);
  const TetraEditor::Tetrahedron corners = editor_.tetrahedron(t);
  const mesh::Corners x = editor_.CornersOf(corners);
  std::array<int, 256> faces{};
  std::uint8_t taker = mine;
  double largest_mm2 = 0.0;
  double edge_mm = 0.0;
  for (int c = 0; c < 4; ++c) {
    const Eigen::Vector3d& p = x[(c + 1) & 3];
    largest_mm2 = std::max(largest_mm2, (x[(c + 2) & 3] - p).cross(x[(c + 3) & 3] - p).norm() / 2);
    edge_mm = std::max(edge_mm, (x[c] - p).norm());
    const int other = editor_.Neighbour(t, c);
    if (other < 0) return false;
    const std::uint8_t m = editor_.material(other);
    if (m != mine && ++faces[m] >= 2) taker = m;
  }
  if (taker == mine || 3.0 * mesh::VolumeMm3(x) > drift_share_ * edge_mm * largest_mm2)
    return false;
  editor_.set_material(t, taker);
  if (taker == 0) return true;
  // Its shape is as bad as before; it pays only if it can now be dissolved in its new material.
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      if (RemoveEdge(corners[i], corners[j])) return true;
    }
  }
  for (int i = 0; i < 4; ++i) {
    if (SwapFace(t, i)) return true;
  }
  editor_.set_material(t, mine);
  return false;
}

}  // namespace acus::meshing
