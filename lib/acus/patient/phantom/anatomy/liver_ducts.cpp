#include "acus/patient/phantom/anatomy/liver_ducts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/base/core/text_table.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using volume::Geometry;
using volume::Label;

constexpr int kSamplesEachWay = 4;  ///< Each way in a voxel.

/// Shape of a structure: < 0 inside, at most the distance to its surface outside, mm.
using LevelOfPoint = std::function<double(const Vector3d&)>;

/// A level and the box that holds its inside.
struct PutStructure {
  LevelOfPoint level;
  Eigen::AlignedBox3d bounds_mm;
};

PutStructure TubeOf(const DuctSegment& segment) {
  Eigen::AlignedBox3d box(segment.from_mm);
  box.extend(segment.to_mm);
  const Vector3d radius = Vector3d::Constant(segment.radius_mm);
  return {[segment](const Vector3d& p) { return segment.DistanceMm(p); },
          Eigen::AlignedBox3d(box.min() - radius, box.max() + radius)};
}

PutStructure EllipsoidOf(const Lesion& lesion) {
  const Vector3d radius = lesion.radius_mm.matrix();
  return {[lesion](const Vector3d& p) {
            const double unit = ((p - lesion.centre_mm).array() / lesion.radius_mm).matrix().norm();
            return (unit - 1.0) * lesion.radius_mm.minCoeff();
          },
          Eigen::AlignedBox3d(lesion.centre_mm - radius, lesion.centre_mm + radius)};
}

/// Calls `visit` for each voxel near a box.
void ForVoxelsNear(const Geometry& g, const Eigen::AlignedBox3d& box_mm,
                   const std::function<void(int, int, int)>& visit) {
  const Eigen::AlignedBox3d index = box_mm.transformed(g.index_from_ct());
  const Eigen::Array3i low = (index.min().array() - 1.0).floor().cast<int>().max(0);
  const Eigen::Array3i high = (index.max().array() + 1.0).ceil().cast<int>().min(g.size - 1);
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) visit(i, j, k);
    }
  }
}

/// The share of each voxel that lies in any of the structures, in 1 / kSamplesEachWay^3.
volume::Grid<std::uint8_t> Shares(const Geometry& g, const std::vector<PutStructure>& structures) {
  static_assert(kSamplesEachWay * kSamplesEachWay * kSamplesEachWay <= 64,
                "samples are bits of a word");
  volume::Grid<std::uint64_t> hits(g);
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  const double half_diagonal_mm = 0.5 * g.spacing_mm.matrix().norm();
  for (const PutStructure& structure : structures) {
    ForVoxelsNear(g, structure.bounds_mm, [&](int i, int j, int k) {
      const double centre = structure.level(ct_from_index * Vector3d(i, j, k));
      if (centre > half_diagonal_mm) return;
      std::uint64_t& bits = hits.At(i, j, k);
      for (int n = 0; n < kSamplesEachWay * kSamplesEachWay * kSamplesEachWay; ++n) {
        const Vector3d in_voxel(n % kSamplesEachWay, n / kSamplesEachWay % kSamplesEachWay,
                                n / (kSamplesEachWay * kSamplesEachWay));
        const Vector3d index =
            Vector3d(i, j, k) + ((in_voxel.array() + 0.5) / kSamplesEachWay - 0.5).matrix();
        if (structure.level(ct_from_index * index) < 0.0) bits |= std::uint64_t{1} << n;
      }
    });
  }
  volume::Grid<std::uint8_t> shares(g);
  for (std::size_t n = 0; n < shares.voxels.size(); ++n) {
    shares.voxels[n] = static_cast<std::uint8_t>(std::popcount(hits.voxels[n]));
  }
  return shares;
}

