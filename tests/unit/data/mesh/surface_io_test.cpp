#include "acus/data/mesh/surface_io.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "shapes.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::mesh {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

std::filesystem::path TemporaryPath(const std::string& name) {
  static const testing_support::TemporaryFolder folder;
  return folder / name;
}

class SurfaceFormat : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, SurfaceFormat, testing::Values("stl", "obj", "ply", "vtp"));

TEST_P(SurfaceFormat, GivesBackWhatWasWritten) {
  const auto path = TemporaryPath(std::string("sphere.") + GetParam());
  const Surface sphere = shapes::Icosphere(20.0, 2);
  WriteSurface(path, sphere);
  const Surface back = ReadSurface(path);
  ASSERT_EQ(back.nodes_mm.cols(), sphere.nodes_mm.cols());
  ASSERT_EQ(back.triangles.cols(), sphere.triangles.cols());
  const double tolerance = std::string(GetParam()) == "stl" ? 1e-4 : 1e-12;
  EXPECT_NEAR(SignedVolumeMm3(back), SignedVolumeMm3(sphere), tolerance * SignedVolumeMm3(sphere));
  for (Eigen::Index t = 0; t < sphere.triangles.cols(); ++t) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_LT(
          (back.nodes_mm.col(back.triangles(c, t)) - sphere.nodes_mm.col(sphere.triangles(c, t)))
              .norm(),
          20.0 * tolerance);
    }
  }
}

TEST_P(SurfaceFormat, SurvivesEveryDamage) {
  const auto path = TemporaryPath(std::string("damaged.") + GetParam());
  WriteSurface(path, shapes::Cube(10.0));
  const int count = std::string(GetParam()) == "vtp" ? 60 : 400;  // A process each.
  const int refused = testing_support::ReadDamagedCopies(ReadTextFile(path), path, count, [&] {
    const Surface surface = ReadSurface(path);
    EXPECT_TRUE(surface.nodes_mm.allFinite());
    EXPECT_LT(surface.triangles.maxCoeff(), surface.nodes_mm.cols());
    EXPECT_GE(surface.triangles.minCoeff(), 0);
  });
  EXPECT_GT(refused, count / 4);
}

TEST(ReadSurface, ReadsTextStlAndWeldsItsCorners) {
  const auto path = TemporaryPath("text.stl");
  std::string text = "solid one\n";
  const Surface cube = shapes::Cube(2.0);
  for (Eigen::Index t = 0; t < 12; ++t) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d x = cube.nodes_mm.col(cube.triangles(c, t));
      text += Message("  vertex ", x[0], " ", x[1], " +", x[2], "\n");
    }
    text += " endloop\nendfacet\n";
  }
  WriteTextFile(path, text + "endsolid one\n");
  const Surface back = ReadSurface(path);
  EXPECT_EQ(back.nodes_mm.cols(), 8);
  EXPECT_DOUBLE_EQ(SignedVolumeMm3(back), 8.0);
  WriteTextFile(path, text);
  EXPECT_THAT([&] { ReadSurface(path); }, ThrowsMessage<InputError>(HasSubstr("endsolid")));
}

TEST(ReadSurface, ReadsObjWithNegativeNumbersNormalsAndQuads) {
  const auto path = TemporaryPath("quad.obj");
  WriteTextFile(
      path, "# note\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf -4//1 -3//1 -2//1 -1//1\n");
  const Surface back = ReadSurface(path);
  EXPECT_EQ(back.triangles, (Eigen::Matrix3Xi(3, 2) << 0, 0, 1, 2, 2, 3).finished());
  WriteTextFile(path, "v 0 0 0\nv 1 0 0\nf 1 2 9\n");
  EXPECT_THAT([&] { ReadSurface(path); }, ThrowsMessage<InputError>(HasSubstr("names node 8")));
  WriteTextFile(path, "v 0 0 nan\n");
  EXPECT_THAT([&] { ReadSurface(path); }, ThrowsMessage<InputError>(HasSubstr("quad.obj:1")));
}

TEST(ReadSurface, JoinsLinesOfObjThatABackslashContinues) {
  const auto path = TemporaryPath("continued.obj");
  WriteTextFile(path,
                "# made in C:\\models\\\nv 0 0 \\\n0\nv 2 0 0\nv 0 1 0\r\nv 0 0 1\nf 1 2\\\r\n 3 "
                "\\\n 4\nvn 0 \\\n0 1\nmtllib a\\b\\\nf 1 \\");
  EXPECT_THAT([&] { ReadSurface(path); }, ThrowsMessage<InputError>(HasSubstr("continued.obj:13")));
  WriteTextFile(path, "v 0 0 \\\n0\nv 2 0 0\nv 0 1 0\nv 0 0 1\nf 1 2\\\r\n 3 \\\n 4\n");
  EXPECT_EQ(ReadSurface(path).triangles, (Eigen::Matrix3Xi(3, 2) << 0, 0, 1, 2, 2, 3).finished());
}

