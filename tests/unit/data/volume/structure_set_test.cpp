#include "acus/data/volume/structure_set.h"

#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/structure_set_writer.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::CircleContour;
using testing_support::Contour;
using testing_support::StructureSetRoi;

Geometry Grid50() {
  Geometry grid;
  grid.size = {100, 100, 20};
  grid.spacing_mm = {0.5, 0.5, 2.0};
  grid.origin_mm = {-24.75, -24.75, 100.0};
  return grid;
}

class StructureSet : public testing::Test {
 protected:
  NamedValues Read(const std::vector<StructureSetRoi>& rois, const Geometry& grid = Grid50()) {
    WriteStructureSet(folder_ / "s.dcm", rois);
    return ReadStructureSet(folder_ / "s.dcm", grid);
  }
  static double VolumeMm3(const NamedValues& map, int value = 1) {
    return static_cast<double>(std::ranges::count(map.values.voxels, value)) *
           map.values.geometry.voxel_volume_mm3();
  }
  const testing_support::TemporaryFolder folder_;
};

TEST_F(StructureSet, FillsContoursWithHolesOnTheGridOfTheCt) {
  StructureSetRoi ring{.name = "Ring"};
  for (const double z : {110.0, 112.0, 114.0}) {
    ring.contours.push_back(CircleContour(3, -2, z, 15));
    ring.contours.push_back(CircleContour(3, -2, z, 5));
  }
  ring.contours.push_back(ring.contours.front());  // A copy is no hole.
  const NamedValues map = Read({ring});
  ASSERT_TRUE(IsStructureSet(folder_ / "s.dcm"));
  EXPECT_EQ(map.names.at(1).text, "Ring");
  const double truth_mm3 = std::numbers::pi * (15 * 15 - 5 * 5) * 6.0;
  EXPECT_NEAR(VolumeMm3(map), truth_mm3, 0.01 * truth_mm3);
  const auto at = [&](double x, double y, double z) {
    const Eigen::Vector3d index = map.values.geometry.index_from_ct() * Eigen::Vector3d(x, y, z);
    return map.values.At(static_cast<int>(std::lround(index[0])),
                         static_cast<int>(std::lround(index[1])),
                         static_cast<int>(std::lround(index[2])));
  };
  EXPECT_EQ(at(3, -2, 112), 0);
  EXPECT_EQ(at(3 + 10, -2, 112), 1);
  EXPECT_EQ(at(3, -2 - 10, 110), 1);
  EXPECT_EQ(at(3 + 10, -2, 116), 0);
}

TEST_F(StructureSet, AKeyholeContourLeavesItsHole) {
  Contour outer = CircleContour(0, 0, 110, 15), inner = CircleContour(0, 0, 110, 5);
  Contour keyhole = outer;
  keyhole.push_back(outer.front());
  keyhole.push_back(inner.front());
  keyhole.insert(keyhole.end(), inner.rbegin(), inner.rend());
  const double truth_mm3 = std::numbers::pi * (15 * 15 - 5 * 5) * 2.0;
  EXPECT_NEAR(VolumeMm3(Read({{.name = "a", .contours = {keyhole}}})), truth_mm3, 0.01 * truth_mm3);
}

TEST_F(StructureSet, SlicesBetweenPlanesTakeTheNearestOne) {
  StructureSetRoi every_third{.name = "a"};  // Six millimetres apart, on slices of two.
  for (const double z : {106.0, 112.0, 118.0, 124.0}) {
    every_third.contours.push_back(CircleContour(0, 0, z, 10));
  }
  const double truth_mm3 = std::numbers::pi * 100.0 * 24.0;
  EXPECT_NEAR(VolumeMm3(Read({every_third})), truth_mm3, 0.01 * truth_mm3);
  // A gap of several planes is one.
  StructureSetRoi gap{.name = "a"};
  for (const double z : {106.0, 108.0, 110.0, 124.0, 126.0, 128.0}) {
    gap.contours.push_back(CircleContour(0, 0, z, 10));
  }
  EXPECT_NEAR(VolumeMm3(Read({gap})), std::numbers::pi * 100.0 * 12.0, 40.0);
}

