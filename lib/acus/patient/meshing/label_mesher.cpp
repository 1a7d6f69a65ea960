#include "acus/patient/meshing/label_mesher.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "acus/data/mesh/quality.h"
#include "acus/patient/meshing/body_mesh.h"
#include "acus/patient/meshing/improve.h"
#include "acus/patient/meshing/interface_cut.h"
#include "acus/patient/meshing/interface_shift.h"
#include "acus/patient/meshing/mesh_limits.h"
#include "acus/patient/meshing/specks.h"
#include "acus/patient/meshing/surface_groups.h"
#include "acus/patient/meshing/tetgen_calls.h"
#include "acus/patient/meshing/tissue_assignment.h"

namespace acus::meshing {
namespace {

constexpr double kGoalDeg =
    15.0;  ///< Improvement stops there; the margin over the limit requested.
constexpr double kFloorDeg = 13.0;  ///< Nodes return to their interface only above this.
constexpr int kVolumeRounds = 7;
constexpr int kBudgetRounds = 6;  ///< Divisions tried for a required number of nodes.
constexpr double kFirstGainMm = 12.0;
constexpr double kFullBudget = 0.93;
constexpr double kMentionedSpecks = 0.001;  ///< Of the body.
constexpr double kSpeckEdge = 0.5;  ///< Of the shortest edge requested: smaller cubes are specks.
constexpr int kAttempts = 5;        ///< Each with finer elements, where a limit was missed.
constexpr double kRefinement = 0.7;
constexpr double kFarOff = 3.0;  ///< Times the limit: finer elements would not help.
/// Nodes by which a finer mesh grows: between surface (2.0) and volume (2.9) for that refinement.
constexpr double kGrowth = 2.4;
constexpr double kMostNodesAgain =
    6e5;  ///< A larger mesh is made only if it is requested: minutes.

void Check(const volume::LabelMap& labels, const LabelMeshSettings& settings) {
  const ElementSizes& s = settings.sizes;
  for (const double size : {s.interface_mm, s.skin_mm, s.interior_mm}) {
    ACUS_REQUIRE(size >= 0.2 && size <= 500.0, "an element size of ", size,
                 " mm is out of range; allowed: 0.2 to 500");
  }
  if (s.corridor) {
    ACUS_REQUIRE(
        s.corridor->element_size_mm >= 0.2 && s.corridor->radius_mm > 0.0 &&
            s.corridor->from_mm.allFinite() && s.corridor->to_mm.allFinite(),
        "the corridor needs finite ends, a radius above 0 and elements of at least 0.2 mm");
  }
  ACUS_REQUIRE(settings.smoothing_mm >= 0.0 && settings.smoothing_mm <= 20.0, "smoothing of ",
               settings.smoothing_mm, " mm is out of range; allowed: 0 to 20");
  ACUS_REQUIRE(settings.min_dihedral_deg >= 0.0 && settings.min_dihedral_deg <= 20.0,
               "a smallest dihedral angle of ", settings.min_dihedral_deg,
               " degrees is out of range; allowed: 0 to 20");
  ACUS_REQUIRE(labels.voxels.size() == labels.geometry.num_voxels() && !labels.voxels.empty(),
               "the label map is empty");
  ACUS_REQUIRE(std::ranges::any_of(labels.voxels, [](auto l) { return l != 0; }),
               "the label map holds no tissue: every voxel is 0 (outside)");
}

SpeckLimits LimitsOf(const LabelMeshSettings& settings) {
  const ElementSizes& s = settings.sizes;
  double shortest_mm = std::min(s.interface_mm, s.skin_mm);
  if (s.corridor) shortest_mm = std::min(shortest_mm, s.corridor->element_size_mm);
  if (s.finest_mm > 0.0) shortest_mm = std::min(shortest_mm, s.finest_mm);
  return {.speck_mm3 = std::pow(kSpeckEdge * shortest_mm, 3),
          .island_share = settings.min_island_share};
}

class LabelMesher {
 public:
  /// @param gain_mm  Of ShapeLimit: where to begin, and what was found.
  LabelMesher(const volume::LabelMap& labels, const LabelMeshSettings& settings, double& gain_mm,
              const RunContext& context)
      : settings_(settings),
        context_(context),
        gain_mm_(gain_mm),
        all_mm3_(VolumesMm3(labels)),
        groups_(GroupsOf(labels, all_mm3_, settings)),
        cleaned_(WithoutSpecks(labels, groups_.material_of_label, LimitsOf(settings))),
        labels_(cleaned_.labels),
        map_mm3_(VolumesMm3(labels_)),
        field_(MakeField()) {
    // With nothing of the body left there is nothing to mesh.
    ACUS_REQUIRE(BodyMm3(map_mm3_) > 0.0,
                 "the body is smaller than the elements; choose smaller ones");
  }

