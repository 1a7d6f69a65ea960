#include "acus/patient/fitting/curve_phases.h"

#include <gtest/gtest.h>

#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

TEST(CurvePhases, ALongWaitBeforeTheInsertionChangesNothing) {
  for (const double rest_s : {1.0, 100.0}) {
    const DriveMotion drive{
        .rate_hz = 100.0, .rest_s = rest_s, .speed_mm_per_s = 8.0, .end_mm = 24.0, .hold_s = 5.0};
    const forces::ForceCurve curve = Recording(PlainTruth(drive), drive, 0.01, 1);
    const CurvePhases phases = FindPhases(curve);
    EXPECT_NEAR(phases.advance_mm_per_s, 8.0, 1e-6);
    EXPECT_NEAR(curve.time_s[phases.advance.begin], rest_s, 0.1);
    EXPECT_NEAR(curve.time_s[phases.advance.end], rest_s + 3.0, 0.1);
    EXPECT_NEAR(curve.time_s[phases.hold.end], rest_s + 8.0, 0.1);
    EXPECT_NEAR(curve.time_s[phases.retract.end], rest_s + 11.0, 0.1);
  }
}

}  // namespace
}  // namespace acus::fitting
