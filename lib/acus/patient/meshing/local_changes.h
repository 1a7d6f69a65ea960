// The local changes that Improve() chooses from; each is kept only if it raises the least score.
#pragma once

#include <vector>

#include "acus/patient/meshing/material_field.h"
#include "acus/patient/meshing/tetra_editor.h"

namespace acus::meshing {

double MeanEdgeMm(const TetraEditor& editor, int node);

/// All return whether the mesh was changed, and refuse what is not possible at that place.
class LocalChanges {
 public:
  /// Nodes on the hull of the mesh stay where they are.
  LocalChanges(TetraEditor& editor, const MaterialField* field, double drift_share);

  /// Loose: nodes may leave their interface by three times the drift share, where nothing else
  /// helps.
  void set_loose(bool is_loose) { is_loose_ = is_loose; }

  /// Replaces the 3 to 7 tetrahedra around an edge by others without it. An interface that runs
  /// through the edge is turned with it, if it is nearly flat there.
  bool RemoveEdge(int a, int b);
  /// Replaces tetrahedron t and its neighbour opposite corner c by three around a new edge.
  bool SwapFace(int t, int c);
  /// Pattern search for the place with the best least score; interface nodes stay on theirs.
  bool MoveNode(int n);
  /// Moves node `from` into node `to`.
  bool Collapse(int from, int to);
  /// Gives a flat tetrahedron on an interface to the material on its other side.
  bool GiveAway(int t);

 private:
  struct New {
    TetraEditor::Tetrahedron corners;
    std::uint8_t material;
  };
  bool Replace(const std::vector<int>& old, const std::vector<New>& fresh);
  std::vector<int> Ring(int a, int b, const std::vector<int>& around) const;
  bool IsFlat(int a, int b, int c, int d) const;

  TetraEditor& editor_;
  const MaterialField* field_;
  double drift_share_;
  bool is_loose_ = false;
  std::vector<bool> is_on_hull_;  ///< Of the nodes that were there at the start; changes add none.
};

}  // namespace acus::meshing
