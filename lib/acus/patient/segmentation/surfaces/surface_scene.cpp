#include "acus/patient/segmentation/surfaces/surface_scene.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/data/volume/labels.h"
#include "acus/imaging/acoustics/plus_simulator.h"
#include "acus/patient/segmentation/voxels/rasterise.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxVoxels = 4e8;
/// Voxels of nothing around the surfaces.
constexpr int kMargin = 2;

/// Typical HU, for lists that give none.
double HuOf(const std::string& tissue) {
  static const std::map<std::string, double> kHu = {
      {"outside", -1000},  {"skin", 20},     {"fat", -100},        {"muscle", 55},
      {"soft_tissue", 40}, {"bone", 700},    {"lung", -750},       {"gas", -1000},
      {"liver", 60},       {"kidney", 35},   {"spleen", 50},       {"vessel", 45},
      {"lesion", 40},      {"ligament", 80}, {"spinal_canal", 15}, {"bowel", 30},
      {"cartilage", 120},  {"tendon", 80},   {"bursa", 5},         {"heart", 45},
      {"disc", 90},        {"pancreas", 40}, {"stomach", 35},      {"bladder", 5},
      {"gallbladder", 10}, {"gland", 50},    {"cut", 50}};
  const auto found = kHu.find(tissue);
  return found != kHu.end() ? found->second : 40.0;
}

fs::path Existing(const fs::path& folder, const std::string& file, const std::string& where) {
  const fs::path path = (folder / file).lexically_normal();
  ACUS_REQUIRE(fs::is_regular_file(path), where, ": ", path.string(),
               ": no such file; paths are relative to the list of surfaces");
  return path;
}

SurfaceScene FromPlus(const fs::path& path) {
  const acoustics::PlusSimulator plus = acoustics::ReadPlusSimulator(path);
  SurfaceScene scene;
  scene.file = path;
  for (const acoustics::PlusSurface& model : plus.surfaces) {
    // The needle has a frame of its own: it moves, and is no tissue.
    if (model.object_frame != plus.reference_frame) continue;
    TissueSurface surface{.file = Existing(path.parent_path(), model.file.string(),
                                           path.string() + ": SpatialModel " + model.tissue),
                          .tissue = model.tissue,
                          .label = model.label,
                          .priority = 0,
                          .hu = HuOf(model.tissue)};
    surface.ct_from_surface.matrix() = model.object_from_model;
    scene.surfaces.push_back(std::move(surface));
  }
  ACUS_REQUIRE(!scene.surfaces.empty(), path.string(),
               ": no SpatialModel has a ModelFile in the frame '", plus.reference_frame, "'");
  return scene;
}

TissueSurface FromJson(const nlohmann::json& row, const fs::path& folder,
                       const std::string& where) {
  TissueSurface out;
  out.file = Existing(folder, row.at("file"), where + "/file");
  out.tissue = row.at("tissue");
  try {
    out.label = row.contains("label") ? static_cast<volume::Label>(row.at("label").get<int>())
                                      : volume::LabelOf(out.tissue);
  } catch (const InputError& error) {
    throw InputError(
        Message(where, "/tissue: ", error.what(), " (or give it a label of its own, from 128 on)"));
  }
  const auto standard = volume::FindLabel(out.tissue);
  ACUS_REQUIRE(standard ? *standard == out.label : out.label >= volume::StandardLabels().size(),
               where, "/label: ", int{out.label}, " is not the label of '", out.tissue, "'; ",
               standard
                   ? Message("it is ", int{*standard}, ": leave /label out")
                   : std::string("numbers below are those of standard tissues: give 128 to 255"));
  out.priority = row.at("priority");
  out.hu = row.contains("hu") ? row.at("hu").get<double>() : HuOf(out.tissue);
  if (row.contains("ct_from_surface")) {
    for (int i = 0; i < 16; ++i) {
      out.ct_from_surface.matrix()(i / 4, i % 4) =
          row.at("ct_from_surface")[static_cast<std::size_t>(i)];
    }
    const Eigen::Matrix4d& m = out.ct_from_surface.matrix();
    ACUS_REQUIRE(m.row(3) == Eigen::RowVector4d(0, 0, 0, 1) &&
                     std::abs(m.topLeftCorner<3, 3>().determinant()) > 1e-12,
                 where, "/ct_from_surface: is not an affine map that can be inverted");
  }
  return out;
}

}  // namespace

