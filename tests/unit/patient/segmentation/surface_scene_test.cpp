#include "acus/patient/segmentation/surfaces/surface_scene.h"

#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/patient/segmentation/voxels/rasterise.h"
#include "support/fuzz.h"
#include "support/icosphere.h"
#include "support/temporary_folder.h"

namespace acus::segmentation {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

mesh::Surface BoxSurface(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  mesh::Surface out;
  out.nodes_mm.resize(3, 8);
  for (int n = 0; n < 8; ++n) {
    for (int a = 0; a < 3; ++a) out.nodes_mm(a, n) = (n >> a & 1) != 0 ? high[a] : low[a];
  }
  out.triangles.resize(3, 12);
  out.triangles << 0, 0, 1, 1, 0, 0, 2, 2, 0, 0, 4, 4,  //
      4, 6, 3, 7, 1, 5, 6, 7, 2, 3, 5, 7,               //
      6, 2, 7, 5, 5, 4, 7, 3, 3, 1, 7, 6;
  return out;
}

volume::LabelMap Grid(int voxels, double spacing_mm, double first_mm) {
  volume::Geometry g;
  g.size = {voxels, voxels, voxels};
  g.spacing_mm.setConstant(spacing_mm);
  g.origin_mm.setConstant(first_mm);
  return volume::LabelMap(g);
}

std::size_t Count(const volume::LabelMap& labels, volume::Label label) {
  return static_cast<std::size_t>(std::ranges::count(labels.voxels, label));
}

TEST(Rasterise, EveryVoxelCentreIsOnItsSideOfABall) {
  volume::LabelMap labels = Grid(90, 0.5, -22.3);
  const mesh::Surface ball = testing_support::Icosphere(20.0, 5, {0, 0, 0});
  EXPECT_EQ(CheckClosed(ball, "ball"), Winding::kOriented);
  PaintInside(ball, Winding::kOriented, 8, 1, labels);
  // Faces lie up to 0.008 mm within the sphere.
  for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
    const int i = static_cast<int>(v % 90), j = static_cast<int>(v / 90 % 90);
    const int k = static_cast<int>(v / 8100);
    const double r = (labels.geometry.ct_from_index() * Eigen::Vector3d(i, j, k)).norm();
    if (r < 19.98) {
      ASSERT_EQ(labels.voxels[v], 8) << i << " " << j << " " << k;
    }
    if (r > 20.0) {
      ASSERT_EQ(labels.voxels[v], 0) << i << " " << j << " " << k;
    }
  }
  const double volume_mm3 = 0.125 * static_cast<double>(Count(labels, 8));
  const double exact_mm3 = mesh::SignedVolumeMm3(ball);
  EXPECT_NEAR(volume_mm3 / exact_mm3, 1.0, 0.001);
}

TEST(Rasterise, InterfacesLieWithinHalfAVoxel) {
  // A box whose faces lie at shares of a voxel.
  for (const double share : {0.0, 0.25, 0.5, 0.75}) {
    volume::LabelMap labels = Grid(40, 1.0, 0.0);
    PaintInside(
        BoxSurface({10 + share, 12 + share, 9 + share}, {25 + share, 30 + share, 28 + share}),
        Winding::kOriented, 5, 1, labels);
    int first = 99, last = -1;
    for (int i = 0; i < 40; ++i) {
      if (labels.At(i, 20, 20) != 5) continue;
      first = std::min(first, i);
      last = i;
    }
    // A voxel reaches half its edge to both sides of its centre.
    EXPECT_LE(std::abs(first - 0.5 - (10 + share)), 0.5);
    EXPECT_LE(std::abs(last + 0.5 - (25 + share)), 0.5);
  }
}

