// What breathing may cost: in the hand's step, in a picture, in memory; for every motion model, and
// whatever the resolution of its field.
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>
#include <malloc.h>
#include <map>

#include "core/cpu_time.h"
#include "simulation/breathing_scene.h"
#include "simulation/image_level.h"
#include "simulation/simulation.h"
#include "support/bending_scene.h"
#include "support/breathing_patients.h"
#include "support/paired_times.h"
#include "support/reslice_scene.h"

namespace acus {
namespace {

using breathing::MotionKind;
using testing_support::BreathingPatient;
using testing_support::kAllMotionKinds;

constexpr int kResolutions[] = {64, 128, 256};

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// A trunk around the block of BendingScene, that moves across the needle.
BreathingPatient AroundTheNeedle(MotionKind kind, int nodes_per_axis) {
  BreathingPatient patient{.kind = kind, .nodes_per_axis = nodes_per_axis};
  patient.box.size.setConstant(301);
  patient.box.origin_mm = {-150.0, -150.0, -70.0};
  patient.towards = {0.0, 1.0, 0.3};
  return patient;
}

/// A needle of 25 nodes, layered forces along it, in and out of tissue while the hand leans.
simulation::Sample HandAt(int step, double step_s) {
  const double t = step_s * step;
  const double depth_mm = t < 1.0 ? 45.0 * t - 2.0 : 43.0 + 8.0 * std::sin(2.0 * t - 2.0);
  return testing_support::NeedleAt(t, {std::sin(3.0 * t), std::cos(2.1 * t), depth_mm},
                                   {0.1 * std::sin(2.5 * t), 0.05, 0.0});
}

simulation::Scene NeedleScene() {
  testing_support::BendingScene bending;
  bending.tissue = nullptr;
  return bending.Make();
}

/// Two patients under the same hand, step by step in turns, so that both meet the same noise.
struct StepTimes {
  double still_us = 0.0;
  double added_us = 0.0;
};
StepTimes TimeSteps(simulation::Scene& breathing_scene, double step_s) {
  const simulation::Scene still_scene = NeedleScene();
  const simulation::Simulation still(still_scene);
  const simulation::Simulation breathing(breathing_scene);
  simulation::State of_still = still.NewState();
  simulation::State of_breathing = breathing.NewState();
  std::vector<double> still_us, breathing_us;
  for (int n = 0; n < 6000; ++n) {
    const simulation::Sample sample = HandAt(n, step_s);
    const double begin_s = ThreadCpuSeconds();
    const auto a = still.Step(of_still, sample);
    const double middle_s = ThreadCpuSeconds();
    const auto b = breathing.Step(of_breathing, sample);
    const double end_s = ThreadCpuSeconds();
    if (!a.shape.bent || !b.shape.bent) continue;
    still_us.push_back(1e6 * (middle_s - begin_s));
    breathing_us.push_back(1e6 * (end_s - middle_s));
  }
  EXPECT_GT(still_us.size(), 3000u);
  const double median_us = MedianOf(still_us);
  return {median_us, MedianOf(breathing_us) - median_us};
}

// Issue: at most 5 us, whatever the model, and less than a fifth more from 64^3 to 256^3 nodes. The
// paper's loop has 500 us; ours aims for 100 in all. Measured 1.7 to 3.0 us on steps of 11.
TEST(BreathingSpeed, AStepWithTwentyFiveNodesTakesAtMostFiveMicrosecondsMore) {
  simulation::Scene scene = NeedleScene();
  for (const MotionKind kind : kAllMotionKinds) {
    std::map<int, double> added_us;
    for (const int nodes : kResolutions) {
      scene.breathing.emplace(AroundTheNeedle(kind, nodes).Make());
      StepTimes best = TimeSteps(scene, 1e-3);
      for (int again = 0; again < 3 && best.added_us > 5.0; ++again) {
        const StepTimes next = TimeSteps(scene, 1e-3);
        if (next.added_us < best.added_us) best = next;
      }
      std::printf("  %-10s %3d^3: %5.2f us without, %5.2f more\n",
                  std::string(NameOf(kind)).c_str(), nodes, best.still_us, best.added_us);
      EXPECT_LT(best.added_us, 5.0) << NameOf(kind) << " " << nodes;
      EXPECT_LT(best.still_us + best.added_us, 50.0) << NameOf(kind) << " " << nodes;
      added_us[nodes] = best.added_us;
    }
    // Of what breathing adds, less what the clock cannot tell.
    EXPECT_LT(added_us[256], 1.2 * added_us[64] + 0.1) << NameOf(kind);
  }
}

// 10 kHz: the whole step, 99 of 100, within 100 us.
TEST(BreathingSpeed, TenKilohertzInAll) {
  simulation::Scene scene = NeedleScene();
  scene.breathing.emplace(AroundTheNeedle(MotionKind::kSurrogate, 128).Make());
  const simulation::Simulation simulation(scene);
  simulation::State state = simulation.NewState();
  std::vector<double> times_us;
  for (int n = 0; n < 30000; ++n) {
    const simulation::Sample sample = HandAt(n, 1e-4);
    const double begin_s = ThreadCpuSeconds();
    simulation.Step(state, sample);
    times_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
  }
  std::ranges::sort(times_us);
  const double p99_us = times_us[times_us.size() * 99 / 100];
  std::printf("  median %.1f us, 99 %% %.1f us\n", MedianOf(times_us), p99_us);
  EXPECT_LT(p99_us, 100.0);
}

/// What the 25 places of the needle's nodes cost alone.
double NodesUs(const breathing::MotionMap& map) {
  double least_us = 1e9;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int round = 0; round < 50; ++round) {
    constexpr int kTimes = 200;
    const double begin_s = ThreadCpuSeconds();
    for (int n = 0; n < kTimes; ++n) {
      for (int node = 0; node < 25; ++node) {
        sum += map.DisplacementMm({0.02 * n, 0.5 * node - 10.0, 4.8 * node - 40.0});
      }
    }
    least_us = std::min(least_us, 1e6 * (ThreadCpuSeconds() - begin_s) / kTimes);
  }
  EXPECT_TRUE(sum.allFinite());
  return least_us;
}

// Measured 0.9 us for one field, 1.3 for two, 1.7 for three.
TEST(BreathingSpeed, TwentyFiveDisplacementsTakeTwoMicrosecondsAtAnyResolution) {
  for (const MotionKind kind : kAllMotionKinds) {
    std::map<int, double> us;
    for (const int nodes : kResolutions) {
      const BreathingPatient patient = AroundTheNeedle(kind, nodes);
      const breathing::MotionModel model = patient.Model();
      us[nodes] = NodesUs({model.field(), model.WeightsAt(patient.BreathAt(0.3))});
    }
    std::printf("  %-10s %.2f / %.2f / %.2f us\n", std::string(NameOf(kind)).c_str(), us[64],
                us[128], us[256]);
    EXPECT_LT(us[256], 5.0) << NameOf(kind);
    EXPECT_LT(us[256], 1.2 * us[64]) << NameOf(kind);
  }
}

/// CT, labels and the four levels of image, as large as those of a real patient.
class Pictures {
 public:
  Pictures() : ct_(testing_support::AbdomenCt()), labels_(ct_.geometry) {
    for (std::size_t n = 0; n < ct_.voxels.size(); ++n) {
      const char* tissue = ct_.voxels[n] > 400 ? "bone" : "liver";
      if (ct_.voxels[n] > -500) labels_.voxels[n] = volume::LabelOf(tissue);
    }
    for (const auto& label : volume::StandardLabels()) {
      labels_.names[label.label] = std::string(label.name);
    }
  }

