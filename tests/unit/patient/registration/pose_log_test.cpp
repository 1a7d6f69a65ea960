#include "acus/patient/registration/pose_log.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/session/session_io.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::registration {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

const std::string kPoints =
    "facet,name,x_mm,y_mm,z_mm\n"
    "front,a,-20,-20,0\nfront,b,20,-20,0\nfront,c,20,20,0\n"
    "side,a,-10,0,0\nside,b,10,0,0\nside,c,0,15,0\nside,d,0,-15,1\n";
const std::string kPoses =
    "time_s,facet,x_mm,y_mm,z_mm,qw,qx,qy,qz,status\n"
    "0,front,1,2,3,1,0,0,0,OK\n0,side,4,5,6,0.5,0.5,0.5,0.5,OK\n"
    "0.1,front,1,2,3,1,0,0,0,INVALID\n0.1,side,4,5,7,0.5,0.5,0.5,0.5,OK\n";

TEST(ReadFacetPoints, GroupsPointsByFacet) {
  const testing_support::TemporaryFolder folder;
  WriteTextFile(folder.path() / "points.csv", kPoints);
  const auto facets = ReadFacetPoints(folder.path() / "points.csv");
  ASSERT_EQ(facets.size(), 2U);
  EXPECT_EQ(facets[1].name, "side");
  EXPECT_THAT(facets[1].point_names, ElementsAre("a", "b", "c", "d"));
  EXPECT_EQ(facets[1].points_mm(2, 3), 1.0);
  WriteTextFile(folder.path() / "points.csv", kPoints + "side,a,1,2,3\n");
  EXPECT_THAT(
      [&] { ReadFacetPoints(folder.path() / "points.csv"); },
      ThrowsMessage<InputError>(HasSubstr("points.csv:9: facet 'side' has the point 'a' twice")));
}

TEST(ReadFacetPoses, GroupsPosesByMoment) {
  const testing_support::TemporaryFolder folder;
  WriteTextFile(folder.path() / "points.csv", kPoints);
  WriteTextFile(folder.path() / "poses.csv", kPoses);
  const auto facets = ReadFacetPoints(folder.path() / "points.csv");
  const auto moments = ReadFacetPoses(folder.path() / "poses.csv", facets);
  ASSERT_EQ(moments.size(), 2U);
  EXPECT_TRUE(moments[0][0] && moments[0][1] && moments[1][1]);
  EXPECT_FALSE(moments[1][0]);
  EXPECT_EQ(moments[1][1]->translation().z(), 7.0);
  const auto refused = [&](const std::string& row, const std::string& message) {
    WriteTextFile(folder.path() / "poses.csv", kPoses + row);
    EXPECT_THAT([&] { ReadFacetPoses(folder.path() / "poses.csv", facets); },
                ThrowsMessage<InputError>(HasSubstr(message)));
  };
  refused("0,back,1,2,3,1,0,0,0,OK\n", "poses.csv:6: there is no facet 'back'");
  refused("0,front,1,2,3,1,0,0,0,OK\n", "'front' is there twice at 0 s");
  refused("2,front,1,2,3,1,1,0,0,OK\n", "the quaternion's length is 1.41");
  refused("x,front,1,2,3,1,0,0,0,OK\n", "time_s is 'x'");
}

TEST(FacetFiles, SurviveDamage) {
  const testing_support::TemporaryFolder folder;
  const auto points = folder.path() / "points.csv", poses = folder.path() / "poses.csv";
  WriteTextFile(points, kPoints);
  const auto facets = ReadFacetPoints(points);
  EXPECT_GT(testing_support::ReadDamagedCopies(kPoses, poses, 300,
                                               [&] { ReadFacetPoses(poses, facets); }),
            30);
  EXPECT_GT(
      testing_support::ReadDamagedCopies(kPoints, points, 300, [&] { ReadFacetPoints(points); }),
      30);
}

TEST(ReadTool, SaysWhichToolsThereAre) {
  const testing_support::TemporaryFolder folder;
  RunContext context;
  const auto file = folder.path() / "log.csv";
  WriteTextFile(file, "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status\n0,1,2,3,1,0,0,0,OK\n");
  EXPECT_TRUE(IsPoseLog(file));
  EXPECT_EQ(ReadTool({.log = file, .tool = "x", .reference = "y"}, context).size(), 1U);
  EXPECT_THAT(ToolsOf(file, "Tracker", context), ElementsAre("log"));
}

TEST(ReadTool, TakesTheNeedleOrTheProbeOfASession) {
  const testing_support::TemporaryFolder folder;
  session::Session session;
  for (int i = 0; i < 3; ++i) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation().x() = 10.0 + i;
    session.needle.push_back(
        {.time_ns = i * 1'000'000, .reference_from_tool = pose, .valid = true});
    pose.translation().x() = 20.0 + i;
    session.probe.push_back({.time_ns = i * 1'000'000, .reference_from_tool = pose, .valid = true});
  }
  const auto path = folder.path() / "session";
  RunContext context;
  session::WriteSession(path, session, context);
  const auto first_x = [&](const char* tool) {
    return ReadTool({.log = path, .tool = tool}, context)
        .front()
        .reference_from_tool.translation()
        .x();
  };
  EXPECT_EQ(first_x("needle"), 10.0);
  EXPECT_EQ(first_x("probe"), 20.0);
  EXPECT_THAT([&] { first_x("Stylus"); },
              ThrowsMessage<InputError>(HasSubstr("needle and probe, not 'Stylus'")));
}

}  // namespace
}  // namespace acus::registration