TEST(Rasterise, LinesThroughNodesAndEdgesAreCountedOnce) {
  EXPECT_EQ(CheckClosed(BoxSurface({0, 0, 0}, {1, 1, 1}), "box"), Winding::kOriented);
  // All faces, edges and nodes of the box, and the diagonals of its faces, lie on lines of voxels.
  volume::LabelMap labels = Grid(20, 1.0, 0.0);
  PaintInside(BoxSurface({4, 4, 4}, {12, 12, 12}), Winding::kOriented, 3, 1, labels);
  EXPECT_EQ(Count(labels, 3), 8U * 8U * 8U);
  // An octahedron with its nodes on voxels: no line leaks to the border.
  mesh::Surface octahedron;
  octahedron.nodes_mm.resize(3, 6);
  octahedron.nodes_mm << 16, 4, 10, 10, 10, 10, 10, 10, 16, 4, 10, 10, 10, 10, 10, 10, 16, 4;
  octahedron.triangles.resize(3, 8);
  octahedron.triangles << 0, 2, 1, 3, 2, 1, 3, 0, 2, 1, 3, 0, 0, 2, 1, 3, 4, 4, 4, 4, 5, 5, 5, 5;
  volume::LabelMap other = Grid(20, 1.0, 0.0);
  PaintInside(octahedron, CheckClosed(octahedron, "o"), 3, 1, other);
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 20; ++j) {
      for (int i = 0; i < 20; ++i) {
        const int away = std::abs(i - 10) + std::abs(j - 10) + std::abs(k - 10);
        if (away < 6) {
          EXPECT_EQ(other.At(i, j, k), 3) << i << " " << j << " " << k;
        }
        if (away > 6) {
          EXPECT_EQ(other.At(i, j, k), 0) << i << " " << j << " " << k;
        }
      }
    }
  }
}

TEST(Rasterise, TrianglesMayFaceEitherWayAndOverlapsAreNoHoles) {
  mesh::Surface ball = testing_support::Icosphere(8.0, 3, {10, 10, 10});
  volume::LabelMap outwards = Grid(20, 1.0, 0.0);
  PaintInside(ball, Winding::kOriented, 1, 1, outwards);
  mesh::Surface inwards = ball;
  inwards.triangles.row(1).swap(inwards.triangles.row(2));
  volume::LabelMap same = Grid(20, 1.0, 0.0);
  PaintInside(inwards, CheckClosed(inwards, "in"), 1, 1, same);
  EXPECT_EQ(outwards.voxels, same.voxels);
  std::swap(ball.triangles(1, 17), ball.triangles(2, 17));
  EXPECT_EQ(CheckClosed(ball, "mixed"), Winding::kUnoriented);
  volume::LabelMap mixed = Grid(20, 1.0, 0.0);
  PaintInside(ball, Winding::kUnoriented, 1, 1, mixed);
  EXPECT_EQ(outwards.voxels, mixed.voxels);
  // Two balls in one surface, overlapping: the middle is inside both.
  const mesh::Surface two =
      testing_support::Joined(testing_support::Icosphere(6.0, 3, {8, 10, 10}),
                              testing_support::Icosphere(6.0, 3, {12, 10, 10}));
  volume::LabelMap joined = Grid(20, 1.0, 0.0);
  PaintInside(two, CheckClosed(two, "two"), 1, 1, joined);
  EXPECT_EQ(joined.At(10, 10, 10), 1);
}

TEST(Rasterise, GivesTheSameLabelsWithMoreThreads) {
  const mesh::Surface ball = testing_support::Icosphere(20.0, 4, {1, 2, 3});
  volume::LabelMap one = Grid(60, 0.8, -22.0), three = one;
  PaintInside(ball, Winding::kOriented, 8, 1, one);
  PaintInside(ball, Winding::kOriented, 8, 3, three);
  EXPECT_EQ(one.voxels, three.voxels);
}

TEST(Rasterise, AnOpenSurfaceIsRefusedWithThePlace) {
  mesh::Surface ball = testing_support::Icosphere(20.0, 3, {100, 0, 0});
  ball.triangles.conservativeResize(3, ball.triangles.cols() - 1);
  EXPECT_THAT([&] { CheckClosed(ball, "skin.stl"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("skin.stl: is not closed: 3 edges"),
                                              HasSubstr("Close its holes"))));
  EXPECT_THROW(CheckClosed(mesh::Surface{}, "empty"), InputError);
  ball = testing_support::Icosphere(20.0, 1, {0, 0, 0});
  ball.nodes_mm(0, 0) = std::nan("");
  EXPECT_THROW(CheckClosed(ball, "nan"), InputError);
}

