#include "acus/imaging/ultrasound/columns/fibre_streaks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::LabelledBlock;

/// Intensities of 16 lanes 0.53 mm apart, at 100 mm along y, from even tissue.
class FibreStreaksTest : public testing::Test {
 protected:
  volume::LabelMap labels_ = LabelledBlock(
      {100, 100, 100}, 1.0, {{1, "muscle"}, {2, "liver"}},
      [](double, double, double z) { return static_cast<volume::Label>(z < 90.0 ? 1 : 2); });

  FibreStreaks Make(const Eigen::Vector3d& along, std::uint64_t seed = 7) const {
    BeamTissue tissue{.labels = &labels_};
    tissue.fibres_in_ct["muscle"] = along;
    return {tissue, seed};
  }

  /// Of beams along x from a place, by sample of 0.47 mm: not in step with the fascicles.
  std::vector<float> Along(const FibreStreaks& streaks, float y, float z) const {
    alignas(64) std::array<std::array<float, 16>, 6> data{};
    for (std::size_t l = 0; l < 16; ++l) {
      data[0][l] = 5.0F;
      data[1][l] = y + 0.53F * static_cast<float>(l);
      data[2][l] = z;
      data[3][l] = 0.47F;
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

  /// Over several patterns of fascicles.
  double MeanDb(const Eigen::Vector3d& along) const {
    double sum = 0.0;
    int count = 0;
    for (std::uint64_t seed = 1; seed <= 16; ++seed) {
      const FibreStreaks streaks = Make(along, seed);
      for (float y = 5.0F; y < 85.0F; y += 13.7F) {
        for (float z = 5.0F; z < 80.0F; z += 5.3F) {
          for (const float value : Along(streaks, y, z)) {
            sum += 10.0 * std::log10(double{value});
            ++count;
          }
        }
      }
    }
    return sum / count;
  }
};

TEST_F(FibreStreaksTest, FibresAnswerByTheirAngle) {
  EXPECT_NEAR(10.0 * std::log10(FibreIntensity(std::sqrt(0.5))), -10.0, 1e-9);
  EXPECT_NEAR(MeanDb({0, 1, 0}), 0.0, 0.3);
  EXPECT_NEAR(MeanDb({0, 1, 1}), 0.0, 0.3);
  EXPECT_NEAR(MeanDb({0.3, 1, 2}), MeanDb({0.3, 2, 1}), 0.5);
}

TEST_F(FibreStreaksTest, FibresAtFortyFiveDegreesAreTenDecibelsFainter) {
  // Between the sheets, which lie 11.8 dB below the mean; the sheets mirror elsewhere.
  std::vector<float> oblique = Along(Make({1, 1, 0}), 40.0F, 40.0F);
  std::vector<float> across = Along(Make({0, 1, 0}), 40.0F, 40.0F);
  const auto least = [](const std::vector<float>& values) {
    return 10.0 * std::log10(double{*std::min_element(values.begin(), values.end())});
  };
  EXPECT_NEAR(least(across), -11.8, 0.7);
  EXPECT_NEAR(least(oblique) - least(across), -10.0, 0.7);
}

TEST_F(FibreStreaksTest, SheetsAreBrightWhereTheyFaceTheBeam) {
  std::vector<float> all;
  for (float y = 5.0F; y < 85.0F; y += 8.0F) {
    for (const float value : Along(Make({0, 0, 1}), y, 40.0F)) all.push_back(value);
  }
  std::sort(all.begin(), all.end());
  const auto db_at = [&](double share) {
    return 10.0 * std::log10(double{
                      all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))]});
  };
  EXPECT_LT(db_at(1.0), 18.3);  // 30 dB over what they enclose.
  EXPECT_GT(db_at(0.995), 12.0);
  EXPECT_LT(db_at(0.5), 0.0);
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

// Lobules of fat are dark between bright septa; their mean in dB is that of the tissue.
TEST_F(FibreStreaksTest, FatAndSoftTissueHaveSepta) {
  labels_.names = {{1, "soft_tissue"}, {2, "liver"}};
  EXPECT_NEAR(MeanDb({0, 1, 0}), 0.0, 0.5);
  labels_.names = {{1, "fat"}, {2, "liver"}};
  EXPECT_NEAR(MeanDb({0, 1, 0}), 0.0, 0.5);
  std::vector<float> all = Along(FibreStreaks({.labels = &labels_}, 3), 40.0F, 40.0F);
  std::sort(all.begin(), all.end());
  const auto db_at = [&](double share) {
    return 10.0 * std::log10(double{
                      all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))]});
  };
  EXPECT_LT(db_at(0.25), -2.0);
  EXPECT_GT(db_at(0.97), 6.0);
}

}  // namespace
}  // namespace acus::ultrasound