/// The voxels along the axes of a tree: each shares a face with the next one.
void MarkAxes(const std::vector<DuctSegment>& tree, volume::Grid<std::uint8_t>& mask) {
  const Geometry& g = mask.geometry;
  const Eigen::Affine3d index_from_ct = g.index_from_ct();
  const double step_mm = 0.25 * g.spacing_mm.minCoeff();
  for (const DuctSegment& segment : tree) {
    const Vector3d axis = segment.to_mm - segment.from_mm;
    const int steps = 1 + static_cast<int>(axis.norm() / step_mm);
    Eigen::Array3i at = (index_from_ct * segment.from_mm).array().round().cast<int>();
    mask.At(at[0], at[1], at[2]) = 1;
    for (int n = 1; n <= steps; ++n) {
      const Vector3d index = index_from_ct * Vector3d(segment.from_mm + axis * n / steps);
      const Eigen::Array3i next = index.array().round().cast<int>();
      for (int a = 0; a < 3; ++a) {
        if (at[a] == next[a]) continue;
        at[a] = next[a];
        mask.At(at[0], at[1], at[2]) = 1;
      }
    }
  }
}

void PutStructures(const volume::CtVolume& plain, const std::vector<PutStructure>& structures,
                   const std::vector<DuctSegment>& axes, const char* tissue, double hu,
                   LiverDucts& out) {
  if (structures.empty()) return;
  const auto shares = Shares(plain.geometry, structures);
  volume::Grid<std::uint8_t> on_axis(plain.geometry);
  MarkAxes(axes, on_axis);
  constexpr int kWhole = kSamplesEachWay * kSamplesEachWay * kSamplesEachWay;
  double whole_sum = 0.0, whole_count = 0.0, part_sum = 0.0, part_count = 0.0;
  for (std::size_t n = 0; n < shares.voxels.size(); ++n) {
    const double share = static_cast<double>(shares.voxels[n]) / kWhole;
    part_sum += share * plain.voxels[n];
    part_count += share;
    if (shares.voxels[n] < kWhole) continue;
    whole_sum += plain.voxels[n];
    whole_count += 1.0;
  }
  const double mean_hu = whole_count > 0.0  ? whole_sum / whole_count
                         : part_count > 0.0 ? part_sum / part_count
                                            : hu;
  const Label label = volume::LabelOf(tissue);
  out.labels.names[label] = tissue;
  for (std::size_t n = 0; n < shares.voxels.size(); ++n) {
    if (2 * shares.voxels[n] >= kWhole || on_axis.voxels[n] != 0) out.labels.voxels[n] = label;
    const double share = static_cast<double>(shares.voxels[n]) / kWhole;
    const double sum = std::round(out.ct.voxels[n] + share * (hu - mean_hu));
    if (share > 0.0) {
      out.ct.voxels[n] = static_cast<std::int16_t>(std::clamp(sum, -1024.0, 32767.0));
    }
  }
}

/// Voxels of the liver, 0 elsewhere; its centre of mass in LPS.
segmentation::Mask NotLiver(const volume::LabelMap& labels, Label liver, Vector3d& middle_mm) {
  segmentation::Mask outside(labels.geometry, 1);
  const Geometry& g = labels.geometry;
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  Vector3d sum = Vector3d::Zero();
  std::size_t count = 0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (labels.At(i, j, k) != liver) continue;
        // The border of the volume is a border of the liver.
        const bool at_border = i == 0 || j == 0 || k == 0 || i == g.size[0] - 1 ||
                               j == g.size[1] - 1 || k == g.size[2] - 1;
        if (!at_border) outside.At(i, j, k) = 0;
        sum += ct_from_index * Vector3d(i, j, k);
        ++count;
      }
    }
  }
  ACUS_REQUIRE(count > 0,
               "the label map has no liver; find it with acus-segment, or import a label map that "
               "names it");
  middle_mm = sum / static_cast<double>(count);
  return outside;
}

