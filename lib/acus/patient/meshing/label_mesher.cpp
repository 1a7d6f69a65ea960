#include "acus/patient/meshing/label_mesher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "acus/data/mesh/quality.h"
#include "acus/patient/meshing/improve.h"
#include "acus/patient/meshing/interface_cut.h"
#include "acus/patient/meshing/specks.h"
#include "acus/patient/meshing/tetgen_calls.h"
#include "acus/patient/meshing/tissue_assignment.h"

namespace acus::meshing {
namespace {

constexpr double kGoalDeg =
    15.0;  ///< Improvement stops there; the margin over the limit asked for.
constexpr double kFloorDeg = 13.0;  ///< Nodes return to their interface only above this.
constexpr int kVolumeRounds = 7;
constexpr int kBudgetRounds = 6;  ///< Divisions tried for a wanted number of nodes.
constexpr double kFirstGainMm = 12.0;
constexpr double kFullBudget = 0.93;
constexpr double kMentionedSpecks = 0.001;  ///< Of the body.
constexpr double kSpeckEdge = 0.5;  ///< Of the shortest edge asked for: smaller cubes are specks.
constexpr int kAttempts = 3;        ///< Each with finer elements, where a limit was missed.
constexpr double kRefinement = 0.7;
constexpr double kFarOff = 3.0;  ///< Times the limit: finer elements would not help.
/// Nodes by which a finer mesh grows: between surface (2.0) and volume (2.9) for that refinement.
constexpr double kGrowth = 2.4;
constexpr double kMostNodesAgain =
    6e5;  ///< A larger mesh is made only if it is asked for: minutes.

std::string NameOf(const volume::LabelMap& labels, int label) {
  const auto name = labels.names.find(static_cast<volume::Label>(label));
  return name != labels.names.end() ? name->second : "label " + std::to_string(label);
}

std::array<double, 256> MapVolumesMm3(const volume::LabelMap& labels) {
  std::array<std::size_t, 256> counts{};
  for (const volume::Label label : labels.voxels) ++counts[label];
  std::array<double, 256> out{};
  for (int l = 0; l < 256; ++l) {
    out[l] = static_cast<double>(counts[l]) * labels.geometry.voxel_volume_mm3();
  }
  return out;
}

bool AllConform(const LabelMeshSettings& settings) {
  return std::ranges::count(settings.conforming_tissues, "all") > 0;
}

/// Faces between voxels of `label` and voxels of each other label.
std::array<std::size_t, 256> TouchingFaces(const volume::LabelMap& labels, int label) {
  std::array<std::size_t, 256> out{};
  const Eigen::Array3i& size = labels.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const volume::Label here = labels.At(i, j, k);
        for (int d = 0; d < 3; ++d) {
          const Eigen::Array3i next(i + (d == 0), j + (d == 1), k + (d == 2));
          if ((next >= size).any()) continue;
          const volume::Label there = labels.At(next[0], next[1], next[2]);
          if (here == there) continue;
          if (here == label) ++out[there];
          if (there == label) ++out[here];
        }
      }
    }
  }
  return out;
}

/// Tissues without a surface of their own go with the conforming one that they touch most: a lesion
/// is then told apart within the liver, and both get their volumes.
void JoinNeighbours(const volume::LabelMap& labels, const std::vector<int>& joining,
                    MaterialOfLabel& materials) {
  for (const int label : joining) {
    const auto faces = TouchingFaces(labels, label);
    std::size_t most = 0;
    for (int other = 1; other < 256; ++other) {
      if (faces[other] <= most || std::ranges::count(joining, other) > 0) continue;
      most = faces[other];
      materials[label] = materials[other];
    }
  }
}

