#include "acus/patient/registration/marker_facets.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "support/marker_layouts.h"

namespace acus::registration {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

/// Four facets around a box: squares of 40 mm.
std::vector<Facet> Facets() {
  std::vector<Facet> facets;
  for (int i = 0; i < 4; ++i) {
    transforms::Markers points_mm(3, 4);
    points_mm << -20, 20, 20, -20, -20, -20, 20, 20, 0, 0, 0, 0;
    facets.push_back({.name = "F" + std::to_string(i),
                      .point_names = {"a", "b", "c", "d"},
                      .points_mm = points_mm});
  }
  return facets;
}

std::vector<Isometry3d> Places() {
  std::vector<Isometry3d> places{Isometry3d::Identity()};
  for (int i = 1; i < 4; ++i) {
    places.push_back(Eigen::Translation3d(90.0 * i, 15 * i, -30.0 * i) *
                     AngleAxisd(0.5 * i, Vector3d(0.2, 1, 0.1 * i).normalized()));
  }
  return places;
}

Isometry3d MarkerFacetsJitter(RandomStream& random, double sd_mm, double sd_rad) {
  const auto normal = [&random] { return random.Normal(); };
  Isometry3d jitter = Isometry3d::Identity();
  const Vector3d turn(sd_rad * normal(), sd_rad * normal(), sd_rad * normal());
  if (turn.norm() > 0) jitter.linear() = AngleAxisd(turn.norm(), turn.normalized()).matrix();
  jitter.translation() = sd_mm * Vector3d(normal(), normal(), normal());
  return jitter;
}

/// A moving object of which two or three neighbouring facets are seen at a time.
std::vector<FacetPoses> Moments(int count, double sd_mm, double sd_rad, bool all = false) {
  RandomStream random(8, "facets");
  std::vector<FacetPoses> moments;
  for (int m = 0; m < count; ++m) {
    const Isometry3d tracker_from_object =
        Eigen::Translation3d(random.Uniform(-200, 200), random.Uniform(-200, 200), 900) *
        AngleAxisd(random.Uniform(-1, 1), Vector3d(1, random.Uniform(), 0).normalized());
    FacetPoses poses(4);
    const int first = m % 3;
    for (int f = 0; f < 4; ++f) {
      if (!all && (f < first || f > first + 1 + m % 2)) continue;
      poses[static_cast<std::size_t>(f)] = tracker_from_object *
                                           Places()[static_cast<std::size_t>(f)] *
                                           MarkerFacetsJitter(random, sd_mm, sd_rad);
    }
    moments.push_back(poses);
  }
  return moments;
}

TEST(CalibrateFacets, IsExactWithoutNoiseThoughTheObjectMoves) {
  const FacetModel model = CalibrateFacets(Facets(), Moments(12, 0, 0));
  for (std::size_t f = 0; f < 4; ++f) {
    EXPECT_TRUE(model.object_from_facet[f].isApprox(Places()[f], 1e-9)) << f;
    EXPECT_LT(model.facet_rms_mm[f], 1e-9);
  }
}

TEST(CalibrateFacets, AveragesNoiseAndRejectsFlips) {
  auto moments = Moments(300, 0.1, 0.002);
  for (std::size_t m = 0; m < 300; m += 10) {  // A flat marker seen as its mirror image in depth.
    for (auto& pose : moments[m]) {
      if (pose) {
        *pose = *pose * AngleAxisd(0.6, Vector3d::UnitX());
        break;
      }
    }
  }
  const FacetModel model = CalibrateFacets(Facets(), moments);
  EXPECT_GE(model.num_rejected, 28U);
  EXPECT_LE(model.num_rejected, 40U);
  for (std::size_t f = 0; f < 4; ++f) {
    const transforms::Markers off_mm =
        model.PointsInObjectMm(f) - Places()[f] * Facets()[f].points_mm;
    EXPECT_LT(off_mm.colwise().norm().maxCoeff(), 0.25) << f;
  }
}

// Four places of the same noise give one pose: of their 12 coordinates 6 to 9 are left, as far as
// noise turns it. A point is off by sqrt(3) times 0.1 mm times the root of their share.
TEST(CalibrateFacets, SaysTheNoiseOfEachFacet) {
  const FacetModel model = CalibrateFacets(Facets(), Moments(400, 0.1, 0.0, /*all=*/true));
  double sum_mm2 = 0.0;
  for (const double rms_mm : model.facet_rms_mm) sum_mm2 += rms_mm * rms_mm / 4.0;
  EXPECT_GT(std::sqrt(sum_mm2), 0.1 * std::sqrt(3.0 * 0.5) - 0.005);
  EXPECT_LT(std::sqrt(sum_mm2), 0.1 * std::sqrt(3.0 * 0.75) + 0.005);
}

TEST(CalibrateFacets, NamesFacetsThatWereNeverSeenWithTheOthers) {
  auto moments = Moments(12, 0, 0);
  for (FacetPoses& poses : moments) {
    if (poses[3]) poses[0] = poses[1] = poses[2] = std::nullopt;
  }
  EXPECT_THAT([&] { CalibrateFacets(Facets(), moments); },
              ThrowsMessage<NoAnswerError>(HasSubstr("not even through others: 'F3'")));
  auto thin = Facets();
  thin[2].points_mm.row(1).setZero();
  EXPECT_THAT([&] { CalibrateFacets(thin, moments); },
              ThrowsMessage<InputError>(HasSubstr("facet 'F2': its points lie on a line")));
}

/// Four facets seen at once steady the pose far from the first one: the more, the longer the lever.
TEST(FuseFacets, IsSteadierThanOneFacet) {
  const auto moments = Moments(400, 0.05, 0.002, /*all=*/true);
  const FacetModel model = CalibrateFacets(Facets(), moments);
  const Vector3d target_mm(150, 0, -100);
  double single2 = 0.0, fused2 = 0.0;
  RandomStream random(5, "still");
  for (int i = 0; i < 400; ++i) {
    FacetPoses seen(4);
    for (std::size_t f = 0; f < 4; ++f)
      seen[f] = Places()[f] * MarkerFacetsJitter(random, 0.05, 0.002);
    const auto fused = FuseFacets(model, seen);
    ASSERT_TRUE(fused);
    fused2 += (fused->tracker_from_object * target_mm - target_mm).squaredNorm();
    single2 += (*seen[0] * target_mm - target_mm).squaredNorm();
  }
  EXPECT_LT(std::sqrt(fused2 / single2), 0.3);
}

TEST(FuseFacets, LeavesOutAWrongFacetAndSaysWhenTwoDisagree) {
  const FacetModel model = CalibrateFacets(Facets(), Moments(200, 0.05, 0.001));
  FacetPoses seen(4);
  for (std::size_t f = 0; f < 4; ++f) seen[f] = Places()[f];
  *seen[2] = *seen[2] * AngleAxisd(0.4, Vector3d::UnitX());
  auto fused = FuseFacets(model, seen);
  EXPECT_THAT(fused->used, ElementsAre(true, true, false, true));
  EXPECT_LT(fused->tracker_from_object.translation().norm(), 0.1);
  seen[0] = seen[3] = std::nullopt;
  EXPECT_TRUE(FuseFacets(model, seen)->facets_disagree);
  EXPECT_FALSE(FuseFacets(model, FacetPoses(4)));
  seen[2] = std::nullopt;
  EXPECT_LT(FuseFacets(model, seen)->tracker_from_object.translation().norm(), 0.1);
}

TEST(FindMovedFacets, NamesTheFacetThatSlipped) {
  transforms::Markers object_mm(3, 0);
  std::vector<std::size_t> facet_of;
  for (std::size_t f = 0; f < 4; ++f) {
    object_mm.conservativeResize(3, object_mm.cols() + 4);
    object_mm.rightCols(4) = Places()[f] * Facets()[f].points_mm;
    facet_of.insert(facet_of.end(), 4, f);
  }
  transforms::Markers ct_mm =
      testing_support::NoisyMarkers(testing_support::KnownPose() * object_mm, 0.4, 3);
  const std::vector<std::string> names{"F0", "F1", "F2", "F3"};
  EXPECT_THAT(FindMovedFacets(object_mm, ct_mm, facet_of, names), IsEmpty());
  ct_mm.middleCols(4, 4).colwise() += Vector3d(3, -2, 1);
  const auto moved = FindMovedFacets(object_mm, ct_mm, facet_of, names);
  ASSERT_FALSE(moved.empty());
  EXPECT_EQ(moved[0].name, "F1");
  EXPECT_NEAR(moved[0].moved_mm, 3.7, 0.8);
}

}  // namespace
}  // namespace acus::registration
