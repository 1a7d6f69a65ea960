#include "acus/scene/effects/peristalsis/contraction_wave.h"

#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::effects {
namespace {

// 6 per minute at 8 mm/s: one every 80 mm.
const ContractionWave kWave(6.0, 8.0, 40.0, 0.3);

TEST(ContractionWave, TravelsAtItsSpeed) {
  EXPECT_EQ(kWave.spacing_mm(), 80.0);
  for (const double time_s : {0.0, 3.0, 20.0}) {
    for (const double along_mm : {0.0, 13.0, 70.0}) {
      EXPECT_NEAR(kWave.StrainAt(along_mm, kWave.WavesAt(time_s)),
                  kWave.StrainAt(along_mm + 8.0 * 1.7, kWave.WavesAt(time_s + 1.7)), 1e-12)
          << time_s << " s, " << along_mm << " mm";
    }
  }
}

TEST(ContractionWave, IsARaisedCosineOfItsLengthAndRestBetween) {
  const double waves = kWave.WavesAt(100.0);  // A contraction begins at 0 just now.
  EXPECT_NEAR(kWave.StrainAt(60.0, waves), -0.3, 1e-12) << "middle: 20 mm behind its head at 80 mm";
  EXPECT_NEAR(kWave.StrainAt(50.0, waves), -0.15, 1e-12);
  EXPECT_NEAR(kWave.StrainAt(70.0, waves), -0.15, 1e-12);
  for (const double along_mm : {10.0, 25.0, 39.0}) EXPECT_EQ(kWave.StrainAt(along_mm, waves), 0.0);
  EXPECT_NEAR(kWave.StrainAt(60.0 + 80.0, waves), -0.3, 1e-12) << "the wave before";
}

TEST(ContractionWave, RefusesWhatIsNoWave) {
  EXPECT_THROW(ContractionWave(0.0, 8.0, 40.0, 0.3), InputError);
  EXPECT_THROW(ContractionWave(6.0, 8.0, 81.0, 0.3), InputError) << "they would overlap";
  EXPECT_THROW(ContractionWave(6.0, 8.0, 40.0, 0.95), InputError);
  EXPECT_THROW(ContractionWave(6.0, std::numeric_limits<double>::infinity(), 40.0, 0.3),
               InputError);
  EXPECT_EQ(kWave.WavesAt(std::numeric_limits<double>::infinity()), 0.0);
}

}  // namespace
}  // namespace acus::effects
