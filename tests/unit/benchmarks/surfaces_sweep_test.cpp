#include "benchmarks/surfaces_sweep.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

namespace acus::benchmarks {
namespace {

TEST(SurfacesSweep, TrianglesAreNearerToTheClosedFormThanVoxels) {
  std::map<std::string, std::vector<double>> errors;
  for (const Row& row : SurfacesSweep().run(true, RunContext())) {
    EXPECT_TRUE(std::isfinite(row.error) && row.error >= 0.0) << row.knob << " " << row.value;
    EXPECT_GT(row.step_us_median, 0.0);
    errors[row.knob + ", " + row.error_unit].push_back(row.error);
  }
  for (const char* knob : {"labels from", "labels from, deformed"}) {
    for (const char* unit : {", mm", ", % of pixels"}) {
      const std::vector<double>& e = errors.at(std::string(knob) + unit);
      ASSERT_EQ(e.size(), 4U);  // Voxels of 2 and 1 mm; 30,720 and 122,880 triangles.
      EXPECT_GT(e[0], 1.3 * e[1]) << knob << unit;
      EXPECT_GT(e[1], e[2]) << knob << unit;
      EXPECT_GT(e[2], 2.0 * e[3]) << knob << unit;
    }
    const std::vector<double>& lost = errors.at(std::string(knob) + ", % of lines");
    EXPECT_LE(lost[3], lost[0]);
  }
}

}  // namespace
}  // namespace acus::benchmarks
