// What breathing may cost: in the hand's step, in an image, in memory; for every motion model, and
// whatever the resolution of its field.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <gtest/gtest.h>
#include <malloc.h>
#include <map>
#include <set>
#include <thread>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/scene/simulation/breathing_scene.h"
#include "acus/scene/simulation/simulation.h"
#include "acus/scene/simulation/ultrasound_model.h"
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

  double Share() const { return added_us / still_us; }
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
  const double median_us = math::Median(still_us);
  return {median_us, math::Median(breathing_us) - median_us};
}

// At most 5 us on a step of 11 us, whatever the model, and less than a fifth more from 64^3 to
// 256^3 nodes. The paper's loop has 500 us; ours aims for 100 in all. Measured 0.15 to 0.29 of the
// step.
TEST(BreathingSpeed, AStepWithTwentyFiveNodesTakesAtMostFiveElevenths) {
  constexpr double kMostShare = 5.0 / 11.0;
  simulation::Scene scene = NeedleScene();
  for (const MotionKind kind : kAllMotionKinds) {
    std::map<int, StepTimes> best;
    const auto measure = [&] {
      for (const int nodes : kResolutions) {
        scene.breathing.emplace(AroundTheNeedle(kind, nodes).Make());
        const StepTimes next = TimeSteps(scene, 1e-3);
        const auto [at, is_first] = best.try_emplace(nodes, next);
        if (!is_first && next.Share() < at->second.Share()) at->second = next;
      }
    };
    // In shares of the still step beside it: the clock of a shared machine differs from one
    // resolution to the next. The second term is what the clock cannot tell.
    const auto most_share_at_256 = [&] { return 1.2 * best[64].Share() + 0.1 / best[64].still_us; };
    testing_support::MeasureUntil(1, 12, measure, [&] {
      return best[64].Share() < kMostShare && best[256].Share() < kMostShare &&
             best[256].Share() < most_share_at_256();
    });
    for (const auto& [nodes, times] : best) {
      std::printf("  %-10s %3d^3: %5.2f us without, %5.2f more\n",
                  std::string(NameOf(kind)).c_str(), nodes, times.still_us, times.added_us);
      EXPECT_LT(times.Share(), kMostShare) << NameOf(kind) << " " << nodes;
      EXPECT_LT(times.still_us + times.added_us, 50.0) << NameOf(kind) << " " << nodes;
    }
    EXPECT_LT(best[256].Share(), most_share_at_256()) << NameOf(kind);
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
  const double p99_us = math::Quantile(times_us, 0.99);
  std::printf("  median %.1f us, 99 %% %.1f us\n", math::Median(times_us), p99_us);
  EXPECT_LT(p99_us, 100.0);
}

/// What the 25 places of the needle's nodes cost alone.
double NodesUs(const breathing::MotionMap& map) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  constexpr int kTimes = 200;
  const double begin_s = ThreadCpuSeconds();
  for (int n = 0; n < kTimes; ++n) {
    for (int node = 0; node < 25; ++node) {
      sum += map.DisplacementMm({0.02 * n, 0.5 * node - 10.0, 4.8 * node - 40.0});
    }
  }
  const double us = 1e6 * (ThreadCpuSeconds() - begin_s) / kTimes;
  EXPECT_TRUE(sum.allFinite());
  return us;
}

// Measured 0.9 us for one field, 1.3 for two, 1.7 for three.
TEST(BreathingSpeed, TwentyFiveDisplacementsTakeTwoMicrosecondsAtAnyResolution) {
  for (const MotionKind kind : kAllMotionKinds) {
    std::map<int, breathing::MotionModel> models;
    std::map<int, double> us;
    for (const int nodes : kResolutions) {
      models.emplace(nodes, AroundTheNeedle(kind, nodes).Model());
      us[nodes] = 1e9;
    }
    const auto measure = [&] {
      for (const auto& [nodes, model] : models) {
        const auto breath = AroundTheNeedle(kind, nodes).BreathAt(0.3);
        us[nodes] = std::min(us[nodes], NodesUs({model.field(), model.WeightsAt(breath)}));
      }
    };
    testing_support::MeasureUntil(50, 2000, measure,
                                  [&] { return us[256] < std::min(5.0, 1.2 * us[64]); });
    std::printf("  %-10s %.2f / %.2f / %.2f us\n", std::string(NameOf(kind)).c_str(), us[64],
                us[128], us[256]);
    EXPECT_LT(us[256], 5.0) << NameOf(kind);
    EXPECT_LT(us[256], 1.2 * us[64]) << NameOf(kind);
  }
}

/// CT, labels and the four levels of image, as large as those of a real patient.
class Images {
 public:
  Images() : ct_(testing_support::AbdomenCt()), labels_(ct_.geometry) {
    for (std::size_t n = 0; n < ct_.voxels.size(); ++n) {
      const char* tissue = ct_.voxels[n] > 400 ? "bone" : "liver";
      if (ct_.voxels[n] > -500) labels_.voxels[n] = volume::LabelOf(tissue);
    }
    for (const auto& label : volume::StandardLabels()) {
      labels_.names[label.label] = std::string(label.name);
    }
  }