  LabelMesh Run() {
    if (cleaned_.specks_ml > kMentionedSpecks * 1e-3 * BodyMm3(map_mm3_)) {
      context_.Warn(Message(cleaned_.specks_ml,
                            " ml in pieces that are smaller than the elements "
                            "go to the tissue around them"));
    }
    TetraEditor editor = Divide();
    ImproveSettings improve;
    improve.goal_deg = std::max(kGoalDeg, settings_.min_dihedral_deg + 2.0);
    Improve(editor, &field_, improve, context_);
    for (int round = 0; round < kVolumeRounds; ++round) {
      if (ShiftInterfaces(editor, TargetsMm3(), field_) < 0.002) break;
      ReturnToInterfaces(editor, field_, std::max(kFloorDeg, settings_.min_dihedral_deg + 1.0));
    }
    improve.max_passes *= 2;
    Improve(editor, &field_, improve, context_);
    LabelMesh out;
    out.dropped_ml = DropIslands(settings_.min_island_share, editor);
    AddBody(editor, out);
    Measure(out);
    return out;
  }

 private:
  MaterialField MakeField() const {
    const ElementSizes& s = settings_.sizes;
    double finest = std::min(s.interface_mm, s.skin_mm);
    if (s.corridor) finest = std::min(finest, s.corridor->element_size_mm);
    // Not to a share of the finest elements of all, of which there are few: memory.
    if (s.finest_mm > 0.0) finest = std::min(finest, 1.7 * s.finest_mm);
    const double padding = 1.5 * std::max(s.skin_mm, finest);
    context_.Checkpoint("smoothing labels", 0.0);
    return MaterialField(labels_, groups_.material_of_label, groups_.num_materials, 0.3 * finest,
                         settings_.smoothing_mm, padding, context_.num_threads);
  }

  /// The volume's own axes may be turned against LPS.
  Eigen::Vector3d GridFromCt(const Eigen::Vector3d& x) const {
    return labels_.geometry.direction.transpose() * (x - labels_.geometry.origin_mm);
  }

  /// The body divided and cut at interfaces; with finest_mm, the finest division within the
  /// required number of nodes, or the coarsest of all if that has more.
  TetraEditor Divide() {
    if (settings_.sizes.finest_mm <= 0.0) return Lattice({});
    const InterfaceShape shape(field_, BlocksOf(field_, settings_.sizes),
                               labels_.geometry.spacing_mm);
    const auto wanted = static_cast<double>(settings_.wanted_nodes);
    std::optional<TetraEditor> best;
    double too_fine_mm = 0.0;
    double gain_mm = gain_mm_;
    for (int round = 0; round < kBudgetRounds; ++round) {
      TetraEditor editor = Lattice({&shape, gain_mm});
      const auto nodes = static_cast<double>(NumBodyNodes(editor));
      if (nodes > wanted) {
        too_fine_mm = std::max(too_fine_mm, gain_mm);
      } else {
        best = std::move(editor);
        gain_mm_ = gain_mm;
        if (nodes > kFullBudget * wanted) break;
      }
      // Nodes go about as 1 / gain^1.6; never back to what was too fine.
      const double next = gain_mm * std::pow(nodes / (0.97 * wanted), 1.0 / 1.6);
      gain_mm = next > too_fine_mm ? next : 0.5 * (gain_mm + too_fine_mm);
    }
    if (best) return std::move(*best);
    TetraEditor coarsest = Lattice({});
    if (NumBodyNodes(coarsest) > settings_.wanted_nodes) {
      context_.Warn(Message("the element sizes alone give more than ", settings_.wanted_nodes,
                            " nodes (refinement/nodes); nothing is refined"));
    }
    return coarsest;
  }

  TetraEditor Lattice(const ShapeLimit& limit) const {
    ElementSizes sizes = settings_.sizes;
    if (sizes.corridor) {
      sizes.corridor->from_mm = GridFromCt(sizes.corridor->from_mm);
      sizes.corridor->to_mm = GridFromCt(sizes.corridor->to_mm);
    }
    const Eigen::Matrix3Xd points = LatticePoints(field_, sizes, limit, settings_.max_nodes);
    context_.Checkpoint("tetrahedra", 0.0);
    TetraEditor out(points, DelaunayTetrahedra(points, context_));
    context_.Checkpoint("cutting at interfaces", 0.3);
    CutAtInterfaces(out, field_);
    return out;
  }

  /// Target volume of each material; islands that will be dropped are part of it.
  std::vector<double> TargetsMm3() const {
    std::vector<double> out(groups_.num_materials, 0.0);
    for (int l = 1; l < 256; ++l) out[groups_.material_of_label[l]] += map_mm3_[l];
    return out;
  }