class SurfaceList : public ::testing::Test {
 protected:
  void SetUp() override {
    mesh::WriteSurface(folder_ / "body.stl", testing_support::Icosphere(30.0, 4, {0, 0, 0}));
    mesh::WriteSurface(folder_ / "liver.ply", testing_support::Icosphere(10.0, 4, {0, 0, 0}));
    mesh::WriteSurface(folder_ / "cyst.vtp", testing_support::Icosphere(4.0, 3, {0, 0, 0}));
  }
  SurfaceScene Read(const std::string& surfaces, const char* more = "") {
    WriteTextFile(folder_ / "scene.json",
                  R"({"format": "acus-surface-scene/1", "spacing_mm": 0.5)" + std::string(more) +
                      R"(, "surfaces": [)" + surfaces + "]}");
    return ReadSurfaceScene(folder_ / "scene.json");
  }
  void Refuses(const std::string& surfaces, const char* message, const char* more = "") {
    EXPECT_THAT([&] { LabelsOfSurfaces(Read(surfaces, more), context_); },
                ThrowsMessage<InputError>(HasSubstr(message)))
        << surfaces;
  }
  testing_support::TemporaryFolder folder_;
  RunContext context_;
};

constexpr const char* kBody = R"({"file": "body.stl", "tissue": "soft_tissue"})";
constexpr const char* kLiver = R"({"file": "liver.ply", "tissue": "liver"})";

TEST_F(SurfaceList, LaterSurfacesLieOnTopAndPrioritiesBeatTheOrder) {
  const auto at_middle = [&](const std::string& list) {
    const volume::LabelMap labels = LabelsOfSurfaces(Read(list), context_);
    const Eigen::Array3i i = (labels.geometry.index_from_ct() * Eigen::Vector3d(0.2, 0.2, 0.2))
                                 .array()
                                 .round()
                                 .cast<int>();
    return labels.At(i[0], i[1], i[2]);
  };
  EXPECT_EQ(at_middle(std::string(kBody) + "," + kLiver), 8);
  EXPECT_EQ(at_middle(std::string(kLiver) + "," + kBody), 4);
  EXPECT_EQ(
      at_middle(R"({"file": "liver.ply", "tissue": "liver", "priority": 1},)" + std::string(kBody)),
      8);
}

TEST_F(SurfaceList, TissuesHaveTheirVolumesNamesAndHu) {
  const SurfaceScene scene = Read(std::string(kBody) + "," + kLiver +
                                  R"(,{"file": "cyst.vtp", "tissue": "cyst", "label": 200, "hu": 3,
                "ct_from_surface": [1,0,0,18, 0,1,0,0, 0,0,1,0, 0,0,0,1]})");
  const volume::LabelMap labels = LabelsOfSurfaces(scene, context_);
  // The volume of the triangles, which lie within the ball.
  const auto volume = [](double r, int levels) {
    return mesh::SignedVolumeMm3(testing_support::Icosphere(r, levels, {0, 0, 0}));
  };
  const auto filled = [&](volume::Label label) {
    return 0.125 * static_cast<double>(Count(labels, label));
  };
  EXPECT_NEAR(filled(8) / volume(10, 4), 1.0, 0.01);
  EXPECT_NEAR(filled(200) / volume(4, 3), 1.0, 0.02);
  EXPECT_NEAR(filled(4) / (volume(30, 4) - volume(10, 4) - volume(4, 3)), 1.0, 0.005);
  EXPECT_EQ(labels.names.at(200), "cyst");
  const volume::CtVolume ct = CtOfLabels(scene, labels);
  const Eigen::Array3i i =
      (ct.geometry.index_from_ct() * Eigen::Vector3d(18, 0, 0)).array().round().cast<int>();
  EXPECT_EQ(ct.At(i[0], i[1], i[2]), 3);
  EXPECT_EQ(ct.At(0, 0, 0), -1000);
}