SurfaceScene ReadSurfaceScene(const fs::path& path) {
  if (acoustics::IsPlusConfiguration(path)) return FromPlus(path);
  const auto document = config::ReadConfig(path, "acus-surface-scene");
  SurfaceScene scene;
  scene.file = path;
  scene.spacing_mm = document.at("spacing_mm");
  std::map<volume::Label, double> hu;
  const auto& rows = document.at("surfaces");
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const std::string where = Message(path.string(), ": /surfaces/", n);
    scene.surfaces.push_back(FromJson(rows[n], path.parent_path(), where));
    const TissueSurface& surface = scene.surfaces.back();
    const auto [entry, is_new] = hu.try_emplace(surface.label, surface.hu);
    ACUS_REQUIRE(is_new || entry->second == surface.hu, where, "/hu: '", surface.tissue, "' has ",
                 entry->second, " HU in another row; give all its surfaces the same");
  }
  return scene;
}

std::vector<std::size_t> RisingOrder(const SurfaceScene& scene) {
  std::vector<std::size_t> order(scene.surfaces.size());
  for (std::size_t n = 0; n < order.size(); ++n) order[n] = n;
  std::ranges::stable_sort(order, {}, [&](std::size_t n) { return scene.surfaces[n].priority; });
  return order;
}

std::vector<ClosedSurface> ReadClosedSurfaces(const SurfaceScene& scene,
                                              const RunContext& context) {
  std::vector<ClosedSurface> out;
  for (const TissueSurface& listed : scene.surfaces) {
    context.Checkpoint("reading surfaces", static_cast<double>(out.size()) /
                                               static_cast<double>(scene.surfaces.size()));
    mesh::Surface surface = mesh::ReadSurface(listed.file);
    const Winding winding = CheckClosed(surface, listed.file.string());
    surface.nodes_mm = listed.ct_from_surface * surface.nodes_mm;
    out.push_back({std::move(surface), winding});
  }
  return out;
}

volume::LabelMap LabelsOfSurfaces(const SurfaceScene& scene, const RunContext& context) {
  return LabelsOfSurfaces(scene, ReadClosedSurfaces(scene, context), context);
}

volume::LabelMap LabelsOfSurfaces(const SurfaceScene& scene,
                                  const std::vector<ClosedSurface>& surfaces,
                                  const RunContext& context) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e30);
  Eigen::Vector3d high = -low;
  const double count = static_cast<double>(surfaces.size());
  for (const ClosedSurface& closed : surfaces) {
    low = low.cwiseMin(closed.surface.nodes_mm.rowwise().minCoeff());
    high = high.cwiseMax(closed.surface.nodes_mm.rowwise().maxCoeff());
  }
  volume::Geometry g;
  const Eigen::Array3d voxels =
      ((high - low).array() / scene.spacing_mm).ceil() + 1.0 + 2.0 * kMargin;
  ACUS_REQUIRE(voxels.prod() <= kMaxVoxels, scene.file.string(), ": the surfaces span ",
               (high - low).maxCoeff(), " mm: ", voxels.prod(), " voxels of ", scene.spacing_mm,
               " mm; allowed are ", kMaxVoxels, ". Give a larger /spacing_mm");
  g.size = voxels.cast<int>();
  g.spacing_mm.setConstant(scene.spacing_mm);
  g.origin_mm = low - Eigen::Vector3d::Constant(kMargin * scene.spacing_mm);
  volume::LabelMap labels(g);
  const std::vector<std::size_t> order = RisingOrder(scene);
  for (std::size_t done = 0; done < order.size(); ++done) {
    context.Checkpoint("filling surfaces", static_cast<double>(done) / count);
    const std::size_t n = order[done];
    PaintInside(surfaces[n].surface, surfaces[n].winding, scene.surfaces[n].label,
                context.num_threads, labels);
    labels.names[scene.surfaces[n].label] = scene.surfaces[n].tissue;
  }
  return labels;
}

volume::CtVolume CtOfLabels(const SurfaceScene& scene, const volume::LabelMap& labels) {
  std::array<std::int16_t, 256> hu;
  hu.fill(-1000);
  for (const TissueSurface& surface : scene.surfaces) {
    hu[surface.label] = static_cast<std::int16_t>(std::lround(surface.hu));
  }
  volume::CtVolume ct(labels.geometry);
  std::ranges::transform(labels.voxels, ct.voxels.begin(),
                         [&](volume::Label label) { return hu[label]; });
  return ct;
}

}  // namespace acus::segmentation
