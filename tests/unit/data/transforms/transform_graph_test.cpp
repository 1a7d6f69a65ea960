#include "acus/data/transforms/transform_graph.h"

#include <gmock/gmock.h>

#include "acus/base/core/random.h"

namespace acus::transforms {
namespace {

Eigen::Matrix4d RandomPose(std::uint64_t index) {
  RandomStream random(5, "graph", index);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(random.Normal(), random.Normal(), random.Normal(), 1.0)
                      .normalized()
                      .toRotationMatrix();
  pose.translation() << random.Normal(), random.Normal(), random.Normal();
  return pose.matrix();
}

TransformName Name(std::string_view text) {
  return ParseTransformName(text).value();
}

TEST(TransformName, IsSplitAtTheToBetweenTwoNames) {
  const auto split = [](std::string_view text) {
    const auto name = ParseTransformName(text);
    return name ? name->from + "|" + name->to : "";
  };
  EXPECT_EQ(split("ProbeToTrackerTransform"), "Probe|Tracker");
  EXPECT_EQ(split("ProbeToTracker"), "Probe|Tracker");
  EXPECT_EQ(split("ToolToReference"), "Tool|Reference");
  EXPECT_EQ(split("StylusTipTo3dView"), "StylusTip|3dView");
  EXPECT_EQ(split("Tooltip"), "");
  EXPECT_EQ(split("ToProbe"), "");
  EXPECT_EQ(split("ProbeTo"), "");
  EXPECT_EQ(split("ProbeToTrackerToReference"), "");  // Which one is meant?
  EXPECT_EQ(split(""), "");
}

TEST(TransformGraph, ComposesAndInvertsAlongThePath) {
  const Eigen::Matrix4d tracker_from_probe = RandomPose(0);
  const Eigen::Matrix4d tracker_from_reference = RandomPose(1);
  const Eigen::Matrix4d probe_from_image =
      RandomPose(2) * Eigen::Vector4d(0.1, 0.2, 0.1, 1).asDiagonal();
  TransformGraph graph;
  graph.Set(Name("ProbeToTracker"), tracker_from_probe, true);
  graph.Set(Name("ReferenceToTracker"), tracker_from_reference, true);
  graph.Set(Name("ImageToProbe"), probe_from_image, true);
  const auto found = graph.Find("Image", "Reference");
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->valid);
  const Eigen::Vector4d point(10, 20, 0, 1);
  // Both ways into the tracker's frame must meet.
  EXPECT_LT((tracker_from_reference * found->to_from_from * point -
             tracker_from_probe * probe_from_image * point)
                .norm(),
            1e-12);
  EXPECT_LT((graph.Find("Reference", "Image")->to_from_from * found->to_from_from -
             Eigen::Matrix4d::Identity())
                .norm(),
            1e-12);
  EXPECT_EQ(graph.Find("Image", "Image")->to_from_from, Eigen::Matrix4d::Identity());
}

TEST(TransformGraph, IsValidOnlyIfAllOfThePathIs) {
  TransformGraph graph;
  graph.Set(Name("ProbeToTracker"), RandomPose(0), true);
  graph.Set(Name("ReferenceToTracker"), RandomPose(1), false);
  EXPECT_FALSE(graph.Find("Probe", "Reference")->valid);
  EXPECT_TRUE(graph.Find("Probe", "Tracker")->valid);
  graph.Set(Name("ReferenceToTracker"), RandomPose(1), true);  // Replaces.
  EXPECT_TRUE(graph.Find("Probe", "Reference")->valid);
}

TEST(TransformGraph, TakesTheShortestPath) {
  TransformGraph graph;
  graph.Set(Name("AToB"), RandomPose(0), true);
  graph.Set(Name("BToC"), RandomPose(1), true);
  graph.Set(Name("AToC"), RandomPose(2), true);
  EXPECT_EQ(graph.Find("A", "C")->to_from_from, RandomPose(2));
}

TEST(TransformGraph, AddsWhatIsMissingAndKeepsWhatItHas) {
  TransformGraph graph, other;
  graph.Set(Name("ProbeToTracker"), RandomPose(0), true);
  other.Set(Name("ProbeToTracker"), RandomPose(1), false);
  other.Set(Name("ProbeToImage"), RandomPose(2), true);
  other.Set(Name("NeedleToTracker"), RandomPose(3), true);
  graph.AddMissing(other);
  EXPECT_EQ(graph.Find("Probe", "Tracker")->to_from_from, RandomPose(0));
  EXPECT_TRUE(graph.Find("Probe", "Tracker")->valid);
  ASSERT_TRUE(graph.Find("Probe", "Image")) << "shares one name only";
  EXPECT_EQ(graph.Find("Probe", "Image")->to_from_from, RandomPose(2));
  ASSERT_TRUE(graph.Find("Needle", "Tracker"));
  EXPECT_EQ(graph.Find("Needle", "Tracker")->to_from_from, RandomPose(3));
}

TEST(TransformGraph, HasTheFramesOfItsTransforms) {
  TransformGraph graph;
  EXPECT_FALSE(graph.HasFrame("Probe"));
  graph.Set(Name("ProbeToTracker"), RandomPose(0), true);
  EXPECT_TRUE(graph.HasFrame("Probe"));
  EXPECT_TRUE(graph.HasFrame("Tracker"));
  EXPECT_FALSE(graph.HasFrame("Needle"));
}

TEST(TransformGraph, FindsNothingAcrossAGapOrASingularTransform) {
  TransformGraph graph;
  graph.Set(Name("AToB"), RandomPose(0), true);
  graph.Set(Name("CToD"), RandomPose(1), true);
  graph.Set(Name("EToB"), Eigen::Matrix4d::Zero(), true);
  EXPECT_FALSE(graph.Find("A", "D"));
  EXPECT_FALSE(graph.Find("A", "Nowhere"));
  EXPECT_FALSE(graph.Find("A", "E"));
  EXPECT_TRUE(graph.Find("E", "A"));
}

TEST(PoseAndScale, TakesAnImageFrameApart) {
  const Eigen::Vector4d mm_per_px(0.2, 0.1, 0.15, 1.0);
  const Eigen::Matrix4d rigid = RandomPose(3);
  const auto parts = PoseAndScale(rigid * mm_per_px.asDiagonal());
  ASSERT_TRUE(parts);
  EXPECT_LT((parts->scale - mm_per_px.head<3>()).norm(), 1e-15);
  EXPECT_LT((parts->pose.matrix() - rigid).norm(), 1e-14);
}

TEST(PoseAndScale, RefusesMirrorsShearsAndFlatFrames) {
  EXPECT_FALSE(PoseAndScale(Eigen::Vector4d(1, 1, -1, 1).asDiagonal().toDenseMatrix()));
  EXPECT_FALSE(PoseAndScale(Eigen::Vector4d(1, 1, 0, 1).asDiagonal().toDenseMatrix()));
  Eigen::Matrix4d sheared = Eigen::Matrix4d::Identity();
  sheared(0, 1) = 0.019;
  EXPECT_TRUE(PoseAndScale(sheared));
  sheared(0, 1) = 0.021;
  EXPECT_FALSE(PoseAndScale(sheared));
  EXPECT_FALSE(PoseAndScale(Eigen::Matrix4d::Constant(NAN)));
}

}  // namespace
}  // namespace acus::transforms
