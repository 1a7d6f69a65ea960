#include "acus/patient/meshing/improve.h"

#include <algorithm>
#include <cmath>

#include "acus/patient/meshing/local_changes.h"

namespace acus::meshing {
namespace {

/// Tries everything on tetrahedron t, until it is gone or good.
bool Treat(int t, LocalChanges& changes, TetraEditor& editor, double goal) {
  const TetraEditor::Tetrahedron c = editor.tetrahedron(t);
  bool is_better = false;
  const auto is_done = [&] {
    return !editor.is_alive(t) || editor.tetrahedron(t) != c || editor.material(t) == 0 ||
           editor.Score(t) >= goal;
  };
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      is_better |= changes.RemoveEdge(c[i], c[j]);
      if (is_done()) return is_better;
    }
  }
  for (int i = 0; i < 4; ++i) {
    is_better |= changes.SwapFace(t, i);
    if (is_done()) return is_better;
  }
  for (const int n : c) {
    is_better |= changes.MoveNode(n);
    if (is_done()) return is_better;
  }
  for (const int a : c) {
    for (const int b : c) {
      if (a == b) continue;
      is_better |= changes.Collapse(a, b);
      if (is_done()) return is_better;
    }
  }
  return changes.GiveAway(t) || is_better;
}

struct Progress {
  std::size_t num_bad = 0;
  bool is_better = false;
};

Progress ImproveOnce(TetraEditor& editor, LocalChanges& changes, double goal) {
  std::vector<std::pair<double, int>> bad;
  for (int t = 0; t < editor.num_slots(); ++t) {
    if (!editor.is_alive(t)) continue;
    const double score = editor.Score(t);
    if (score < goal) bad.emplace_back(score, t);
  }
  std::ranges::sort(bad);
  Progress out{bad.size(), false};
  for (const auto& [score, t] : bad) {
    if (!editor.is_alive(t) || editor.Score(t) >= goal) continue;
    out.is_better |= Treat(t, changes, editor, goal);
  }
  return out;
}

}  // namespace

double Improve(TetraEditor& editor, const MaterialField* field, const ImproveSettings& settings,
               const RunContext& context) {
  LocalChanges changes(editor, field, settings.drift_share);
  const double goal = mesh::ScoreOfDegrees(settings.goal_deg);
  const int tight_passes = settings.max_passes / 3;
  for (int pass = 0; pass < settings.max_passes; ++pass) {
    changes.set_loose(pass >= tight_passes);
    context.Checkpoint("improving elements", static_cast<double>(pass) / settings.max_passes);
    const Progress progress = ImproveOnce(editor, changes, goal);
    if (progress.num_bad == 0) break;
    if (!progress.is_better && pass >= tight_passes) break;
    if (!progress.is_better) pass = tight_passes - 1;
  }
  double least = 0.0;
  for (int t = 0; t < editor.num_slots(); ++t) {
    if (editor.is_alive(t)) least = std::min(least, editor.Score(t));
  }
  return mesh::DegreesOfScore(least);
}

void ReturnToInterfaces(TetraEditor& editor, const MaterialField& field, double floor_deg) {
  const double floor = mesh::ScoreOfDegrees(floor_deg);
  for (int n = 0; n < editor.num_nodes(); ++n) {
    if (editor.star(n).empty()) continue;
    const std::vector<std::uint8_t> materials = editor.MaterialsAt(n);
    if (materials.size() != 2) continue;
    const Eigen::Vector3d before = editor.node(n);
    Eigen::Vector3d target = before;
    const double reach_mm = 0.5 * MeanEdgeMm(editor, n);
    if (!field.Project(target, materials[0], materials[1], reach_mm)) continue;
    const double limit = std::min(floor, editor.StarScore(n));
    for (const double share : {1.0, 0.6, 0.3}) {
      editor.set_node(n, before + share * (target - before));
      if (editor.StarScore(n) >= limit) break;
      editor.set_node(n, before);
    }
  }
}

}  // namespace acus::meshing