TEST_F(SurfaceList, MistakesAreNamed) {
  Refuses(R"({"file": "skin.stl", "tissue": "skin"})", "no such file");
  Refuses(R"({"file": "body.stl", "tissue": "livr"})", "did you mean 'liver'");
  Refuses(R"({"file": "body.stl", "tissue": "cyst", "label": 3})", "give 128 to 255");
  Refuses(R"({"file": "body.stl", "tissue": "liver", "label": 9})", "it is 8");
  Refuses(R"({"file": "body.stl", "tissue": "liver", "label": 256})", "label");
  Refuses(R"({"file": "body.stl", "tissue": "liver", "priority": 1001})", "priority");
  Refuses(R"({"file": "body.stl", "tissue": "liver", "hu": 4001})", "hu");
  Refuses(R"({"file": "body.stl", "tissue": "liver", "hu": 10},
             {"file": "liver.ply", "tissue": "liver", "hu": 20})",
          "the same");
  Refuses(R"({"file": "body.stl", "tissue": "liver",
              "ct_from_surface": [0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,1]})",
          "ct_from_surface");
  Refuses("", "surfaces");
  Refuses(kBody, "spacing_mm", R"(, "spacing": 0.5)");
  mesh::Surface open = testing_support::Icosphere(10.0, 2, {0, 0, 0});
  open.triangles.conservativeResize(3, open.triangles.cols() - 2);
  mesh::WriteSurface(folder_ / "open.stl", open);
  Refuses(R"({"file": "open.stl", "tissue": "liver"})", "open.stl: is not closed");
  mesh::WriteSurface(folder_ / "huge.stl", testing_support::Icosphere(3000.0, 2, {0, 0, 0}));
  Refuses(R"({"file": "huge.stl", "tissue": "liver"})", "Give a larger /spacing_mm");
}

TEST_F(SurfaceList, DamagedListsAreReadOrRefused) {
  Read(std::string(kBody) + "," + kLiver);
  const std::string valid = ReadTextFile(folder_ / "scene.json");
  const auto path = folder_ / "damaged.json";
  const auto read = [&] { ReadSurfaceScene(path); };
  EXPECT_GT(testing_support::ReadDamagedCopies(valid, path, 200, read), 50);
}

TEST_F(SurfaceList, APlusConfigurationIsAListToo) {
  WriteTextFile(folder_ / "plus.xml", R"(<PlusConfiguration>
    <vtkPlusUsSimulatorAlgo ReferenceCoordinateFrame="Ref">
      <SpatialModel Name="Air" DensityKgPerM3="1.2" SoundVelocityMPerSec="343"
        AttenuationCoefficientDbPerCmMhz="100"/>
      <SpatialModel Name="Liver" ObjectCoordinateFrame="Ref" ModelFile="liver.ply"
        DensityKgPerM3="1060" SoundVelocityMPerSec="1550" AttenuationCoefficientDbPerCmMhz="0.5"/>
      <SpatialModel Name="Needle" ObjectCoordinateFrame="NeedleTip" ModelFile="needle.stl"
        DensityKgPerM3="2000" SoundVelocityMPerSec="2000" AttenuationCoefficientDbPerCmMhz="8"/>
      <ScanConversion TransducerGeometry="LINEAR" ImagingDepthMm="50" TransducerWidthMm="40"
        OutputImageSizePixel="820 616" TransducerCenterPixel="410 0"
        OutputImageSpacingMmPerPixel="0.084 0.087"/>
    </vtkPlusUsSimulatorAlgo></PlusConfiguration>)");
  const SurfaceScene scene = ReadSurfaceScene(folder_ / "plus.xml");
  ASSERT_EQ(scene.surfaces.size(), 1U);
  const volume::LabelMap labels = LabelsOfSurfaces(scene, context_);
  EXPECT_NEAR(0.125 * static_cast<double>(Count(labels, 8)), 4188.8, 20.0);
}

}  // namespace
}  // namespace acus::segmentation