std::optional<Lesion> PlaceLesion(const FreeSpace& space, const LiverDuctSettings& settings,
                                  std::uint64_t seed) {
  const Eigen::Array3d radius_mm =
      0.5 * Eigen::Array3d(settings.lesion_mm[0], settings.lesion_mm[1], settings.lesion_mm[2]);
  if (radius_mm.maxCoeff() <= 0.0) return std::nullopt;
  ACUS_REQUIRE(radius_mm.minCoeff() >= 1.0 && radius_mm.maxCoeff() <= 100.0,
               "lesion: diameters of ", settings.lesion_mm[0], ", ", settings.lesion_mm[1], ", ",
               settings.lesion_mm[2], " mm; allowed are 2 to 200, or 0 for none");
  const double needed_mm = radius_mm.maxCoeff() + settings.margin_mm;
  if (settings.lesion_at_mm) {
    const double room_mm = space.ClearanceMm(*settings.lesion_at_mm);
    ACUS_REQUIRE(room_mm >= needed_mm, "lesion at ", settings.lesion_at_mm->x(), ", ",
                 settings.lesion_at_mm->y(), ", ", settings.lesion_at_mm->z(), " mm (LPS): it is ",
                 std::max(0.0, room_mm), " mm inside free liver; needed are ", needed_mm,
                 " mm, radius and margin: move it, or make it smaller");
    return Lesion{.centre_mm = *settings.lesion_at_mm, .radius_mm = radius_mm};
  }
  std::vector<std::size_t> places;
  const auto& voxels = space.distance_mm.voxels;
  const Geometry& g = space.distance_mm.geometry;
  const double voxel_mm = 0.5 * g.spacing_mm.matrix().norm();
  for (std::size_t n = 0; n < voxels.size(); ++n) {
    if (voxels[n] - voxel_mm >= needed_mm) places.push_back(n);
  }
  if (places.empty()) {
    throw NoAnswerError(Message("a lesion with a radius of ", radius_mm.maxCoeff(),
                                " mm fits nowhere into the liver with a margin of ",
                                settings.margin_mm, " mm; make one of both smaller"));
  }
  RandomStream random(seed, "place of a lesion");
  const std::size_t n = places[random.Next() % places.size()];
  const auto width = static_cast<std::size_t>(g.size[0]),
             height = static_cast<std::size_t>(g.size[1]);
  const Vector3d index(static_cast<double>(n % width), static_cast<double>(n / width % height),
                       static_cast<double>(n / (width * height)));
  return Lesion{.centre_mm = g.ct_from_index() * index, .radius_mm = radius_mm};
}

std::vector<DuctSegment> Grown(const FreeSpace& space, const Vector3d& root_mm, const char* name,
                               double diameter_mm, const std::vector<DuctSegment>& others,
                               const LiverDuctSettings& settings, std::uint64_t seed) {
  if (diameter_mm <= 0.0) return {};
  const auto tree = GrowDuctTree(space, root_mm, others,
                                 {.root_radius_mm = 0.5 * diameter_mm,
                                  .least_radius_mm = 0.5 * settings.thinnest_mm,
                                  .margin_mm = settings.margin_mm,
                                  .seed = seed,
                                  .name = name});
  if (!tree) {
    throw NoAnswerError(Message("the root of the ", name, ", ", diameter_mm,
                                " mm wide, fits nowhere into the liver with a margin of ",
                                settings.margin_mm, " mm; make one of both smaller"));
  }
  return *tree;
}

std::vector<PutStructure> TubesOf(const std::vector<DuctSegment>& tree) {
  std::vector<PutStructure> tubes;
  for (const DuctSegment& segment : tree) tubes.push_back(TubeOf(segment));
  return tubes;
}

std::string DuctRows(const char* name, const std::vector<DuctSegment>& tree) {
  std::string rows;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const DuctSegment& s = tree[i];
    rows += Message(name, ",", i, ",", s.parent, ",", NumberText(s.from_mm.x()), ",",
                    NumberText(s.from_mm.y()), ",", NumberText(s.from_mm.z()), ",",
                    NumberText(s.to_mm.x()), ",", NumberText(s.to_mm.y()), ",",
                    NumberText(s.to_mm.z()), ",", NumberText(s.radius_mm), "\n");
  }
  return rows;
}

}  // namespace

