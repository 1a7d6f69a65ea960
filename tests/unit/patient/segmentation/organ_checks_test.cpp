#include "acus/patient/segmentation/organ_checks.h"

#include <gmock/gmock.h>

#include "acus/data/volume/labels.h"

namespace acus::segmentation {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A body of 400 x 300 x 300 mm in voxels of 5 mm, the middle at x = 0, with organs as balls.
struct BodyWithOrgans {
  BodyWithOrgans() {
    volume::Geometry g;
    g.size = {80, 60, 60};
    g.spacing_mm = {5.0, 5.0, 5.0};
    g.origin_mm = {-197.5, -147.5, -147.5};
    labels = volume::LabelMap(g, volume::LabelOf("fat"));
    Ball("spinal_canal", {0, 90, 0}, 10.0);
  }
  void Ball(const char* name, const Eigen::Vector3d& centre_mm, double radius_mm) {
    const volume::Geometry& g = labels.geometry;
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
          if ((p - centre_mm).norm() < radius_mm) labels.At(i, j, k) = volume::LabelOf(name);
        }
      }
    }
    labels.names[volume::LabelOf(name)] = name;
  }
  /// 1436, 159, 159 and 180 ml.
  void AllOrgans() {
    Ball("liver", {-90, 0, 40}, 70.0);
    Ball("kidney", {60, 60, 0}, 33.6);
    Ball("kidney", {-60, 60, -15}, 33.6);
    Ball("spleen", {110, 20, 60}, 35.0);
  }
  std::vector<std::string> DoubtsOf(const std::string& name) const {
    for (const OrganCheck& organ : CheckOrgans(labels)) {
      if (organ.name == name) return organ.doubts;
    }
    return {"missing"};
  }
  volume::LabelMap labels;
};

TEST(OrganChecks, NothingSpeaksAgainstUsualOrgans) {
  BodyWithOrgans body;
  EXPECT_THAT(CheckOrgans(body.labels), IsEmpty());
  body.AllOrgans();
  const auto organs = CheckOrgans(body.labels);
  EXPECT_EQ(organs.size(), 4U);
  for (const OrganCheck& organ : organs) EXPECT_THAT(organ.doubts, IsEmpty()) << organ.name;
}

TEST(OrganChecks, AKidneyInTheBowelIsUnsure) {
  BodyWithOrgans body;
  body.Ball("kidney", {60, 60, 0}, 33.6);
  body.Ball("kidney", {-60, 60, -80}, 44.0);  // 357 ml, too low and too large.
  EXPECT_THAT(body.DoubtsOf("kidney_right"), Contains(HasSubstr("larger than 270 ml")));
  EXPECT_THAT(body.DoubtsOf("kidney_left"), Contains(HasSubstr("mm higher")));
  EXPECT_THAT(body.DoubtsOf("kidney_left"), Contains(HasSubstr("times as large")));
  const auto organs = CheckOrgans(body.labels);
  EXPECT_EQ(WithDoubtsInNames(body.labels, organs).names.at(volume::LabelOf("kidney")),
            "kidney (unsure)");
}

TEST(OrganChecks, OrgansInPiecesTooSmallOrOnTheOtherSideAreUnsure) {
  BodyWithOrgans body;
  body.Ball("liver", {90, 0, 40}, 70.0);
  body.Ball("spleen", {110, 20, 60}, 15.0);
  body.Ball("spleen", {110, 20, -60}, 15.0);
  EXPECT_THAT(body.DoubtsOf("liver"), Contains(HasSubstr("on the left side")));
  EXPECT_THAT(body.DoubtsOf("spleen"), Contains(HasSubstr("in pieces")));
  EXPECT_THAT(body.DoubtsOf("spleen"), Contains(HasSubstr("smaller than 40 ml")));
}

TEST(OrganChecks, AKidneyFarBesideTheSpineOrInFrontOfItIsUnsure) {
  BodyWithOrgans body;
  body.Ball("kidney", {60, 60, 0}, 33.6);
  body.Ball("kidney", {-140, 60, 0}, 33.6);
  EXPECT_THAT(body.DoubtsOf("kidney_left"), IsEmpty());
  EXPECT_THAT(body.DoubtsOf("kidney_right"), Contains(HasSubstr("mm beside the spinal canal")));
  BodyWithOrgans other;
  other.Ball("kidney", {60, -40, 0}, 33.6);
  EXPECT_THAT(other.DoubtsOf("kidney_left"), Contains(HasSubstr("mm in front of the spinal")));
}

TEST(OrganChecks, AnOrganFromAnAtlasIsSureOnlyWhereItsSurfaceLiesAtEdges) {
  BodyWithOrgans body;
  body.AllOrgans();
  const auto kidney = [&](const OrganEvidence& evidence) {
    for (const OrganCheck& organ : CheckOrgans(body.labels, {evidence})) {
      if (organ.name == "kidney_left") return organ;
      EXPECT_FALSE(organ.expected_dice) << organ.name;
    }
    return OrganCheck{};
  };
  const OrganEvidence held{.name = "kidney_left", .edge_share = 0.95, .covered_share = 1.0};
  EXPECT_GE(kidney(held).expected_dice.value(), kRightOrganDice);
  EXPECT_TRUE(kidney(held).is_sure());
  const auto doubts_of = [&](const auto& change) {
    OrganEvidence evidence = held;
    change(evidence);
    return kidney(evidence).doubts;
  };
  EXPECT_THAT(doubts_of([](auto& e) { e.edge_share = 0.6; }),
              Contains(HasSubstr("only 60 % of its surface")));
  EXPECT_THAT(doubts_of([](auto& e) { e.covered_share = 0.3; }),
              Contains(HasSubstr("where the atlas shows the body")));
  EXPECT_THAT(doubts_of([](auto& e) { e.barred_share = 0.4; }),
              Contains(HasSubstr("bone, lung, gas")));
  EXPECT_THAT(doubts_of([](auto& e) { e.self_check = 0.6; }),
              Contains(HasSubstr("in each other with Dice 0.60")));
}

}  // namespace
}  // namespace acus::segmentation