TEST(ReadSurface, ConvertsTheUnitInACommentOfObj) {
  const auto path = TemporaryPath("unit.obj");
  for (const auto& [comment, mm] :
       {std::pair{"# Units: mm", 1.0}, std::pair{"# Units are in centimeters", 10.0},
        std::pair{"#unit = inches", 25.4}, std::pair{"# Units: in", 25.4},
        std::pair{"# drawn in metres", 1.0}}) {
    WriteTextFile(path, std::string(comment) + "\nv 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_NEAR(ReadSurface(path).nodes_mm.maxCoeff(), 2.0 * mm, 1e-9) << comment;
  }
}

TEST(ReadSurface, ReadsTextAndBigEndianPly) {
  const auto path = TemporaryPath("any.ply");
  const std::string elements =
      "element vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  WriteTextFile(path, "ply\nformat ascii 1.0\n" + elements + "0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n");
  EXPECT_EQ(ReadSurface(path).nodes_mm(1, 2), 2.0);
  const std::string one("\x3f\x80\0\0", 4), zero(4, '\0');
  const std::string body = zero + zero + zero + one + zero + zero + zero + one + zero + "\3" +
                           zero + std::string("\0\0\0\1\0\0\0\2", 8);
  WriteTextFile(path, "ply\nformat binary_big_endian 1.0\n" + elements + body);
  const Surface back = ReadSurface(path);
  EXPECT_EQ(back.nodes_mm(0, 1), 1.0);
  EXPECT_EQ(back.triangles(2, 0), 2);
}

TEST(ReadSurface, NeverAllocatesWhatAHeaderOnlyClaims) {
  const auto path = TemporaryPath("huge.ply");
  WriteTextFile(path,
                "ply\nformat ascii 1.0\nelement vertex 4000000000000\nproperty float x\n"
                "end_header\n1\n");
  EXPECT_THAT([&] { ReadSurface(path); },
              ThrowsMessage<InputError>(HasSubstr("more than the file")));
  const auto stl = TemporaryPath("huge.stl");
  WriteTextFile(stl, std::string(80, 'x') + "\xff\xff\xff\xff" + std::string(50, '\0'));
  EXPECT_THAT([&] { ReadSurface(stl); }, ThrowsMessage<InputError>(HasSubstr("cut off")));
}

TEST(ReadSurface, NamesItsFormats) {
  EXPECT_THAT([] { ReadSurface("surface.png"); }, ThrowsMessage<InputError>(HasSubstr(".vtp")));
  EXPECT_THROW(WriteSurface(TemporaryPath("surface.png"), shapes::Cube()), InputError);
  EXPECT_THROW(ReadSurface("not_there.stl"), InputError);
  EXPECT_THROW(ReadSurface("not_there.vtp"), InputError);
}

TEST(TetraMeshFile, KeepsNodesTissuesAndFixedNodes) {
  const auto path = TemporaryPath("mesh.vtu");
  const TetraMesh mesh = shapes::TwoTetrahedra();
  WriteTetraMesh(path, mesh);
  const TetraMesh back = ReadTetraMesh(path);
  EXPECT_EQ(back.nodes_mm, mesh.nodes_mm);
  EXPECT_EQ(back.tetrahedra, mesh.tetrahedra);
  EXPECT_EQ(back.tissue, mesh.tissue);
  EXPECT_EQ(back.fixed_nodes, mesh.fixed_nodes);
}

TEST(TetraMeshFile, WithoutTissuesHasNone) {
  const auto path = TemporaryPath("foreign.vtu");
  WriteTetraMesh(path, shapes::TwoTetrahedra());
  std::string text = ReadTextFile(path);
  text.replace(text.find("Name=\"tissue\""), 13, "Name=\"colour\"");
  WriteTextFile(path, text);
  EXPECT_TRUE(ReadTetraMesh(path).tissue.empty());
}

TEST(TetraMeshFile, RefusesATetrahedronInsideOut) {
  const auto path = TemporaryPath("inverted.vtu");
  TetraMesh mesh = shapes::TwoTetrahedra();
  std::swap(mesh.tetrahedra(0, 1), mesh.tetrahedra(1, 1));
  WriteTetraMesh(path, mesh);
  EXPECT_THAT([&] { ReadTetraMesh(path); }, ThrowsMessage<InputError>(HasSubstr("tetrahedron 1")));
}

TEST(TetraMeshFile, SurvivesEveryDamage) {
  const auto path = TemporaryPath("damaged.vtu");
  WriteTetraMesh(path, shapes::TwoTetrahedra());
  const int refused = testing_support::ReadDamagedCopies(ReadTextFile(path), path, 60, [&] {
    const TetraMesh mesh = ReadTetraMesh(path);
    EXPECT_LT(mesh.tetrahedra.maxCoeff(), mesh.nodes_mm.cols());
    if (!mesh.tissue.empty()) {  // Its name may be what was damaged.
      EXPECT_EQ(mesh.tissue.size(), static_cast<std::size_t>(mesh.tetrahedra.cols()));
    }
  });
  EXPECT_GT(refused, 15);
}

}  // namespace
}  // namespace acus::mesh
