#include "acus/imaging/ultrasound/fibre_streaks.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::LabelledBlock;

/// Intensities of one line of 16 lanes 0.5 mm apart, at 100 mm along y, from even tissue.
class FibreStreaksTest : public testing::Test {
 protected:
  volume::LabelMap labels_ = LabelledBlock(
      {100, 100, 100}, 1.0, {{1, "muscle"}, {2, "fat"}},
      [](double, double, double z) { return static_cast<volume::Label>(z < 90.0 ? 1 : 2); });

  FibreStreaks Make(const Eigen::Vector3d& along) const {
    BeamTissue tissue{.labels = &labels_};
    tissue.fibres_in_ct["muscle"] = along;
    return {tissue, 7};
  }

  /// Of beams along x from a place, by sample of 0.5 mm.
  std::vector<float> Along(const FibreStreaks& streaks, float y, float z) const {
    alignas(64) std::array<std::array<float, 16>, 6> data{};
    for (std::size_t l = 0; l < 16; ++l) {
      data[0][l] = 5.0F;
      data[1][l] = y + 0.5F * static_cast<float>(l);
      data[2][l] = z;
      data[3][l] = 0.5F;
    }
    const slicing::kernels::Lines lines{{data[0].data(), data[1].data(), data[2].data()},
                                        {data[3].data(), data[4].data(), data[5].data()}};
    std::vector<float> all;
    for (int s = 0; s < 180; ++s) {
      std::array<float, 16> row;
      row.fill(1.0F);
      streaks.ApplyRow(lines, static_cast<float>(s), 16, row.data());
      all.insert(all.end(), row.begin(), row.end());
    }
    return all;
  }

  double Mean(const FibreStreaks& streaks) const {
    double sum = 0.0;
    int count = 0;
    for (float y = 5.0F; y < 85.0F; y += 11.0F) {
      for (float z = 5.0F; z < 80.0F; z += 9.0F) {
        for (const float value : Along(streaks, y, z)) {
          sum += double{value};
          ++count;
        }
      }
    }
    return sum / count;
  }
};

TEST_F(FibreStreaksTest, FibresAnswerByTheirAngle) {
  EXPECT_NEAR(10.0 * std::log10(FibreIntensity(std::sqrt(0.5))), -10.0, 1e-9);
  EXPECT_NEAR(Mean(Make({0, 1, 0})), 1.0, 0.05);
  EXPECT_NEAR(Mean(Make({0.3, 1, 2})), Mean(Make({0.3, 2, 1})), 0.1);
  // At 45 degrees: 10 dB lower between the sheets, 20 dB lower in them.
  const double oblique = 0.1 * (0.2274 + 0.1 * (1.0 - 0.2274));
  EXPECT_NEAR(Mean(Make({1, 1, 0})) / oblique, 1.0, 0.05);
}

TEST_F(FibreStreaksTest, StreaksRunAlongTheFibres) {
  const FibreStreaks streaks = Make({0, 0, 1});
  const std::vector<float> here = Along(streaks, 40.0F, 40.0F);
  const auto correlation = [&](const std::vector<float>& there) {
    double both = 0.0;
    double a2 = 0.0;
    double b2 = 0.0;
    for (std::size_t n = 0; n < here.size(); ++n) {
      const double a = double{here[n]} - 1.0;
      const double b = double{there[n]} - 1.0;
      both += a * b;
      a2 += a * a;
      b2 += b * b;
    }
    return both / std::sqrt(a2 * b2);
  };
  EXPECT_GT(correlation(Along(streaks, 40.0F, 43.0F)), 0.7);  // 3 mm along.
  EXPECT_LT(correlation(Along(streaks, 43.0F, 40.0F)), 0.3);  // 3 mm across.
}

TEST_F(FibreStreaksTest, OtherTissueIsLeftAlone) {
  for (const float value : Along(Make({0, 1, 0}), 40.0F, 95.0F)) EXPECT_EQ(value, 1.0F);
  BeamTissue tissue{.labels = &labels_};
  EXPECT_FALSE(FibreStreaks(tissue, 0).any());
}

}  // namespace
}  // namespace acus::ultrasound
