#include "benchmarks/tissue_image.h"

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>

#include "benchmarks/insertion.h"

namespace acus::benchmarks {
namespace {

class TissueImages : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  }
  Provenance provenance;
  TissueBlockTables tables = TissueBlockTables::FromPresets(provenance);
  std::vector<tissue::ToolSample> samples = ScriptedInsertion();
};

/// Column and row of the needle some 15 mm below the skin: 20 mm below the upper edge.
const Eigen::Vector3d& AtTheNeedle(const TissueImage& image) {
  const int row = TissueImage::kPixels / 3;
  return image.moved_mm[static_cast<std::size_t>(row * TissueImage::kPixels +
                                                 TissueImage::kPixels / 2 + 4)];
}

// A needle that moves in takes tissue along, down and by millimetres; air stays where it is.
TEST_F(TissueImages, EveryModelTakesTissueAlong) {
  for (const TissueImage& image :
       {ImageOfFem(6.0, tables, samples, {}), ImageOfPlane(tables, samples),
        ImageOfSprings(tables, samples), ImageOfFunctions(tables, samples)}) {
    ASSERT_EQ(image.moved_mm.size(), 256u * 256u);
    EXPECT_EQ(image.moved_mm[128].norm(), 0.0) << "air";
    EXPECT_LT(AtTheNeedle(image).z(), -0.2);
    EXPECT_GT(AtTheNeedle(image).z(), -20.0);
    EXPECT_LT(AtTheNeedle(image).head<2>().norm(), -0.5 * AtTheNeedle(image).z());
    EXPECT_FALSE(image.image_us.empty());
  }
}

TEST_F(TissueImages, FinerElementsComeNearerAndModelsAreBetterThanNone) {
  const TissueImage fine = ImageOfFem(4.0, tables, samples, {});
  EXPECT_EQ(RmsDifferenceMm(fine, fine), 0.0);
  EXPECT_LT(RmsDifferenceMm(ImageOfFem(6.0, tables, samples, {}), fine),
            RmsDifferenceMm(ImageOfFem(12.0, tables, samples, {}), fine));
  TissueImage none = fine;
  for (auto& moved : none.moved_mm) moved.setZero();
  const double without_mm = RmsDifferenceMm(none, fine);
  EXPECT_LT(RmsDifferenceMm(ImageOfSprings(tables, samples), fine), 0.9 * without_mm);
  EXPECT_LT(RmsDifferenceMm(ImageOfFunctions(tables, samples), fine), 0.9 * without_mm);
  EXPECT_LT(RmsDifferenceMm(ImageOfPlane(tables, samples), fine), 0.9 * without_mm);
}

}  // namespace
}  // namespace acus::benchmarks
