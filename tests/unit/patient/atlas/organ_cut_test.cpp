#include "acus/patient/atlas/organ_cut.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus::atlas {
namespace {

using Eigen::Vector3d;

/// Tissue of 10 HU with a ball of 60 HU, expected 3 mm aside and 2 mm too small.
struct OrganInTissue {
  OrganSearch search;
  segmentation::Mask truth;
  const Vector3d middle_mm{28, 78, 26};  // Near one end of y.
  const double radius_mm = 18.0;

  OrganInTissue() {
    volume::Geometry g;
    g.size = {36, 50, 27};
    g.spacing_mm.setConstant(2.0);
    search.hu = volume::Grid<float>(g, 10.0F);
    search.prior_mm = volume::Grid<float>(g);
    search.allowed = segmentation::Mask(g, 1);
    truth = segmentation::Mask(g, 0);
    for (std::size_t n = 0; n < search.hu.voxels.size(); ++n) {
      const Vector3d at = Place(n);
      truth.voxels[n] = (at - middle_mm).norm() < radius_mm;
      if (truth.voxels[n] != 0) search.hu.voxels[n] = 60.0F;
      search.hu.voxels[n] += static_cast<float>(n * 31 % 23) - 11.0F;
      search.prior_mm.voxels[n] =
          static_cast<float>(radius_mm - 2.0 - (at - middle_mm - Vector3d(0, -3, 0)).norm());
    }
  }
  Vector3d Place(std::size_t n) const {
    return 2.0 * Vector3d(static_cast<double>(n % 36), static_cast<double>(n / 36 % 50),
                          static_cast<double>(n / (36 * 50)));
  }
  void Fill(const Vector3d& centre_mm, double within_mm, float hu) {
    for (std::size_t n = 0; n < search.hu.voxels.size(); ++n) {
      if ((Place(n) - centre_mm).norm() < within_mm) search.hu.voxels[n] = hu;
    }
  }
  /// 2 |A and B| / (|A| + |B|), of the truth and the cut.
  double Overlap() const {
    const volume::Grid<float> u = CutOrgan(search, 60.0, 1);
    int both = 0, sum = 0;
    for (std::size_t n = 0; n < u.voxels.size(); ++n) {
      EXPECT_TRUE(u.voxels[n] >= 0.0F && u.voxels[n] <= 1.0F) << n;
      const bool found = u.voxels[n] > 0.5F;
      both += found && truth.voxels[n] != 0;
      sum += found + truth.voxels[n];
    }
    return 2.0 * both / sum;
  }
};

TEST(OrganCut, FindsTheOrganNearWhereItIsExpected) {
  EXPECT_GT(OrganInTissue().Overlap(), 0.97);
}

TEST(OrganCut, HuThatAreNoTissuesLeaveTheOrgan) {
  OrganInTissue body;
  body.Fill({28, 10, 26}, 6.0, 900.0F);
  body.Fill({62, 78, 26}, 6.0, -950.0F);
  EXPECT_GT(body.Overlap(), 0.97);
}

TEST(OrganCut, AnotherOrganOfTheSameHuIsNotTaken) {
  OrganInTissue body;
  // In fat; beside it, 4 mm away, a shell of 6 mm around a half of it.
  for (std::size_t n = 0; n < body.truth.voxels.size(); ++n) {
    const Vector3d from_middle_mm = body.Place(n) - body.middle_mm;
    const double beyond_mm = from_middle_mm.norm() - body.radius_mm;
    if (beyond_mm < 0.0) continue;
    const bool other = beyond_mm > 4.0 && beyond_mm < 10.0 && from_middle_mm.x() > 0.0;
    body.search.hu.voxels[n] += other ? 50.0F : -100.0F;
  }
  EXPECT_GT(body.Overlap(), 0.97);
}

TEST(OrganCut, SmallVesselsInTheOrganBelongToIt) {
  OrganInTissue body;
  for (const double x : {-6.0, 6.0}) {
    for (const double y : {-6.0, 0.0, 6.0}) {
      // 2 x 2 x 2 voxels.
      body.Fill(body.middle_mm + Vector3d(x + 1.0, y + 1.0, 1.0), 1.8, 10.0F);
    }
  }
  EXPECT_GT(body.Overlap(), 0.97);
  const volume::Grid<float> u = CutOrgan(body.search, 60.0, 1);
  for (std::size_t n = 0; n < u.voxels.size(); ++n) {
    if ((body.Place(n) - body.middle_mm).norm() > 10.0) continue;
    EXPECT_GT(u.voxels[n], 0.5F) << n;
  }
}

TEST(OrganCut, PlacesThatAreNotAllowedStayOut) {
  OrganInTissue body;
  for (std::size_t n = 0; n < body.truth.voxels.size(); ++n) {
    if (body.Place(n).x() > 34.0) body.search.allowed.voxels[n] = body.truth.voxels[n] = 0;
  }
  EXPECT_GT(body.Overlap(), 0.97);
}

}  // namespace
}  // namespace acus::atlas
