#include "acus/scene/effects/tubes/centrelines.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::effects {
namespace {

using testing::HasSubstr;

constexpr volume::Label kVessel = 11;

/// Cylinders along z that lean along x by `slope`, in voxels of 0.8 x 0.8 x 2 mm.
volume::LabelMap Cylinders(const std::vector<Eigen::Vector2d>& at_mm, double radius_mm,
                           double slope) {
  volume::Geometry geometry;
  geometry.size = {120, 80, 20};
  geometry.spacing_mm = {0.8, 0.8, 2.0};
  geometry.origin_mm = {-10.0, 5.0, 100.0};
  volume::LabelMap labels(geometry);
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 80; ++j) {
      for (int i = 0; i < 120; ++i) {
        const Eigen::Vector2d pixel_mm(0.8 * i, 0.8 * j);
        for (const Eigen::Vector2d& centre_mm : at_mm) {
          const Eigen::Vector2d now_mm(centre_mm.x() + slope * 2.0 * k, centre_mm.y());
          if ((pixel_mm - now_mm).norm() < radius_mm) labels.At(i, j, k) = kVessel;
        }
      }
    }
  }
  return labels;
}

TEST(Centrelines, FollowLeaningCylindersToATenthOfAMillimetre) {
  const auto lines = CentrelinesOf(Cylinders({{20.0, 20.0}, {60.0, 40.0}}, 6.0, 0.3), kVessel);
  ASSERT_EQ(lines.size(), 2U);
  for (std::size_t n = 0; n < 2; ++n) {
    ASSERT_EQ(lines[n].point_in_ct_mm.size(), 20U);
    for (std::size_t k = 0; k < 20; ++k) {
      const Eigen::Vector3d truth(-10.0 + (n == 0 ? 20.0 : 60.0) + 0.6 * static_cast<double>(k),
                                  5.0 + (n == 0 ? 20.0 : 40.0),
                                  100.0 + 2.0 * static_cast<double>(k));
      EXPECT_LT((lines[n].point_in_ct_mm[k] - truth).norm(), 0.12) << n << " " << k;
      EXPECT_NEAR(lines[n].radius_mm[k], 6.0, 0.12);
    }
  }
}

TEST(Centrelines, LeaveOutWhatIsThinOrShortOrLiesInTheSlice) {
  EXPECT_TRUE(CentrelinesOf(Cylinders({{20.0, 20.0}}, 0.5, 0.0), kVessel).empty());
  volume::LabelMap labels = Cylinders({}, 0.0, 0.0);
  EXPECT_TRUE(CentrelinesOf(labels, kVessel).empty());
  for (int i = 0; i < 120; ++i) {
    for (int j = 30; j < 40; ++j) labels.At(i, j, 10) = kVessel;
  }
  EXPECT_TRUE(CentrelinesOf(labels, kVessel).empty());
}

TEST(Centrelines, AreReadVesselByVessel) {
  const testing_support::TemporaryFolder folder;
  const auto file = folder.path() / "lines.csv";
  WriteTextFile(file,
                "vessel,x_mm,y_mm,z_mm,radius_mm\naorta,0,0,0,9\naorta,0,0,10,8\nleft,5,0,0,4\n"
                "left,5,0,9,4\n");
  const auto lines = ReadCentrelines(file);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].radius_mm, (std::vector<double>{9, 8}));
  EXPECT_EQ(lines[1].point_in_ct_mm[1], Eigen::Vector3d(5, 0, 9));
}

TEST(Centrelines, ABrokenFileNamesTheRow) {
  const testing_support::TemporaryFolder folder;
  const auto file = folder.path() / "lines.csv";
  const auto says = [&file](const char* rows, const char* what) {
    WriteTextFile(file, Message("vessel,x_mm,y_mm,z_mm,radius_mm\n", rows));
    EXPECT_THAT([&] { ReadCentrelines(file); },
                testing::ThrowsMessage<InputError>(HasSubstr(what)));
  };
  says("a,0,0,0,9\na,0,0,10,-8\n", "lines.csv:3");
  says("a,0,0,0,9\nb,0,0,10,8\nb,0,0,11,8\n", "vessel 'a' has one point");
  says("a,0,0,0,9\na,0,0,10,x\n", "lines.csv:3");
  says("", "fewer than two points");
  says("a,0,0,0,9\n", "fewer than two points");
}

}  // namespace
}  // namespace acus::effects