LiverDucts PutDuctsIntoLiver(const volume::CtVolume& ct, const volume::LabelMap& labels,
                             const LiverDuctSettings& settings, const RunContext& context) {
  ACUS_REQUIRE(labels.geometry.Matches(ct.geometry),
               "the label map lies on another grid than the CT; segment this CT");
  const Label liver = volume::LabelOf("liver");
  Vector3d middle_mm;
  context.Checkpoint("Finding room in the liver", 0.0);
  segmentation::Mask taken = NotLiver(labels, liver, middle_mm);
  FreeSpace space{segmentation::DistanceMm(taken, context.num_threads)};
  LiverDucts out{.ct = ct, .labels = labels, .vessels = {}, .ducts = {}, .lesion = {}};
  out.lesion = PlaceLesion(space, settings, context.seed);
  if (out.lesion) {
    const PutStructure lesion = EllipsoidOf(*out.lesion);
    const Eigen::Affine3d ct_from_index = ct.geometry.ct_from_index();
    ForVoxelsNear(ct.geometry, lesion.bounds_mm, [&](int i, int j, int k) {
      if (lesion.level(ct_from_index * Vector3d(i, j, k)) < 0.0) taken.At(i, j, k) = 1;
    });
    space.distance_mm = segmentation::DistanceMm(taken, context.num_threads);
  }
  context.Checkpoint("Growing trees", 0.3);
  const Vector3d root_mm = settings.root_at_mm.value_or(middle_mm);
  out.vessels = Grown(space, root_mm, "vessels", settings.vessel_mm, {}, settings, context.seed);
  out.ducts =
      Grown(space, root_mm, "bile ducts", settings.duct_mm, out.vessels, settings, context.seed);
  context.Checkpoint("Putting them into the CT", 0.7);
  PutStructures(ct, TubesOf(out.vessels), out.vessels, "vessel", settings.vessel_hu, out);
  PutStructures(ct, TubesOf(out.ducts), out.ducts, "gallbladder", settings.duct_hu, out);
  if (out.lesion)
    PutStructures(ct, {EllipsoidOf(*out.lesion)}, {}, "lesion", settings.lesion_hu, out);
  return out;
}

void WriteLiverDucts(const std::filesystem::path& folder, const LiverDucts& ducts,
                     const LiverDuctSettings& settings, const RunContext& context) {
  AtomicFolder out(folder, context.overwrite);
  volume::WriteCt(out.path() / "ct.nrrd", ducts.ct);
  volume::WriteLabelMap(out.path() / "labels.seg.nrrd", ducts.labels);
  WriteTextFile(
      out.path() / "ducts.csv",
      "tree,segment,parent,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm,radius_mm\n" +
          DuctRows("vessels", ducts.vessels) + DuctRows("bile_ducts", ducts.ducts));
  nlohmann::json document = {{"format", "acus-liver-ducts/1"},  {"seed", context.seed},
                             {"margin_mm", settings.margin_mm}, {"vessel_hu", settings.vessel_hu},
                             {"duct_hu", settings.duct_hu},     {"lesion_hu", settings.lesion_hu}};
  if (ducts.lesion) {
    document["lesion"] = {{"centre_ct_mm", config::Row(ducts.lesion->centre_mm)},
                          {"radius_mm", config::Row(ducts.lesion->radius_mm.matrix())}};
  }
  config::WriteJson(out.path() / "ducts.json", document);
  config::WriteJson(out.path() / "provenance.json", context.provenance.ToJson());
  out.Commit();
}

std::string LiverDuctsText(const LiverDucts& ducts) {
  std::string text =
      Message("Vessels: ", ducts.vessels.size(), " tubes\nBile ducts: ", ducts.ducts.size(),
              " tubes (label gallbladder)\n");
  if (ducts.lesion) {
    const Vector3d& at = ducts.lesion->centre_mm;
    text += Message("Lesion: at ", FixedText(at.x(), 1), ", ", FixedText(at.y(), 1), ", ",
                    FixedText(at.z(), 1), " mm (CT, LPS)\n");
  }
  return text;
}

}  // namespace acus::phantom