  /// The levels of image, with the presets that are shipped for them.
  std::map<std::string, simulation::ImageLevel> Levels() const {
    const std::filesystem::path acoustics =
        std::filesystem::path(ACUS_SOURCE_DIR) / "configs/acoustics";
    const ultrasound::Probe probe = testing_support::FullLinearProbe();
    simulation::BeamSettings beams;
    beams.acoustics = ultrasound::ReadTissueAcoustics(acoustics / "tissues.json");
    simulation::BeamSettings beams_of_ct = beams;
    beams_of_ct.from_ct = true;
    beams_of_ct.from_labels = false;
    const simulation::ImagePatient patient{&ct_, &labels_};
    std::map<std::string, simulation::ImageLevel> levels;
    const auto add = [&](const char* name, const ultrasound::Probe& by,
                         const simulation::ImageSettings& settings) {
      levels.try_emplace(name, patient, by, settings);
    };
    add("vidal_2008", probe, ultrasound::ReadVidalOptions(acoustics / "vidal_2008.json"));
    add("alamilla_2021", probe, ultrasound::ReadAlamillaOptions(acoustics / "alamilla_2021.json"));
    add("columns_2010", probe, ultrasound::ReadBModeOptions(acoustics / "hu_textured.json"));
    add("beams", testing_support::FullBeamProbe(256, 512), beams);
    add("beams of the CT", testing_support::FullBeamProbe(256, 512), beams_of_ct);
    return levels;
  }