/// 0 outside, 1 all tissues that need no surface of their own, then the conforming ones. Where all
/// conform, the largest is 1: its surface is what the others leave.
MaterialOfLabel Materials(const volume::LabelMap& labels, const std::array<double, 256>& map_mm3,
                          const LabelMeshSettings& settings, int& num_materials) {
  MaterialOfLabel out{};
  std::fill(out.begin() + 1, out.end(), std::uint8_t{1});
  num_materials = 2;
  const auto& wanted = settings.conforming_tissues;
  const bool all_conform = AllConform(settings);
  const auto largest = std::max_element(map_mm3.begin() + 1, map_mm3.end()) - map_mm3.begin();
  std::vector<int> joining;
  for (int l = 1; l < 256; ++l) {
    if (map_mm3[l] <= 0.0 || (all_conform && l == largest)) continue;
    if (!all_conform && std::ranges::count(wanted, NameOf(labels, l)) == 0) continue;
    if (std::ranges::count(settings.except_tissues, NameOf(labels, l)) > 0) {
      joining.push_back(l);
      continue;
    }
    ACUS_REQUIRE(num_materials < 64, "more than 62 conforming tissues; list fewer");
    out[l] = static_cast<std::uint8_t>(num_materials++);
  }
  JoinNeighbours(labels, joining, out);
  return out;
}

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

double BodyMm3(const std::array<double, 256>& volumes) {
  return std::accumulate(volumes.begin() + 1, volumes.end(), 0.0);
}

