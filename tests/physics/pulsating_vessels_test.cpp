// A vessel that pulsates, in a whole scene: images show its wall where the closed form says, and
// the needle feels tissue that comes and goes.
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/simulation.h"
#include "support/temporary_folder.h"

namespace acus::simulation {
namespace {

constexpr double kRadiusMm = 8.0;
constexpr double kStrain = 0.12;
/// 60 beats a minute and a rise of 0.2: the peak of systole is at 0.2 s.
constexpr std::int64_t kPeakNs = 200'000'000;

/// A bright cylinder along y, in the middle of grey tissue, 30 mm below the skin at z = 0.
class PulsatingScene : public testing::Test {
 protected:
  PulsatingScene() {
    setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    volume::Geometry geometry;
    geometry.size = {140, 60, 140};
    geometry.spacing_mm = {0.5, 1.0, 0.5};
    geometry.origin_mm = {-35.0, -30.0, -5.0};
    volume::CtVolume ct(geometry, std::int16_t{-1000});
    volume::LabelMap labels(geometry);
    labels.names[kMuscle] = "muscle";
    const auto mm = [](int index, double spacing, double origin) {
      return origin + spacing * index;
    };
    for (int k = 0; k < 140; ++k) {
      for (int j = 0; j < 60; ++j) {
        for (int i = 0; i < 140; ++i) {
          const double z = mm(k, 0.5, -5.0);
          if (z < 0.0) continue;
          const double r = std::hypot(mm(i, 0.5, -35.0), z - 30.0);
          // A soft edge of a millimetre: its middle lies between the voxels.
          const double share = std::clamp(0.5 + kRadiusMm - r, 0.0, 1.0);
          ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(40.0 + 200.0 * share));
          labels.At(i, j, k) = kMuscle;
        }
      }
    }
    volume::WriteCt(folder() / "ct.nrrd", ct);
    volume::WriteLabelMap(folder() / "labels.seg.nrrd", labels);
    WriteTextFile(folder() / "vessel.csv",
                  "vessel,x_mm,y_mm,z_mm,radius_mm\na,0,-60,30,8\na,0,60,30,8\n");
  }

  Scene Load(double strain, double warp_spacing_mm = 1.0) {
    config::WriteJson(
        folder() / "scene.json",
        {{"format", "acus-scenario/1"},
         {"patient", {{"ct", "ct.nrrd"}, {"labels", "labels.seg.nrrd"}}},
         {"probe", "probes/linear_l14.json"},
         {"effects",
          {{"needle_force", {{"model", "layered"}, {"table", "forces/bovine_2021.json"}}},
           {"ct_slice", {{"needle", false}, {"window", {{"centre_hu", 140}, {"width_hu", 400}}}}},
           {"pulsating_vessels",
            {{"centrelines", "vessel.csv"},
             {"radial_strain", strain},
             {"warp_spacing_mm", warp_spacing_mm},
             {"heart_rate_per_min", 60},
             {"rise_share", 0.2}}}}}});
    const auto scenario = scenario::ReadScenario(folder() / "scene.json", {});
    RunContext context;
    return LoadScene(scenario, PlanEffects(scenario, {.needle_poses = true, .probe_poses = true}),
                     context);
  }

  /// The slice through the vessel's axis at the peak of systole.
  image::GrayImage SliceAtPeak(const Scene& scene) {
    const Simulation simulation(scene);
    State state = simulation.NewState();
    simulation.Step(state, {.time_ns = kPeakNs, .needle_valid = false});
    Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
    probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    ProbeImageRenderer renderer(scene);
    ProbeImages images;
    renderer.Render({.time_ns = kPeakNs,
                     .session_s = 0.2,
                     .probe_valid = true,
                     .ct_from_probe = probe,
                     .memory = &state.effects},
                    images);
    return images.ct_slice;
  }