TEST_F(StructureSet, LiesOnGridsOfOtherAxes) {
  Geometry sagittal = Grid50();  // i along z, j along -x, k along y: turned, and one axis reversed.
  sagittal.size = {20, 100, 100};
  sagittal.spacing_mm = {2.0, 0.5, 0.5};
  sagittal.direction.col(0) = Eigen::Vector3d(0, 0, 1);
  sagittal.direction.col(1) = Eigen::Vector3d(-1, 0, 0);
  sagittal.direction.col(2) = Eigen::Vector3d(0, -1, 0);
  sagittal.origin_mm = {24.75, 24.75, 100.0};
  const StructureSetRoi disc{.name = "a", .contours = {CircleContour(8, -5, 110, 10)}};
  const NamedValues map = Read({disc}, sagittal);
  EXPECT_NEAR(VolumeMm3(map), std::numbers::pi * 100.0 * 2.0, 7.0);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (int k = 0; k < 100; ++k) {
    for (int j = 0; j < 100; ++j) {
      if (map.values.At(5, j, k) == 0) continue;
      sum += sagittal.ct_from_index() * Eigen::Vector3d(5, j, k);
      count += 1.0;
    }
  }
  EXPECT_LT((sum / count - Eigen::Vector3d(8, -5, 110)).norm(), 0.05);
}

TEST_F(StructureSet, OmitsWhatIsNoTissueAndSaysSo) {
  const NamedValues map =
      Read({{.name = "PTV60", .type = "PTV", .contours = {CircleContour(0, 0, 110, 20)}},
            {.name = "Liver", .contours = {CircleContour(0, 0, 110, 10)}},
            {.name = "Marks", .contours = {{{0, 0, 110}}}, .geometry = "POINT"},
            {.name = "Foot", .contours = {CircleContour(0, 0, 900, 10)}}});
  ASSERT_EQ(map.names.size(), 1U);
  EXPECT_EQ(map.names.begin()->second.text, "Liver");
  EXPECT_EQ(map.named_by,
            "by the names of its ROIs; omitted: PTV60 (PTV), Marks (no contour), Foot (outside the "
            "CT)");
}

TEST_F(StructureSet, RefusesWhatFitsNoSliceOfTheCt) {
  Contour slanted = CircleContour(0, 0, 110, 10);
  for (auto& point : slanted) point.z() += 0.1 * point.x();
  EXPECT_THAT([&] { Read({{.name = "a", .contours = {slanted}}}); },
              ThrowsMessage<InputError>(HasSubstr("do not lie in planes of the CT")));
  EXPECT_THAT([&] { Read({{.name = "a", .contours = {CircleContour(0, 0, 900, 10)}}}); },
              ThrowsMessage<InputError>(HasSubstr("hold no voxel of the CT")));
  EXPECT_THAT([&] { Read({{.name = "a", .contours = {}}}); },
              ThrowsMessage<InputError>(HasSubstr("no closed contour")));
}

TEST_F(StructureSet, AnyCutIsAnErrorAndNothingWorse) {
  Read({{.name = "Liver", .contours = {CircleContour(0, 0, 110, 10, 12)}}});
  const std::string whole = ReadTextFile(folder_ / "s.dcm");
  int refused = 0;
  for (std::size_t size = 200; size < whole.size(); size += 3) {
    WriteTextFile(folder_ / "cut.dcm", whole.substr(0, size));
    try {
      ReadStructureSet(folder_ / "cut.dcm", Grid50());
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 50);
}

TEST_F(StructureSet, OmitsRoisOfAnotherFrameOfReference) {
  const std::vector<Contour> contours = {CircleContour(0, 0, 110, 10),
                                         CircleContour(0, 0, 112, 10)};
  testing_support::WriteStructureSet(
      folder_ / "s.dcm", {{.name = "Liver", .contours = contours, .frame_uid = "1.2"},
                          {.name = "GTV_MR", .contours = contours, .frame_uid = "1.3"},
                          {.name = "Spleen", .contours = {CircleContour(15, 0, 110, 2)}}});
  const NamedValues map = ReadStructureSet(folder_ / "s.dcm", Grid50(), {"1.2"});
  EXPECT_EQ(map.names.size(), 2U);
  EXPECT_THAT(map.named_by, HasSubstr("omitted: GTV_MR (another frame of reference)"));
  // All are taken where the CT's is not known, or is that of none: the caller asks.
  EXPECT_EQ(ReadStructureSet(folder_ / "s.dcm", Grid50()).names.size(), 3U);
  EXPECT_EQ(ReadStructureSet(folder_ / "s.dcm", Grid50(), {"1.9"}).names.size(), 3U);
}

}  // namespace
}  // namespace acus::volume
