#include "benchmarks/tissue_picture.h"

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>

#include "benchmarks/insertion.h"

namespace acus::benchmarks {
namespace {

class TissuePictures : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  }
  Provenance provenance;
  TissueBlockTables tables = TissueBlockTables::FromPresets(provenance);
  std::vector<tissue::ToolSample> samples = ScriptedInsertion();
};

/// Column and row of the needle some 15 mm below the skin: 20 mm below the upper edge.
const Eigen::Vector3d& AtTheNeedle(const TissuePicture& picture) {
  const int row = TissuePicture::kPixels / 3;
  return picture.moved_mm[static_cast<std::size_t>(row * TissuePicture::kPixels +
                                                   TissuePicture::kPixels / 2 + 4)];
}

// A needle that moves in takes tissue along, down and by millimetres; air stays where it is.
TEST_F(TissuePictures, EveryModelTakesTissueAlong) {
  for (const TissuePicture& picture :
       {PictureOfFem(6.0, tables, samples, {}), PictureOfPlane(tables, samples),
        PictureOfSprings(tables, samples), PictureOfFunctions(tables, samples)}) {
    ASSERT_EQ(picture.moved_mm.size(), 256u * 256u);
    EXPECT_EQ(picture.moved_mm[128].norm(), 0.0) << "air";
    EXPECT_LT(AtTheNeedle(picture).z(), -0.2);
    EXPECT_GT(AtTheNeedle(picture).z(), -20.0);
    EXPECT_LT(AtTheNeedle(picture).head<2>().norm(), -0.5 * AtTheNeedle(picture).z());
    EXPECT_FALSE(picture.picture_us.empty());
  }
}

TEST_F(TissuePictures, FinerElementsComeNearerAndModelsAreBetterThanNone) {
  const TissuePicture fine = PictureOfFem(4.0, tables, samples, {});
  EXPECT_EQ(RmsDifferenceMm(fine, fine), 0.0);
  EXPECT_LT(RmsDifferenceMm(PictureOfFem(6.0, tables, samples, {}), fine),
            RmsDifferenceMm(PictureOfFem(12.0, tables, samples, {}), fine));
  TissuePicture none = fine;
  for (auto& moved : none.moved_mm) moved.setZero();
  const double without_mm = RmsDifferenceMm(none, fine);
  EXPECT_LT(RmsDifferenceMm(PictureOfSprings(tables, samples), fine), 0.9 * without_mm);
  EXPECT_LT(RmsDifferenceMm(PictureOfFunctions(tables, samples), fine), 0.9 * without_mm);
  EXPECT_LT(RmsDifferenceMm(PictureOfPlane(tables, samples), fine), 0.9 * without_mm);
}

}  // namespace
}  // namespace acus::benchmarks
