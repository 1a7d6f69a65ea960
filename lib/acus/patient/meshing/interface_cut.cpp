#include "acus/patient/meshing/interface_cut.h"

#include <algorithm>
#include <set>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::meshing {
namespace {

using MaterialSet = std::uint64_t;  ///< One bit each.
constexpr MaterialSet BitOf(int material) {
  return MaterialSet{1} << material;
}

constexpr double kSnapShare = 0.35;     ///< Of an edge: nearer cuts pull the node onto themselves.
constexpr double kSnapAngleDeg = 12.0;  ///< A node stays if moving it would make angles below this.
constexpr double kNearestCut = 0.08;    ///< Of an edge: a cut is kept so far from both ends.
constexpr int kMostDivisions = 2;       ///< Of one original edge and its parts.

struct Cut {
  Eigen::Vector3d place;
  double share = 0.5;  ///< Of the edge from a to b.
  MaterialSet materials = 0;
};

class Cutter {
 public:
  Cutter(TetraEditor& editor, const MaterialField& field) : editor_(editor), field_(field) {
    materials_.resize(editor.num_nodes());
    for (int n = 0; n < editor.num_nodes(); ++n) {
      materials_[n] = BitOf(field.MaterialAt(editor.node(n)));
    }
  }

  void Snap() {
    for (int t = 0; t < editor_.num_slots(); ++t) editor_.set_material(t, 1);  // For their scores.
    const double limit = mesh::ScoreOfDegrees(kSnapAngleDeg);
    for (int n = 0; n < editor_.num_nodes(); ++n) {
      Cut nearest;
      double best_mm = 1e300;
      for (const int other : editor_.NodesAround(n)) {
        if (!IsCut(n, other)) continue;
        const Cut cut = FindCut(n, other);
        const double distance_mm = (cut.place - editor_.node(n)).norm();
        if (cut.share > kSnapShare || distance_mm >= best_mm) continue;
        best_mm = distance_mm;
        nearest = cut;
      }
      if (best_mm == 1e300) continue;
      const Eigen::Vector3d before = editor_.node(n);
      editor_.set_node(n, nearest.place);
      if (editor_.StarScore(n) < limit) {
        editor_.set_node(n, before);
      } else {
        materials_[n] |= nearest.materials;
      }
    }
  }

  void Split() {
    std::set<std::pair<int, int>> open;
    for (int t = 0; t < editor_.num_slots(); ++t) {
      const auto& c = editor_.tetrahedron(t);
      for (int i = 0; i < 3; ++i) {
        for (int j = i + 1; j < 4; ++j) {
          if (IsCut(c[i], c[j])) open.insert(std::minmax(c[i], c[j]));
        }
      }
    }
    std::vector<int> depth(editor_.num_nodes(), 0);
    while (!open.empty()) {
      const auto [a, b] = *open.begin();
      open.erase(open.begin());
      const int depth_here = std::max(depth[a], depth[b]) + 1;
      // Where three materials meet there is always one more edge to divide: they meet about there.
      if (depth_here > kMostDivisions) continue;
      const Cut cut = FindCut(a, b);
      const int middle = editor_.SplitEdge(a, b, cut.place);
      materials_.push_back(cut.materials);
      depth.push_back(depth_here);
      for (const int other : editor_.NodesAround(middle)) {
        if (IsCut(middle, other)) open.insert(std::minmax(middle, other));
      }
    }
  }

  void Label() {
    for (int t = 0; t < editor_.num_slots(); ++t) {
      if (!editor_.is_alive(t)) continue;
      const auto& c = editor_.tetrahedron(t);
      MaterialSet allowed = ~MaterialSet{0};
      MaterialSet any = 0;
      for (const int n : c) {
        allowed &= materials_[n];
        any |= materials_[n];
      }
      editor_.set_material(t, Fullest(editor_.CornersOf(c), allowed != 0 ? allowed : any));
    }
  }

 private:
  bool IsCut(int a, int b) const { return (materials_[a] & materials_[b]) == 0; }

  Cut FindCut(int a, int b) const {
    const Eigen::Vector3d from = editor_.node(a);
    const Eigen::Vector3d way = editor_.node(b) - from;
    const int near = field_.MaterialAt(from);
    int far = field_.MaterialAt(from + way);
    double low = 0.0;
    double high = 1.0;
    for (int step = 0; step < 12; ++step) {
      const double middle = 0.5 * (low + high);
      const int there = field_.MaterialAt(from + middle * way);
      if (there == near) {
        low = middle;
      } else {
        high = middle;
        far = there;
      }
    }
    Cut out;
    out.share = std::clamp(0.5 * (low + high), kNearestCut, 1.0 - kNearestCut);
    out.place = from + out.share * way;
    out.materials = BitOf(near) | BitOf(far);
    // An end on an interface may have either material; the cut must join both ends.
    if ((out.materials & materials_[a]) == 0) out.materials |= materials_[a];
    return out;
  }

  std::uint8_t Fullest(const mesh::Corners& x, MaterialSet allowed) const {
    const Eigen::Vector3d centre = 0.25 * (x[0] + x[1] + x[2] + x[3]);
    int best = 0;
    double best_value = -1e300;
    for (int m = 0; m < field_.num_materials(); ++m) {
      if ((allowed & BitOf(m)) == 0) continue;
      double value = field_.Value(centre, m);
      for (const Eigen::Vector3d& corner : x) value += field_.Value(0.5 * (centre + corner), m);
      if (value > best_value) {
        best_value = value;
        best = m;
      }
    }
    return static_cast<std::uint8_t>(best);
  }

  TetraEditor& editor_;
  const MaterialField& field_;
  std::vector<MaterialSet> materials_;  ///< By node: where it lies, both sides if on an interface.
};

}  // namespace

void CutAtInterfaces(TetraEditor& editor, const MaterialField& field) {
  ACUS_ASSERT(field.num_materials() <= 64);
  Cutter cutter(editor, field);
  cutter.Snap();
  cutter.Split();
  cutter.Label();
}

}  // namespace acus::meshing