  /// Depth of the upper and of the lower wall in the middle column, mm.
  std::pair<double, double> Walls(const Scene& scene, const image::GrayImage& slice) {
    const auto geometry = acoustics::ImageOf(*scene.probe);
    const int column = geometry.width_px / 2;
    const auto depth_mm = [&](double row) {
      return geometry.depth_of_top_row_mm + geometry.axial_mm_per_px * row;
    };
    // Half-way between vessel and tissue.
    const int middle =
        static_cast<int>((30.0 - geometry.depth_of_top_row_mm) / geometry.axial_mm_per_px);
    const double half = 0.5 * (slice.At(column, middle) + slice.At(column, middle / 3));
    const auto edge = [&](int step) {
      int row = middle;
      while (slice.At(column, row) > half) row += step;
      const double last = slice.At(column, row - step);
      const double now = slice.At(column, row);
      return depth_mm(row - step * (half - now) / (last - now));
    };
    return {edge(-1), edge(1)};
  }

  const std::filesystem::path& folder() const { return temporary_.path(); }

  static constexpr volume::Label kMuscle = 3;
  testing_support::TemporaryFolder temporary_;
};

// Between knots the motion is linear, but it has a bend at the wall: from e inside to a slope of
// about -0.17 outside. A wall half-way between two knots is off by a quarter of the spacing times
// 0.29.
TEST_F(PulsatingScene, AnImageShowsTheWallWhereTheClosedFormSays) {
  for (const double strain : {0.0, kStrain}) {
    for (const double spacing_mm : {2.0, 1.0, 0.25}) {
      const Scene scene = Load(strain, spacing_mm);
      const auto [upper_mm, lower_mm] = Walls(scene, SliceAtPeak(scene));
      const double bound_mm = 0.02 + (strain > 0.0 ? 0.25 * spacing_mm * 0.29 : 0.0);
      EXPECT_NEAR(upper_mm, 30.0 - kRadiusMm * (1.0 + strain), bound_mm) << spacing_mm;
      EXPECT_NEAR(lower_mm, 30.0 + kRadiusMm * (1.0 + strain), bound_mm) << spacing_mm;
    }
  }
}

// A needle that halts in the tissue before the vessel: its force follows the heart.
TEST_F(PulsatingScene, ANeedleAtRestFeelsThePulse) {
  const auto swing_n = [this](double strain) {
    const Scene scene = Load(strain);
    const Simulation simulation(scene);
    State state = simulation.NewState();
    double least_n = 1e9;
    double most_n = -1e9;
    for (int ms = 0; ms < 5000; ++ms) {
      Sample sample{.time_ns = ms * std::int64_t{1'000'000}, .needle_valid = true};
      sample.reference_from_needle =
          Eigen::Translation3d(1.0, 0.0, std::min(-4.0 + 0.02 * ms, 19.0));
      const StepOutput out = simulation.Step(state, sample);
      EXPECT_TRUE(out.force.force_in_ct_n.allFinite());
      if (ms < 3000) continue;
      least_n = std::min(least_n, out.force.AxialN());
      most_n = std::max(most_n, out.force.AxialN());
    }
    return most_n - least_n;
  };
  EXPECT_LT(swing_n(0.0), 0.01);
  EXPECT_GT(swing_n(kStrain), 0.05);
}

// The same numbers from a copy of the state: nothing is kept elsewhere.
TEST_F(PulsatingScene, ACopyOfTheStateContinuesWithTheSameBits) {
  const Scene scene = Load(kStrain);
  const Simulation simulation(scene);
  State state = simulation.NewState();
  const auto step = [&](State& of, int ms) {
    Sample sample{.time_ns = ms * std::int64_t{1'000'000}, .needle_valid = true};
    sample.reference_from_needle = Eigen::Translation3d(1.0, 0.0, 0.01 * ms);
    return simulation.Step(of, sample).force.force_in_ct_n;
  };
  for (int ms = 0; ms < 700; ++ms) step(state, ms);
  State copy = state;
  for (int ms = 700; ms < 1500; ++ms) ASSERT_EQ(step(copy, ms), step(state, ms)) << ms;
}

}  // namespace
}  // namespace acus::simulation