class LabelMesher {
 public:
  /// @param gain_mm  Of ShapeLimit: where to begin, and what was found.
  LabelMesher(const volume::LabelMap& labels, const LabelMeshSettings& settings, double& gain_mm,
              const RunContext& context)
      : settings_(settings),
        context_(context),
        gain_mm_(gain_mm),
        all_mm3_(MapVolumesMm3(labels)),
        material_of_label_(Materials(labels, all_mm3_, settings, num_materials_)),
        cleaned_(WithoutSpecks(labels, material_of_label_, LimitsOf(settings))),
        labels_(cleaned_.labels),
        map_mm3_(MapVolumesMm3(labels_)),
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
      if (ShiftInterfaces(editor) < 0.002) break;
      ReturnToInterfaces(editor, field_, std::max(kFloorDeg, settings_.min_dihedral_deg + 1.0));
    }
    improve.max_passes *= 2;
    Improve(editor, &field_, improve, context_);
    LabelMesh out;
    DropIslands(editor, out);
    Extract(editor, out);
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
    return MaterialField(labels_, material_of_label_, num_materials_, 0.3 * finest,
                         settings_.smoothing_mm, padding, context_.num_threads);
  }

  /// The volume's own axes may be turned against LPS.
  Eigen::Vector3d GridFromCt(const Eigen::Vector3d& x) const {
    return labels_.geometry.direction.transpose() * (x - labels_.geometry.origin_mm);
  }

  /// The body divided and cut at interfaces; with finest_mm, the finest division within the wanted
  /// number of nodes, or the coarsest of all if that has more.
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
      const double nodes = NodesOfBody(editor);
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
    if (NodesOfBody(coarsest) > wanted) {
      context_.Warn(Message("the element sizes alone give more than ", settings_.wanted_nodes,
                            " nodes (refinement/nodes); nothing is refined"));
    }
    return coarsest;
  }

  static double NodesOfBody(const TetraEditor& editor) {
    std::size_t count = 0;
    for (int n = 0; n < editor.num_nodes(); ++n) {
      count += std::ranges::any_of(editor.star(n), [&](int t) { return editor.material(t) != 0; });
    }
    return static_cast<double>(count);
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
    std::vector<double> out(num_materials_, 0.0);
    for (int l = 1; l < 256; ++l) out[material_of_label_[l]] += map_mm3_[l];
    return out;
  }

  /// Moves the field's interfaces so that the materials get their volumes. Largest relative error.
  double ShiftInterfaces(const TetraEditor& editor) {
    std::vector<double> volume(num_materials_, 0.0);
    std::vector<double> area(num_materials_, 0.0);
    // Volume per unit of offset: area over slope.
    std::vector<double> gain_mm3(num_materials_, 0.0);
    const double flattest = 0.5 / field_.spacing_mm().maxCoeff();
    for (int t = 0; t < editor.num_slots(); ++t) {
      if (!editor.is_alive(t)) continue;
      const int m = editor.material(t);
      const mesh::Corners x = editor.CornersOf(editor.tetrahedron(t));
      volume[m] += mesh::VolumeMm3(x);
      for (int c = 0; c < 4; ++c) {
        const int other = editor.Neighbour(t, c);
        if (other < 0 || editor.material(other) == m) continue;
        const Eigen::Vector3d& p = x[(c + 1) & 3];
        const double mm2 = 0.5 * (x[(c + 2) & 3] - p).cross(x[(c + 3) & 3] - p).norm();
        const Eigen::Vector3d middle = (p + x[(c + 2) & 3] + x[(c + 3) & 3]) / 3.0;
        area[m] += mm2;
        const double slope = field_.Gradient(middle, m, editor.material(other)).norm();
        gain_mm3[m] += mm2 / std::max(slope, flattest);
      }
    }
    const std::vector<double> target = TargetsMm3();
    double worst = 0.0;
    // The rest (1) follows from the others. Outside (0) is the body's total, turned round.
    const double body = std::accumulate(volume.begin() + 1, volume.end(), 0.0);
    const double body_target = std::accumulate(target.begin() + 1, target.end(), 0.0);
    for (int m = 0; m < num_materials_; ++m) {
      if (m == 1 || area[m] <= 0.0) continue;
      const double lack = m == 0 ? body - body_target : target[m] - volume[m];
      worst = std::max(worst, std::abs(lack) / (m == 0 ? body_target : target[m]));
      const double step_mm3 = std::clamp(1.3 * lack, -area[m], area[m]);  // 1 mm on average.
      const double offset = field_.offset(m) + step_mm3 / gain_mm3[m];
      field_.set_offset(m, std::clamp(offset, -0.8, 0.8));
    }
    return worst;
  }

  /// Empties the pieces of the body that are small and touch the rest with no face.
  void DropIslands(TetraEditor& editor, LabelMesh& out) const {
    std::vector<int> island(editor.num_slots(), -1);
    std::vector<double> volume;
    for (int seed = 0; seed < editor.num_slots(); ++seed) {
      if (!editor.is_alive(seed) || editor.material(seed) == 0 || island[seed] >= 0) continue;
      std::vector<int> open{seed};
      island[seed] = static_cast<int>(volume.size());
      volume.push_back(0.0);
      while (!open.empty()) {
        const int t = open.back();
        open.pop_back();
        volume.back() += mesh::VolumeMm3(editor.CornersOf(editor.tetrahedron(t)));
        for (int c = 0; c < 4; ++c) {
          const int other = editor.Neighbour(t, c);
          if (other < 0 || editor.material(other) == 0 || island[other] >= 0) continue;
          island[other] = island[seed];
          open.push_back(other);
        }
      }
    }
    ACUS_REQUIRE(!volume.empty(), "the body is smaller than the elements; choose smaller ones");
    const double limit =
        settings_.min_island_share * std::accumulate(volume.begin(), volume.end(), 0.0);
    for (int t = 0; t < editor.num_slots(); ++t) {
      if (editor.is_alive(t) && island[t] >= 0 && volume[island[t]] < limit) {
        out.dropped_ml += mesh::VolumeMm3(editor.CornersOf(editor.tetrahedron(t))) / 1000.0;
        editor.set_material(t, 0);
      }
    }
  }

  void Extract(const TetraEditor& editor, LabelMesh& out) const {
    std::vector<int> number(editor.num_nodes(), -1);
    std::vector<int> kept;
    std::vector<int> nodes;
    for (int t = 0; t < editor.num_slots(); ++t) {
      if (!editor.is_alive(t) || editor.material(t) == 0) continue;
      kept.push_back(t);
      for (const int n : editor.tetrahedron(t)) number[n] = 0;
    }
    for (int n = 0; n < editor.num_nodes(); ++n) {
      if (number[n] < 0) continue;
      number[n] = static_cast<int>(nodes.size());
      nodes.push_back(n);
    }
    mesh::TetraMesh& mesh = out.mesh;
    Eigen::Matrix3Xd in_grid(3, static_cast<Eigen::Index>(nodes.size()));
    for (std::size_t n = 0; n < nodes.size(); ++n) in_grid.col(n) = editor.node(nodes[n]);
    const Eigen::Matrix3d& direction = labels_.geometry.direction;
    mesh.nodes_mm = (direction * in_grid).colwise() + labels_.geometry.origin_mm;
    mesh.tetrahedra.resize(4, static_cast<Eigen::Index>(kept.size()));
    const bool is_mirrored = direction.determinant() < 0.0;
    for (std::size_t t = 0; t < kept.size(); ++t) {
      for (int c = 0; c < 4; ++c) mesh.tetrahedra(c, t) = number[editor.tetrahedron(kept[t])[c]];
      if (is_mirrored) std::swap(mesh.tetrahedra(0, t), mesh.tetrahedra(1, t));
      mesh.tissue.push_back(editor.material(kept[t]));
    }
    AssignTissues(labels_, material_of_label_, in_grid, context_.num_threads, mesh);
    mesh.fixed_nodes.assign(nodes.size(), 0);
    for (std::size_t t = 0; t < kept.size(); ++t) {
      const auto& fixed = settings_.fixed_tissues;
      if (std::ranges::find(fixed, NameOf(labels_, mesh.tissue[t])) == fixed.end()) continue;
      for (int c = 0; c < 4; ++c) mesh.fixed_nodes[mesh.tetrahedra(c, t)] = 1;
    }
  }

  void Measure(LabelMesh& out) const {
    std::array<double, 256> mesh_mm3{};
    for (Eigen::Index t = 0; t < out.mesh.tetrahedra.cols(); ++t) {
      mesh_mm3[out.mesh.tissue[t]] += mesh::VolumeMm3(mesh::CornersOf(out.mesh, t));
    }
    for (int l = 1; l < 256; ++l) {
      if (all_mm3_[l] <= 0.0) continue;
      // With "all", what is left is one tissue, whose surface is what the others leave.
      int sharers = 0;
      for (int k = 1; k < 256; ++k) {
        sharers += map_mm3_[k] > 0.0 && material_of_label_[k] == material_of_label_[l];
      }
      const bool is_conforming =
          sharers == 1 && (material_of_label_[l] > 1 || AllConform(settings_));
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
  std::array<double, 256> all_mm3_;  ///< As it was given.
  int num_materials_ = 2;
  MaterialOfLabel material_of_label_;
  CleanedMap cleaned_;
  const volume::LabelMap& labels_;
  std::array<double, 256> map_mm3_;
  MaterialField field_;
};

bool MissesVolume(double mesh_ml, double map_ml, const LabelMeshSettings& settings) {
  return std::abs(mesh_ml - map_ml) > settings.volume_tolerance * map_ml;
}

/// What the mesh misses, in words; empty if it is good.
std::string Shortfall(const LabelMesh& out, const LabelMeshSettings& settings) {
  const mesh::QualityReport quality = mesh::MeasureQuality(out.mesh);
  if (quality.num_inverted > 0 || quality.min_dihedral_deg < settings.min_dihedral_deg) {
    const Eigen::Vector3d& at = quality.worst_at_mm;
    return Message("the smallest dihedral angle is ", quality.min_dihedral_deg, " degrees at (",
                   at[0], ", ", at[1], ", ", at[2], ") mm; required: ", settings.min_dihedral_deg);
  }
  if (MissesVolume(out.body_mesh_ml, out.body_target_ml, settings)) {
    return Message("the body has ", out.body_mesh_ml, " ml in the mesh and ", out.body_target_ml,
                   " ml in the label map without loose islands");
  }
  for (const TissueVolume& tissue : out.tissues) {
    if (tissue.is_conforming && MissesVolume(tissue.mesh_ml, tissue.target_ml, settings)) {
      return Message(tissue.name, " has ", tissue.mesh_ml, " ml in the mesh and ", tissue.target_ml,
                     " ml in the label map");
    }
  }
  return {};
}

/// Takes the tissues whose volume is missed by more than `factor` limits from the conforming ones;
/// with "all" not the largest, which has what the others leave. Their names.
std::string GiveUpThinTissues(const LabelMesh& out, double factor, LabelMeshSettings& settings) {
  const auto largest = std::ranges::max_element(out.tissues, {}, &TissueVolume::map_ml);
  LabelMeshSettings wide = settings;
  wide.volume_tolerance *= factor;
  std::string names;
  for (const TissueVolume& tissue : out.tissues) {
    if (!tissue.is_conforming || (AllConform(settings) && tissue.label == largest->label) ||
        !MissesVolume(tissue.mesh_ml, tissue.target_ml, wide)) {
      continue;
    }
    settings.except_tissues.push_back(tissue.name);
    names += (names.empty() ? "" : ", ") + tissue.name;
  }
  return names;
}

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
    // Far off, or not mended by finer elements: the elements cannot hold it.
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
