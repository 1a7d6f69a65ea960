#include "acus/run/replay/exercise_watch.h"

#include <gtest/gtest.h>
#include <string>

#include "support/layered_scene.h"

namespace acus::replay {
namespace {

/// Straight down through the skin at z = 0, from 5 mm above it to 20 mm below, 1 mm in each 0.1 s.
TEST(ExerciseWatch, MeasuresTheWayInTissue) {
  const simulation::Scene scene =
      testing_support::LayeredScene(testing_support::PlanOf(true, false, false, false), true);
  ExerciseWatch watch({}, scene, std::nullopt);
  for (int i = 0; i <= 25; ++i) {
    const Eigen::Vector3d tip_ct_mm(0.0, 20.0, -5.25 + i);
    watch.Add({.time_ns = i * std::int64_t{100'000'000},
               .reference_from_tool = transforms::Pose(scene.ct_from_reference.inverse() *
                                                       Eigen::Translation3d(tip_ct_mm)),
               .valid = true},
              nullptr, {});
  }
  const auto value = [&](const std::string& name) {
    for (const auto& metric : watch.Metrics()) {
      if (metric.name == name) return metric.value;
    }
    ADD_FAILURE() << name;
    return 0.0;
  };
  EXPECT_NEAR(value("needle path length"), 25.0, 1e-9);
  EXPECT_NEAR(value("needle elapsed time"), 2.5, 1e-9);
  EXPECT_NEAR(value("needle time in tissue"), 2.0, 0.11);
  EXPECT_EQ(value("attempts"), 1.0);
}

}  // namespace
}  // namespace acus::replay
