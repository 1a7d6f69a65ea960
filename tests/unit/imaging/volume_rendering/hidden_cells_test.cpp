#include "acus/imaging/volume_rendering/hidden_cells.h"

#include <gtest/gtest.h>

#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

// What is between two samples of hidden cells that touch shows nothing; and much is hidden.
TEST(HiddenCells, NothingShowsBetweenTwoOfThem) {
  const auto ct = testing_support::BallCt({0, -5, 5}, 35.0);
  for (const char* layer : {"skin", "bone", "soft_tissue"}) {
    const VolumeLayer layers[] = {{layer, 1.0}};
    const TransferFunction transfer(layers);
    const HiddenCells cells(*ct, transfer);
    int hidden = 0;
    int shown = 0;
    const Eigen::Array3i size = ct->geometry.size;
    for (int k = 0; k + 1 < size[2]; ++k) {
      for (int j = 0; j + 1 < size[1]; ++j) {
        for (int i = 0; i + 1 < size[0]; ++i) {
          const Eigen::Vector3f here(static_cast<float>(i) + 0.5F, static_cast<float>(j) + 0.5F,
                                     static_cast<float>(k) + 0.5F);
          const Eigen::Vector3f next = here + Eigen::Vector3f::Ones();
          const auto at = [&](const Eigen::Vector3f& index) {
            const Eigen::Array3i low = index.array().cast<int>();
            return static_cast<float>(ct->At(low[0], low[1], low[2]));
          };
          if (cells.Hides(here)) {
            ++hidden;
            EXPECT_FALSE(transfer.Shows(at(here), at(here)));
            if (cells.Hides(next)) {
              const float low = std::min(at(here), at(next));
              const float high = std::max(at(here), at(next));
              EXPECT_FALSE(transfer.Shows(low, high)) << layer;
            }
          } else {
            ++shown;
          }
        }
      }
    }
    EXPECT_GT(hidden, shown) << layer;
    EXPECT_GT(shown, 0) << layer;
  }
}

TEST(HiddenCells, OutsideTheVolumeNothingIsHidden) {
  const auto ct = testing_support::BallCt({0, 0, 0}, 20.0);
  const VolumeLayer layers[] = {{"bone", 1.0}};
  const HiddenCells cells(*ct, TransferFunction(layers));
  EXPECT_TRUE(cells.Hides({1.0F, 1.0F, 1.0F}));
  EXPECT_FALSE(cells.Hides({-0.1F, 1.0F, 1.0F}));
  EXPECT_FALSE(cells.Hides({1.0F, 1e9F, 1.0F}));
  EXPECT_FALSE(cells.Hides({1.0F, 1.0F, std::nanf("")}));
  EXPECT_FALSE(HiddenCells().Hides({0.0F, 0.0F, 0.0F}));
}

}  // namespace
}  // namespace acus::volume_rendering
