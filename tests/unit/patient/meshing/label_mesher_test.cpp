#include "acus/patient/meshing/label_mesher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gmock/gmock.h>
#include <map>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/mesh/quality.h"
#include "label_maps.h"

namespace acus::meshing {
namespace {

using label_maps::kBone;
using label_maps::kFat;
using testing::HasSubstr;
using testing::ThrowsMessage;

LabelMeshSettings Coarse() {
  LabelMeshSettings out;
  out.sizes = {5.0, 8.0, 16.0, std::nullopt};
  return out;
}

struct Face {
  std::vector<std::uint8_t> tissues;  ///< Of the one or two tetrahedra at it.
};

std::map<std::array<int, 3>, Face> FacesOf(const mesh::TetraMesh& mesh) {
  std::map<std::array<int, 3>, Face> out;
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    for (int c = 0; c < 4; ++c) {
      std::array<int, 3> key{};
      for (int i = 0; i < 3; ++i) key[i] = mesh.tetrahedra((c + 1 + i) & 3, t);
      std::ranges::sort(key);
      out[key].tissues.push_back(mesh.tissue[t]);
    }
  }
  return out;
}

void ExpectSound(const LabelMesh& out) {
  const mesh::QualityReport quality = mesh::MeasureQuality(out.mesh);
  EXPECT_EQ(quality.num_inverted, 0);
  EXPECT_GE(quality.min_dihedral_deg, 8.0);
  for (const auto& [nodes, face] : FacesOf(out.mesh)) {
    ASSERT_LE(face.tissues.size(), 2U) << "a face of more than two tetrahedra";
  }
  for (const TissueVolume& tissue : out.tissues) {
    EXPECT_NEAR(tissue.mesh_ml, tissue.map_ml, 0.03 * tissue.map_ml) << tissue.name;
  }
}

TEST(MeshLabelMap, OfABallHasTheBallsVolumeAndSurface) {
  const double radius_mm = 30.0;
  const LabelMesh out = MeshLabelMap(
      label_maps::Make(50, 1.5, [&](const auto& x) { return x.norm() < radius_mm ? kFat : 0; }),
      Coarse(), {});
  ExpectSound(out);
  const double truth_ml = 4.0 / 3.0 * std::numbers::pi * std::pow(radius_mm, 3) / 1000.0;
  EXPECT_NEAR(out.body_mesh_ml, truth_ml, 0.01 * truth_ml);
  for (const auto& [nodes, face] : FacesOf(out.mesh)) {
    if (face.tissues.size() == 2) continue;
    for (const int n : nodes) EXPECT_NEAR(out.mesh.nodes_mm.col(n).norm(), radius_mm, 0.6);
  }
}

TEST(MeshLabelMap, SharesFacesAtTheBonesSurface) {
  const LabelMesh out = MeshLabelMap(label_maps::NestedBalls(), Coarse(), {});
  ExpectSound(out);
  double area_mm2 = 0.0;
  for (const auto& [nodes, face] : FacesOf(out.mesh)) {
    if (face.tissues.size() != 2 || (face.tissues[0] == kBone) == (face.tissues[1] == kBone))
      continue;
    for (const int n : nodes) {
      EXPECT_NEAR((out.mesh.nodes_mm.col(n) - Eigen::Vector3d(12, 0, 0)).norm(), 10.0, 0.8);
    }
    const Eigen::Vector3d a = out.mesh.nodes_mm.col(nodes[0]);
    const Eigen::Vector3d b = out.mesh.nodes_mm.col(nodes[1]);
    const Eigen::Vector3d c = out.mesh.nodes_mm.col(nodes[2]);
    area_mm2 += 0.5 * (b - a).cross(c - a).norm();
  }
  EXPECT_NEAR(area_mm2, 4.0 * std::numbers::pi * 100.0, 0.06 * 4.0 * std::numbers::pi * 100.0);
}

TEST(MeshLabelMap, FixesTheNodesOfBoneAndNoOthers) {
  const LabelMesh out = MeshLabelMap(label_maps::NestedBalls(), Coarse(), {});
  std::vector<std::uint8_t> is_bone(out.mesh.fixed_nodes.size(), 0);
  for (Eigen::Index t = 0; t < out.mesh.tetrahedra.cols(); ++t) {
    for (int c = 0; c < 4; ++c) is_bone[out.mesh.tetrahedra(c, t)] |= out.mesh.tissue[t] == kBone;
  }
  EXPECT_EQ(out.mesh.fixed_nodes, is_bone);
  EXPECT_GT(std::ranges::count(is_bone, 1), 50);
}

TEST(MeshLabelMap, CutsBodyAndBoneAtTheVolumesBorder) {
  const LabelMesh out = MeshLabelMap(label_maps::BarToTheBorder(), Coarse(), {});
  ExpectSound(out);
  const double half_mm = 40.0;  // The border is half a voxel beyond the last centres.
  EXPECT_LT(out.mesh.nodes_mm.row(0).cwiseAbs().maxCoeff(), half_mm + 8.0 / 3.0);
  double off_mm = 0.0;
  int count = 0;
  for (const auto& [nodes, face] : FacesOf(out.mesh)) {
    if (face.tissues.size() == 2) continue;
    const Eigen::Vector3d middle =
        (out.mesh.nodes_mm.col(nodes[0]) + out.mesh.nodes_mm.col(nodes[1]) +
         out.mesh.nodes_mm.col(nodes[2])) /
        3.0;
    if (middle.tail<2>().cwiseAbs().maxCoeff() > half_mm - 8.0)
      continue;  // Other sides, and edges.
    off_mm += std::abs(std::abs(middle[0]) - half_mm);
    ++count;
  }
  ASSERT_GT(count, 100);
  // Where three tissues meet nodes may give way by a third of an edge; on average they do not.
  EXPECT_LT(off_mm / count, 0.6);
}

TEST(MeshLabelMap, FollowsSeveralTissuesAtOnce) {
  LabelMeshSettings settings = Coarse();
  settings.conforming_tissues = {"bone", "liver", "fat"};
  const LabelMesh out = MeshLabelMap(label_maps::NestedBalls(), settings, {});
  ExpectSound(out);
  for (const TissueVolume& tissue : out.tissues)
    EXPECT_EQ(tissue.is_conforming, tissue.name != "skin");
}

TEST(MeshLabelMap, FollowsAllTissuesWithinAVoxel) {
  LabelMeshSettings settings;
  settings.sizes = {5.0, 8.0, 16.0, std::nullopt, 0.0};
  settings.conforming_tissues = {"all"};
  settings.volume_tolerance = 0.02;
  settings.min_dihedral_deg = 10.0;
  volume::LabelMap labels = label_maps::NestedBalls();
  std::ranges::replace(labels.voxels, label_maps::kSkin, kFat);
  LabelMesh out = MeshLabelMap(labels, settings, {});
  ExpectSound(out);
  AddSurfaceDistances(labels, 1, out);
  EXPECT_LT(out.body_surface.value().p95_voxels, 0.7);
  for (const TissueVolume& tissue : out.tissues) {
    EXPECT_TRUE(tissue.is_conforming) << tissue.name;
    EXPECT_NEAR(tissue.mesh_ml, tissue.map_ml, 0.02 * tissue.map_ml) << tissue.name;
    EXPECT_LT(tissue.surface.value().p95_voxels, 1.0) << tissue.name;
  }
}

TEST(MeshLabelMap, DistinguishesThinTissuesWhereTheirSurfaceIsTooFine) {
  LabelMeshSettings settings = Coarse();
  settings.conforming_tissues = {"all"};
  settings.volume_tolerance = 0.02;
  const auto threads = label_maps::Make(40, 1.5, [](const auto& x) -> std::uint8_t {
    if (x.norm() > 28.0) return 0;
    const Eigen::Vector2d cell(std::remainder(x[0], 12.0), std::remainder(x[1], 12.0));
    return cell.norm() < 1.6 ? label_maps::kLiver : kFat;
  });
  std::string warnings;
  RunContext context;
  context.on_warning = [&](std::string_view text) { warnings += text; };
  const LabelMesh out = MeshLabelMap(threads, settings, context);
  EXPECT_THAT(warnings, HasSubstr("without surfaces of their own for liver"));
  for (const TissueVolume& tissue : out.tissues) {
    EXPECT_FALSE(tissue.is_conforming) << tissue.name;
    EXPECT_NEAR(tissue.mesh_ml, tissue.map_ml, 0.06 * tissue.map_ml) << tissue.name;
  }
}

TEST(MeshLabelMap, DistinguishesASmallTissueWithinTheOneAroundIt) {
  LabelMeshSettings settings = Coarse();
  settings.conforming_tissues = {"all"};
  settings.except_tissues = {"liver"};
  settings.volume_tolerance = 0.05;
  // A small ball of liver inside a ball of bone inside fat.
  const auto labels = label_maps::Make(50, 1.5, [](const auto& x) -> std::uint8_t {
    if ((x - Eigen::Vector3d(2, 1, 3)).norm() < 7.0) return label_maps::kLiver;
    return x.norm() < 20.0 ? kBone : x.norm() < 33.0 ? kFat : 0;
  });
  const LabelMesh out = MeshLabelMap(labels, settings, {});
  for (const TissueVolume& tissue : out.tissues) {
    EXPECT_EQ(tissue.is_conforming, tissue.name == "fat") << tissue.name;
    EXPECT_NEAR(tissue.mesh_ml, tissue.map_ml, 0.05 * tissue.map_ml) << tissue.name;
  }
}

TEST(MeshLabelMap, SpendsItsNodesWhereSurfacesBend) {
  LabelMeshSettings settings;
  settings.sizes = {8.0, 8.0, 16.0, std::nullopt, 2.0};
  settings.conforming_tissues = {"all"};
  settings.volume_tolerance = 0.2;
  settings.wanted_nodes = 9000;
  const volume::LabelMap labels = label_maps::NestedBalls();
  LabelMesh refined = MeshLabelMap(labels, settings, {});
  EXPECT_LE(refined.mesh.nodes_mm.cols(), 9900);  // Counted before the elements are improved.
  EXPECT_GT(refined.mesh.nodes_mm.cols(), 6000);
  settings.sizes.finest_mm = 0.0;
  LabelMesh even = MeshLabelMap(labels, settings, {});
  AddSurfaceDistances(labels, 1, refined);
  AddSurfaceDistances(labels, 1, even);
  for (std::size_t n = 0; n < even.tissues.size(); ++n) {
    EXPECT_LT(refined.tissues[n].surface.value().p95_mm, even.tissues[n].surface.value().p95_mm)
        << even.tissues[n].name;
  }
}

TEST(MeshLabelMap, GivesEveryTetrahedronATissue) {
  // A splinter of bone that no sample of its tetrahedra may hit.
  LabelMeshSettings settings = Coarse();
  const volume::LabelMap labels = label_maps::NestedBalls();
  const LabelMesh out = MeshLabelMap(labels, settings, {});
  EXPECT_EQ(std::ranges::count(out.mesh.tissue, 0), 0);
}

TEST(MeshLabelMap, IsFinerInTheCorridor) {
  LabelMeshSettings settings = Coarse();
  settings.sizes.corridor = Corridor{{0, -40, 20}, {0, 20, 20}, 5.0, 2.5};
  const LabelMesh out = MeshLabelMap(label_maps::NestedBalls(), settings, {});
  ExpectSound(out);
  double inside = 0.0, outside = 0.0;
  int num_inside = 0, num_outside = 0;
  for (Eigen::Index t = 0; t < out.mesh.tetrahedra.cols(); ++t) {
    const mesh::Corners x = mesh::CornersOf(out.mesh, t);
    const Eigen::Vector3d centre = 0.25 * (x[0] + x[1] + x[2] + x[3]);
    const double off_axis = std::hypot(centre[0], centre[2] - 20.0);
    if (off_axis < 3.0 && centre[1] < 15.0 && centre[1] > -20.0) {
      inside += mesh::VolumeMm3(x);
      ++num_inside;
    } else if (off_axis > 20.0 && centre.norm() < 25.0) {
      outside += mesh::VolumeMm3(x);
      ++num_outside;
    }
  }
  ASSERT_GT(num_inside, 100);
  // A lattice of twice the edge length has eight times the volume per element.
  EXPECT_GT(outside / num_outside, 6.0 * inside / num_inside);
}

TEST(MeshLabelMap, GivesTheSameBitsTwiceAndOnAnyNumberOfThreads) {
  const volume::LabelMap labels = label_maps::NestedBalls();
  RunContext one, two;
  two.num_threads = 2;
  const LabelMesh a = MeshLabelMap(labels, Coarse(), one);
  for (const RunContext& context : {one, two}) {
    const LabelMesh b = MeshLabelMap(labels, Coarse(), context);
    EXPECT_TRUE(a.mesh.nodes_mm == b.mesh.nodes_mm);
    EXPECT_TRUE(a.mesh.tetrahedra == b.mesh.tetrahedra);
    EXPECT_EQ(a.mesh.tissue, b.mesh.tissue);
  }
}

TEST(MeshLabelMap, FollowsVolumesThatAreTurnedOrMirrored) {
  volume::LabelMap labels = label_maps::NestedBalls();
  const LabelMesh straight = MeshLabelMap(labels, Coarse(), {});
  labels.geometry.direction =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  labels.geometry.direction.col(2) *= -1.0;
  labels.geometry.origin_mm = {100, 200, -300};
  const LabelMesh turned = MeshLabelMap(labels, Coarse(), {});
  ExpectSound(turned);
  EXPECT_NEAR(turned.body_mesh_ml, straight.body_mesh_ml, 1e-9 * straight.body_mesh_ml);
  const Eigen::Vector3d moved =
      labels.geometry.direction *
          (straight.mesh.nodes_mm.col(7) - Eigen::Vector3d::Constant(-0.5 * 1.5 * 59)) +
      labels.geometry.origin_mm;
  EXPECT_LT((turned.mesh.nodes_mm.col(7) - moved).norm(), 1e-9);
}

TEST(MeshLabelMap, SurvivesMapsOfNoise) {
  // Nothing that a patient has is this rough: the answer may be "no", but never a bad mesh.
  RandomStream random(3, "noise");
  const volume::LabelMap noise = label_maps::Make(16, 2.0, [&](const auto& x) -> std::uint8_t {
    if (x.cwiseAbs().maxCoeff() > 12.0) return 0;
    return random.Uniform() < 0.3 ? kBone : random.Uniform() < 0.5 ? 0 : kFat;
  });
  try {
    const LabelMesh out = MeshLabelMap(noise, Coarse(), {});
    EXPECT_GE(mesh::MeasureQuality(out.mesh).min_dihedral_deg, 8.0);
  } catch (const NoAnswerError& error) {
    EXPECT_THAT(error.what(), HasSubstr("try smaller elements"));
  }
}

TEST(MeshLabelMap, RefusesWhatItCannotUse) {
  const volume::LabelMap balls = label_maps::NestedBalls();
  EXPECT_THAT(
      [&] { MeshLabelMap(label_maps::Make(8, 1.0, [](const auto&) { return 0; }), Coarse(), {}); },
      ThrowsMessage<InputError>(HasSubstr("no tissue")));
  const auto refuses = [&](const auto& change, const char* words) {
    LabelMeshSettings settings = Coarse();
    change(settings);
    EXPECT_THAT([&] { MeshLabelMap(balls, settings, {}); },
                ThrowsMessage<InputError>(HasSubstr(words)));
  };
  refuses([](auto& s) { s.sizes.skin_mm = 0.0; }, "element size of 0 mm");
  refuses([](auto& s) { s.sizes.interior_mm = 501.0; }, "element size of 501 mm");
  refuses([](auto& s) { s.smoothing_mm = -1.0; }, "smoothing of -1 mm");
  refuses([](auto& s) { s.smoothing_mm = 21.0; }, "smoothing of 21 mm");
  refuses([](auto& s) { s.min_dihedral_deg = -1.0; }, "-1 degrees");
  refuses([](auto& s) { s.min_dihedral_deg = 20.5; }, "20.5 degrees");
  refuses([](auto& s) { s.max_nodes = 500; }, "more than 500 nodes");
  refuses([](auto& s) { s.sizes.corridor = Corridor{{0, 0, 0}, {1, 0, 0}, 0.0, 4.0}; }, "corridor");
}

TEST(MeshLabelMap, SaysNoRatherThanGiveABadMesh) {
  LabelMeshSettings settings = Coarse();
  settings.volume_tolerance = 1e-9;  // No mesh of a ball has that.
  EXPECT_THAT([&] { MeshLabelMap(label_maps::NestedBalls(), settings, {}); },
              ThrowsMessage<NoAnswerError>(HasSubstr("in the label map")));
}

TEST(MeshLabelMap, StopsOnRequest) {
  std::atomic<bool> stop{true};
  RunContext context;
  context.stop = &stop;
  EXPECT_THROW(MeshLabelMap(label_maps::NestedBalls(), Coarse(), context), Cancelled);
}

}  // namespace
}  // namespace acus::meshing