  /// The levels of image, with the presets that are shipped for them.
  std::map<std::string, simulation::UltrasoundModel> Levels() const {
    const std::filesystem::path acoustics =
        std::filesystem::path(ACUS_SOURCE_DIR) / "configs/acoustics";
    const acoustics::Probe probe = testing_support::FullLinearProbe();
    simulation::BeamSettings beams;
    beams.acoustics = acoustics::ReadTissueAcoustics(acoustics / "tissues.json");
    simulation::BeamSettings beams_of_ct = beams;
    beams_of_ct.from_ct = true;
    beams_of_ct.from_labels = false;
    const simulation::ImagePatient patient{&ct_, &labels_};
    std::map<std::string, simulation::UltrasoundModel> levels;
    const auto add = [&](const char* name, const acoustics::Probe& by,
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

/// An image without breathing, and with it, by nodes of the field along each axis.
struct ImageTimes {
  testing_support::LeastTime still;
  std::map<int, testing_support::LeastTime> breathing;

  double ShareOf(int nodes) const { return breathing.at(nodes).cpu_ms / still.cpu_ms; }
  double FinerOverCoarser() const { return breathing.at(256).cpu_ms / breathing.at(64).cpu_ms; }
  bool KeepTheBounds() const {
    return std::max(ShareOf(64), ShareOf(256)) < 1.4 && FinerOverCoarser() < 1.2;
  }
};

ImageTimes TimeImages(simulation::UltrasoundModel& level,
                      const std::map<int, simulation::Breathing>& patients) {
  ImageTimes times;
  image::GrayImage image;
  int n = 0;
  const auto measure = [&] {
    const Eigen::Isometry3d pose = testing_support::SwayingProbe(n);
    const auto needle = testing_support::NeedleInPlane(pose);
    times.still.Add([&] { level.Render(pose, needle, image, 1, nullptr); });
    for (const auto& [nodes, patient] : patients) {
      times.breathing[nodes].Add([&] {
        const simulation::BreathingRest rest(patient, 0.8 + 0.033 * n, {}, nullptr);
        level.Render(pose, needle, image, 1, &rest);
      });
    }
    ++n;
  };
  testing_support::MeasureUntil(15, 200, measure, [&] { return times.KeepTheBounds(); });
  return times;
}

/// Of one model of motion, every level that is not among `done` yet; those that keep the bounds are
/// from then on. The patient is made anew: where his field lies in memory is a matter of luck.
std::map<std::string, ImageTimes> TimeLevels(
    const Images& images, MotionKind kind,
    std::map<std::string, simulation::UltrasoundModel>& levels, std::set<std::string>& done) {
  std::map<std::string, ImageTimes> times;
  std::map<int, simulation::Breathing> patients;
  for (auto& [name, level] : levels) {
    if (done.contains(name)) continue;
    for (const int nodes : {64, 256}) {
      if (!patients.contains(nodes)) {
        patients.emplace(nodes, images.Patient(kind, nodes).Make());
      }
    }
    const ImageTimes& now = times[name] = TimeImages(level, patients);
    std::printf("  %-10s %-15s %.2f times with 64^3, %.2f with 256^3\n",
                std::string(NameOf(kind)).c_str(), name.c_str(), now.ShareOf(64), now.ShareOf(256));
    if (now.KeepTheBounds()) done.insert(name);
  }
  return times;
}

// Issue: at most 40 %, for every model of motion, and less than a fifth more from 64^3 to 256^3
// nodes. Measured 2 to 18 %, alamilla_2021 23 to 31. Neighbours that fill the machine's cache and
// memory slow the large field for seconds: what does not hold is measured again after the others.
TEST(BreathingSpeed, AnImageTakesAtMostFortyPercentMore) {
  constexpr int kPasses = 8;
  const Images images;
  auto levels = images.Levels();
  std::map<MotionKind, std::set<std::string>> done;
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto is_done = [&](const auto& of_kind) {
      return of_kind.second.size() == levels.size();
    };
    if (pass > 0 && std::ranges::all_of(done, is_done)) break;
    if (pass > 0) std::this_thread::sleep_for(std::chrono::seconds(5));
    for (const MotionKind kind : kAllMotionKinds) {
      const auto times = TimeLevels(images, kind, levels, done[kind]);
      if (pass + 1 < kPasses) continue;
      for (const auto& [name, of_level] : times) {
        const std::string what = Message(NameOf(kind), " ", name);
        EXPECT_LT(of_level.ShareOf(64), 1.4) << what;
        EXPECT_LT(of_level.ShareOf(256), 1.4) << what;
        EXPECT_LT(of_level.FinerOverCoarser(), 1.2) << what;
      }
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