  void AddBody(const TetraEditor& editor, LabelMesh& out) const {
    mesh::TetraMesh& mesh = out.mesh;
    Eigen::Matrix3Xd in_grid_mm;
    mesh = BodyOf(editor, labels_.geometry, in_grid_mm);
    AssignTissues(labels_, groups_.material_of_label, in_grid_mm, context_.num_threads, mesh);
    mesh.fixed_nodes.assign(static_cast<std::size_t>(mesh.nodes_mm.cols()), 0);
    for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
      const auto& fixed = settings_.fixed_tissues;
      if (std::ranges::find(fixed, NameOf(labels_, mesh.tissue[t])) == fixed.end()) continue;
      for (int c = 0; c < 4; ++c) mesh.fixed_nodes[mesh.tetrahedra(c, t)] = 1;
    }
  }

  void Measure(LabelMesh& out) const {
    LabelVolumes mesh_mm3{};
    for (Eigen::Index t = 0; t < out.mesh.tetrahedra.cols(); ++t) {
      mesh_mm3[out.mesh.tissue[t]] += mesh::VolumeMm3(mesh::CornersOf(out.mesh, t));
    }
    for (int l = 1; l < 256; ++l) {
      if (all_mm3_[l] <= 0.0) continue;
      // With "all", what remains is one tissue, whose surface is what the others leave.
      int sharers = 0;
      for (int k = 1; k < 256; ++k) {
        sharers +=
            map_mm3_[k] > 0.0 && groups_.material_of_label[k] == groups_.material_of_label[l];
      }
      const bool is_conforming =
          sharers == 1 && (groups_.material_of_label[l] > 1 || AllConform(settings_));
      out.tissues.push_back({.label = static_cast<std::uint8_t>(l),
                             .name = NameOf(labels_, l),
                             .map_ml = all_mm3_[l] / 1000.0,
                             .target_ml = map_mm3_[l] / 1000.0,
                             .mesh_ml = mesh_mm3[l] / 1000.0,
                             .is_conforming = is_conforming});
    }
    out.body_map_ml = BodyMm3(all_mm3_) / 1000.0;
    out.body_target_ml = BodyMm3(map_mm3_) / 1000.0;
    out.body_mesh_ml = BodyMm3(mesh_mm3) / 1000.0;
    out.dropped_ml += cleaned_.islands_ml;
    out.specks_ml = cleaned_.specks_ml;
  }

  const LabelMeshSettings& settings_;
  const RunContext& context_;
  double& gain_mm_;
  LabelVolumes all_mm3_;  ///< As it was given.
  SurfaceGroups groups_;
  CleanedMap cleaned_;
  const volume::LabelMap& labels_;
  LabelVolumes map_mm3_;
  MaterialField field_;
};

}  // namespace

LabelMesh MeshLabelMap(const volume::LabelMap& labels, const LabelMeshSettings& settings,
                       const RunContext& context) {
  Check(labels, settings);
  LabelMeshSettings finer = settings;
  double gain_mm = kFirstGainMm;
  for (int attempt = 0;; ++attempt) {
    LabelMesh out = LabelMesher(labels, finer, gain_mm, context).Run();
    const std::string shortfall = Shortfall(out, settings);
    if (shortfall.empty()) {
      out.sizes = finer.sizes;
      return out;
    }
    const double nodes_again = kGrowth * static_cast<double>(out.mesh.nodes_mm.cols());
    if (attempt == kAttempts - 1 || nodes_again > kMostNodesAgain) {
      throw NoAnswerError(Message(shortfall, " with ", out.mesh.nodes_mm.cols(),
                                  " nodes; try smaller elements, another smoothing_mm, or wider "
                                  "limits in the config"));
    }
    // Far off, or not repaired by finer elements: the elements cannot hold it.
    const std::string thin = GiveUpThinTissues(out, attempt == 0 ? kFarOff : 1.0, finer);
    if (!thin.empty()) {
      context.Warn(Message(shortfall, "; meshing again without surfaces of their own for ", thin,
                           ", which are too thin for the elements: distinguished one by one"));
      continue;
    }
    if (finer.sizes.finest_mm > 0.0 && attempt == 0) {
      finer.wanted_nodes = static_cast<std::size_t>(1.5 * static_cast<double>(finer.wanted_nodes));
      context.Warn(Message(shortfall, "; meshing again with ", finer.wanted_nodes, " nodes"));
      continue;
    }
    finer.sizes.interface_mm *= kRefinement;
    finer.sizes.skin_mm = std::max(finer.sizes.interface_mm, finer.sizes.skin_mm * kRefinement);
    finer.smoothing_mm = std::min(finer.smoothing_mm, 0.2 * finer.sizes.interface_mm);
    context.Warn(Message(shortfall, "; meshing again with elements of ", finer.sizes.interface_mm,
                         " mm at interfaces"));
  }
}

void AddSurfaceDistances(const volume::LabelMap& labels, int num_threads, LabelMesh& mesh) {
  for (const SurfaceDistance& d : MeasureSurfaceDistances(labels, mesh.mesh, num_threads)) {
    if (d.label == 0) mesh.body_surface = d;
    for (TissueVolume& tissue : mesh.tissues) {
      if (tissue.label == d.label) tissue.surface = d;
    }
  }
}

}  // namespace acus::meshing
