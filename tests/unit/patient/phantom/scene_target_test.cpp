#include "acus/patient/phantom/planning/scene_target.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/patient/phantom/window_patient.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

/// A ball of liver of 30 mm with a ball of lesion of 6 mm in it, and two kidneys, in soft tissue.
volume::LabelMap BallsOfOrgans() {
  volume::Geometry g;
  g.size = {80, 60, 60};
  g.spacing_mm = Eigen::Array3d::Constant(2.0);
  g.origin_mm = {-79.0, -59.0, -59.0};
  volume::LabelMap labels(g);
  const auto ball = [&](const char* name, const Vector3d& centre, double radius_mm) {
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const Vector3d p = g.ct_from_index() * Vector3d(i, j, k);
          if ((p - centre).norm() < radius_mm) labels.At(i, j, k) = volume::LabelOf(name);
        }
      }
    }
  };
  ball("soft_tissue", Vector3d::Zero(), 55.0);
  ball("bone", {0.0, 40.0, 0.0}, 8.0);
  ball("liver", {-15.0, 0.0, 15.0}, 25.0);
  ball("lesion", {-20.0, 0.0, 20.0}, 6.0);
  ball("kidney", {25.0, 20.0, -20.0}, 10.0);
  ball("kidney", {-25.0, 20.0, -20.0}, 12.0);
  return labels;
}

struct Balls {
  volume::LabelMap labels = BallsOfOrgans();
  LabelMapField field{labels};
  BodyFrame frame{labels};

  SceneTarget Find(const std::string& request) const {
    return FindSceneTarget(labels, field, frame, request, 1);
  }
};

TEST(SceneTarget, IsTheDeepestPointOfAStructure) {
  const Balls balls;
  const SceneTarget liver = balls.Find("kidney_right");
  EXPECT_EQ(liver.structure, "kidney");
  EXPECT_LT((liver.points.front().point_ct_mm - Vector3d(-25.0, 20.0, -20.0)).norm(), 3.0);
  EXPECT_NEAR(liver.points.front().depth_mm, 12.0, 2.0);
}

TEST(SceneTarget, ListsPointsApartFromEachOtherTheDeepestFirst) {
  const SceneTarget canal = FindSceneTarget(WindowPatient::Get().labels, WindowPatient::Get().field,
                                            WindowPatient::Get().frame, "spinal_canal", 2);
  ASSERT_GT(canal.points.size(), 10U);
  for (std::size_t n = 0; n < canal.points.size(); ++n) {
    const TargetPoint& point = canal.points[n];
    EXPECT_EQ(WindowPatient::Get().field.LabelAt(point.point_ct_mm),
              volume::LabelOf("spinal_canal"));
    EXPECT_LE(point.depth_mm, canal.points[n > 0 ? n - 1 : 0].depth_mm);
    for (std::size_t m = 0; m < n; ++m)
      EXPECT_GE((point.point_ct_mm - canal.points[m].point_ct_mm).norm(), 10.0);
  }
}

TEST(SceneTarget, TakesOneSideOfAPair) {
  const Balls balls;
  EXPECT_GT(balls.Find("kidney_left").points.front().point_ct_mm.x(), 0.0);
  EXPECT_LT(balls.Find("kidney_right").points.front().point_ct_mm.x(), 0.0);
  EXPECT_LT(balls.Find("kidney").points.front().point_ct_mm.x(), 0.0) << "the larger one";
  EXPECT_THAT([&] { balls.Find("lesion_left"); },
              ThrowsMessage<InputError>(HasSubstr("no lesion on that side")));
}

TEST(SceneTarget, OfALesionMayBeReachedThroughTheOrganAroundIt) {
  const Balls balls;
  EXPECT_THAT(balls.Find("lesion").passable,
              ElementsAre(volume::LabelOf("lesion"), volume::LabelOf("liver")));
  EXPECT_THAT(balls.Find("liver").passable, Not(Contains(volume::LabelOf("kidney"))));
}

TEST(SceneTarget, MayBeAPoint) {
  const SceneTarget target = Balls().Find("-15,0,-5");
  EXPECT_EQ(target.structure, "liver");
  ASSERT_EQ(target.points.size(), 1U);
  EXPECT_EQ(target.points.front().point_ct_mm, Vector3d(-15.0, 0.0, -5.0));
}

TEST(SceneTarget, SaysWhatTheMapHas) {
  const Balls balls;
  EXPECT_THAT([&] { balls.Find("livr"); }, ThrowsMessage<InputError>(testing::AllOf(
                                               HasSubstr("did you mean 'liver'"),
                                               HasSubstr("kidney, lesion, liver, soft_tissue"))));
  EXPECT_THAT([&] { balls.Find("spleen"); }, ThrowsMessage<InputError>(HasSubstr("no spleen")));
  EXPECT_THAT([&] { balls.Find("bone"); },
              ThrowsMessage<InputError>(HasSubstr("a needle does not end there")));
}

TEST(SceneTarget, RefusesPointsThatANeedleCannotReach) {
  const Balls balls;
  EXPECT_THAT([&] { balls.Find("500,0,0"); },
              ThrowsMessage<InputError>(HasSubstr("outside the volume")));
  EXPECT_THAT([&] { balls.Find("70,50,50"); },
              ThrowsMessage<InputError>(HasSubstr("outside the body")));
  EXPECT_THAT([&] { balls.Find("0,40,0"); }, ThrowsMessage<InputError>(HasSubstr("in bone")));
  EXPECT_THAT([&] { balls.Find("1,2"); }, ThrowsMessage<InputError>(HasSubstr("not a point")));
}

}  // namespace
}  // namespace acus::phantom
