#include "acus/patient/phantom/planning/scene_target.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "acus/base/core/spelling.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/base/math/point_text.h"
#include "acus/data/volume/label_map_content.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMaxPoints = 24;
constexpr std::size_t kPointsOfLevel = 8;  ///< Where levels are a choice of the program.
constexpr double kPointSpacingMm = 10.0;
constexpr double kLevelSpacingMm = 3.0;   ///< Of points at one height of the spine.
constexpr double kLeastDepthShare = 0.3;  ///< Of the greatest depth: no points in thin ends.

std::array<bool, 256> LabelsIn(const volume::LabelMap& labels) {
  std::array<bool, 256> found{};
  for (const volume::Label label : labels.voxels) found[label] = true;
  return found;
}

/// What ends a needle, or is no place for one.
bool CanBeTarget(const std::string& name) {
  static const std::set<std::string, std::less<>> kNone = {"outside", "skin", "bone", "gas"};
  return !kNone.contains(name);
}

struct NamedStructure {
  volume::Label label;
  std::string name;   ///< Without the side.
  double side = 0.0;  ///< 0: both.
};

NamedStructure StructureOf(const volume::LabelMap& labels, const std::string& request) {
  const std::array<bool, 256> found = LabelsIn(labels);
  const auto label_named = [&](const std::string& name) -> std::optional<volume::Label> {
    for (int label = 1; label < 256; ++label) {
      const auto l = static_cast<volume::Label>(label);
      if (found[label] && volume::NameOfLabel(labels, l) == name) return l;
    }
    return std::nullopt;
  };
  NamedStructure out{.label = 0, .name = request};
  auto label = label_named(request);
  for (const auto& [suffix, side] : {std::pair("_left", 1.0), std::pair("_right", -1.0)}) {
    if (label || !request.ends_with(suffix)) continue;
    out.name = request.substr(0, request.size() - std::string(suffix).size());
    out.side = side;
    label = label_named(out.name);
  }
  ACUS_REQUIRE(CanBeTarget(out.name), "--target ", request,
               ": a needle does not end there; the label map has ", TargetList(labels));
  if (!label) {
    const std::vector<std::string> names = TargetNames(labels);
    const auto nearest = NearestSpelling(out.name, names);
    throw InputError(Message(
        "--target ", request, ": the label map has no ", out.name,
        nearest ? Message("; did you mean '", *nearest, "'? It has ") : std::string("; it has "),
        TargetList(labels), ", or give a point x,y,z in mm"));
  }
  out.label = *label;
  return out;
}

/// The structure in a box of its own, with a voxel of margin. What lies beyond the volume is not
/// it: a structure that the volume cuts has its depth from the cut.
segmentation::Mask MaskOf(const volume::LabelMap& labels, const NamedStructure& structure,
                          const BodyFrame& frame) {
  const volume::Geometry& g = labels.geometry;
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  std::vector<Eigen::Array3i> voxels;
  Eigen::Array3i low = g.size, high = Eigen::Array3i::Constant(-1);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (labels.At(i, j, k) != structure.label) continue;
        const Vector3d p = ct_from_index * Vector3d(i, j, k);
        if (structure.side != 0.0 && frame.Side(p) != structure.side) continue;
        voxels.emplace_back(i, j, k);
        low = low.min(voxels.back());
        high = high.max(voxels.back());
      }
    }
  }
  ACUS_REQUIRE(!voxels.empty(), "--target ", structure.name,
               structure.side > 0.0 ? "_left" : "_right", ": the label map has no ", structure.name,
               " on that side of the patient");
  volume::Geometry box = g;
  box.size = high - low + 3;
  box.origin_mm = ct_from_index * (low - 1).cast<double>().matrix();
  segmentation::Mask mask(box);
  for (const Eigen::Array3i& v : voxels) {
    const Eigen::Array3i at = v - low + 1;
    mask.At(at[0], at[1], at[2]) = 1;
  }
  return mask;
}

/// Points deep inside, the deepest first. Equal depths are in the order of voxels.
/// @param level  If given, only points at that height.
std::vector<TargetPoint> DeepestPoints(const segmentation::Mask& mask, const SpinalLevel* level,
                                       double spacing_mm, int num_threads) {
  segmentation::Mask around = mask;
  for (auto& voxel : around.voxels) voxel = voxel == 0 ? 1 : 0;
  const volume::Grid<float> depth = segmentation::DistanceMm(around, num_threads);
  const float deepest = *std::ranges::max_element(depth.voxels);
  std::vector<std::size_t> order;
  for (std::size_t n = 0; n < depth.voxels.size(); ++n) {
    if (mask.voxels[n] != 0 && depth.voxels[n] >= kLeastDepthShare * deepest) order.push_back(n);
  }
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t n) { return depth.voxels[n]; });
  const auto columns = static_cast<std::size_t>(mask.geometry.size[0]);
  const auto rows = static_cast<std::size_t>(mask.geometry.size[1]);
  const Eigen::Affine3d ct_from_index = mask.geometry.ct_from_index();
  std::vector<TargetPoint> points;
  for (const std::size_t n : order) {
    const Vector3d index(static_cast<double>(n % columns), static_cast<double>(n / columns % rows),
                         static_cast<double>(n / columns / rows));
    const Vector3d p = ct_from_index * index;
    if (level && !level->HasAt(p)) continue;
    const bool is_apart = std::ranges::none_of(points, [&](const TargetPoint& other) {
      return (other.point_ct_mm - p).norm() < spacing_mm;
    });
    if (is_apart) points.push_back({p, depth.voxels[n]});
    if (points.size() == kMaxPoints) break;
  }
  return points;
}