  BreathingPatient Patient(MotionKind kind, int nodes_per_axis) const {
    return {.kind = kind, .nodes_per_axis = nodes_per_axis, .box = ct_.geometry};
  }

 private:
  volume::CtVolume ct_;
  volume::LabelMap labels_;
};

/// Least CPU time of a picture with breathing over that of one without.
double ShareOfBreathing(simulation::ImageLevel& level, const simulation::Breathing& patient,
                        double limit) {
  testing_support::LeastTime still;
  testing_support::LeastTime breathing;
  ultrasound::GrayImage image;
  const auto share = [&] { return breathing.cpu_ms / still.cpu_ms; };
  for (int n = 0; n < 15 || (n < 200 && share() > limit); ++n) {
    const Eigen::Isometry3d pose = testing_support::SwayingProbe(n);
    const auto needle = testing_support::NeedleInPlane(pose);
    still.Add([&] { level.Render(pose, needle, image, 1, nullptr); });
    breathing.Add([&] {
      const simulation::BreathingRest rest(patient, 0.8 + 0.033 * n, {}, nullptr);
      level.Render(pose, needle, image, 1, &rest);
    });
  }
  return share();
}

// Issue: at most 40 %, for every model of motion. Measured 2 to 18 %, alamilla_2021 23 to 31.
TEST(BreathingSpeed, APictureTakesAtMostFortyPercentMore) {
  const Pictures pictures;
  auto levels = pictures.Levels();
  for (const MotionKind kind : kAllMotionKinds) {
    std::map<std::string, std::map<int, double>> shares;
    for (const int nodes : {64, 256}) {
      const simulation::Breathing patient = pictures.Patient(kind, nodes).Make();
      for (auto& [name, level] : levels) {
        const double share = ShareOfBreathing(level, patient, 1.4);
        std::printf("  %-10s %3d^3, %-15s %.2f times\n", std::string(NameOf(kind)).c_str(), nodes,
                    name.c_str(), share);
        EXPECT_LT(share, 1.4) << NameOf(kind) << " " << nodes << " " << name;
        shares[name][nodes] = share;
      }
    }
    for (auto& [name, share] : shares) {
      EXPECT_LT(share[256], 1.2 * share[64]) << NameOf(kind) << " " << name;
    }
  }
}

// Issue: 1 GB for ten phases of 256^3 nodes, of which the reference needs none.
TEST(BreathingSpeed, TenPhasesOf256NodesEachWayFitIntoAGigabyte) {
  volume::Geometry nodes;
  nodes.size.setConstant(256);
  const auto allocated = [] {
    const struct mallinfo2 now = mallinfo2();
    return static_cast<double>(now.uordblks + now.hblkhd);
  };
  const double before = allocated();
  std::vector<breathing::KeyFrame> frames{{0.0, breathing::KeyFrame::kReference}};
  for (int n = 1; n < 10; ++n) frames.push_back({0.1 * n, n - 1});
  const auto model =
      breathing::MotionModel::FullCycle(breathing::MotionField(nodes, 9), std::move(frames));
  const double bytes = allocated() - before;
  std::printf("  %.0f MB\n", 1e-6 * bytes);
  EXPECT_LT(bytes, 1e9);
  EXPECT_GT(bytes, 9 * 3 * 2 * 256.0 * 256.0 * 256.0);
  EXPECT_NEAR(bytes, static_cast<double>(model.field().bytes()), 1e6);
}

}  // namespace
}  // namespace acus