bool IsOrgan(volume::Label label) {
  static const std::set<volume::Label> kOrgans = [] {
    std::set<volume::Label> organs;
    for (const char* name : {"liver", "kidney", "spleen", "pancreas", "gland"})
      organs.insert(volume::LabelOf(name));
    return organs;
  }();
  return kOrgans.contains(label);
}

/// The organ that a structure lies in or at: the most frequent one within 30 mm of a point of it,
/// if it is a fifth of what else is there.
std::optional<volume::Label> OrganAround(const PatientField& field, const Vector3d& p) {
  const volume::Label own = field.LabelAt(p);
  std::array<int, 256> count{};
  int all = 0;
  for (double radius = 6.0; radius <= 30.0; radius += 6.0) {
    for (int n = 0; n < 27; ++n) {
      const Vector3d out(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      if (out.norm() == 0.0) continue;
      const volume::Label label = field.LabelAt(p + radius * out.normalized());
      if (label == own) continue;
      ++count[label];
      ++all;
    }
  }
  const auto organ = std::ranges::max_element(count, {}, [&](const int& n) {
    return IsOrgan(static_cast<volume::Label>(&n - count.data())) ? n : -1;
  });
  const auto label = static_cast<volume::Label>(organ - count.begin());
  return IsOrgan(label) && 5 * *organ >= all ? std::optional(label) : std::nullopt;
}

std::string CommaText(const Vector3d& p) {
  return FixedText(p.x(), 1) + "," + FixedText(p.y(), 1) + "," + FixedText(p.z(), 1);
}

SceneTarget PointTarget(const volume::LabelMap& labels, const PatientField& field,
                        const std::string& request) {
  const Vector3d p = math::PointFromText(request, "--target");
  const Box box = field.bounds_ct_mm();
  ACUS_REQUIRE(box.contains(p), "--target ", request,
               ": lies outside the volume, which reaches from ", CommaText(box.min()), " to ",
               CommaText(box.max()), " mm; points are in CT space, LPS");
  const volume::Label label = field.LabelAt(p);
  ACUS_REQUIRE(
      label != 0, "--target ", request,
      ": lies outside the body; give a point in tissue, in CT space, LPS, or a structure: ",
      TargetList(labels));
  const std::string name = volume::NameOfLabel(labels, label);
  ACUS_REQUIRE(CanBeTarget(name), "--target ", request, ": lies in ", name,
               "; give a point that a needle can reach, or a structure: ", TargetList(labels));
  return {
      .structure = name, .name = "(" + request + ")", .points = {{p, 0.0}}, .passable = {label}};
}

}  // namespace

std::vector<std::string> TargetNames(const volume::LabelMap& labels) {
  const std::array<bool, 256> found = LabelsIn(labels);
  std::set<std::string> names;
  for (int label = 1; label < 256; ++label) {
    const std::string name = volume::NameOfLabel(labels, static_cast<volume::Label>(label));
    if (found[label] && CanBeTarget(name)) names.insert(name);
  }
  return {names.begin(), names.end()};
}

std::string TargetList(const volume::LabelMap& labels) {
  const std::string text = Joined(TargetNames(labels));
  return text.empty() ? "nothing that can be a target" : text;
}

SceneTarget FindSceneTarget(const volume::LabelMap& labels, const PatientField& field,
                            const BodyFrame& frame, const std::string& request, int num_threads) {
  SceneTarget target;
  if (!request.empty() &&
      std::string_view("+-.0123456789").find(request.front()) != std::string_view::npos) {
    target = PointTarget(labels, field, request);
  } else {
    const NamedStructure structure = StructureOf(labels, request);
    target = {.structure = structure.name,
              .name = request,
              .points = DeepestPoints(MaskOf(labels, structure, frame), nullptr, kPointSpacingMm,
                                      num_threads),
              .passable = {structure.label}};
  }
  const auto around = OrganAround(field, target.points.front().point_ct_mm);
  if (around && !IsOrgan(target.passable.front())) target.passable.push_back(*around);
  return target;
}

SceneTarget FindLevelTarget(const volume::LabelMap& labels, const BodyFrame& frame,
                            const std::string& name, const SpinalLevel& level, int num_threads) {
  const NamedStructure canal = StructureOf(labels, "spinal_canal");
  SceneTarget target{
      .structure = canal.name,
      .name = "the spinal canal at " + name,
      .points = DeepestPoints(MaskOf(labels, canal, frame), &level, kLevelSpacingMm, num_threads),
      .passable = {canal.label}};
  ACUS_REQUIRE(!target.points.empty(), "--target ", name,
               ": the label map has no spinal canal at that height; do vertebrae.csv and the label "
               "map belong together?");
  return target;
}

void PutLumbarFirst(const volume::LabelMap& labels, const BodyFrame& frame,
                    std::span<const NamedLevel> levels, int num_threads, SceneTarget& target) {
  std::vector<TargetPoint> lumbar;
  const segmentation::Mask canal = MaskOf(labels, StructureOf(labels, target.structure), frame);
  for (const std::string_view name : LumbarPunctureLevels()) {
    const auto level = std::ranges::find(levels, name, &NamedLevel::name);
    if (level == levels.end()) continue;
    auto points = DeepestPoints(canal, &level->level, kLevelSpacingMm, num_threads);
    points.resize(std::min(points.size(), kPointsOfLevel));
    lumbar.insert(lumbar.end(), points.begin(), points.end());
  }
  target.points.insert(target.points.begin(), lumbar.begin(), lumbar.end());
}

}  // namespace acus::phantom
