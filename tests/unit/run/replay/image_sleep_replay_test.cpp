// Images that a replay does not make again are those that it would have made.
#include <gtest/gtest.h>

#include "acus/data/session/sequence_file.h"
#include "acus/run/replay/image_log.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"

namespace acus::replay {
namespace {

class ImageSleepReplay : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(folder_, R"({"ultrasound": {}, "ct_slice": {}})", 10);
  }

  /// Six seconds: a probe that is moved once and lost once; a needle that comes from far into the
  /// plane, halts there, and goes far to the other side.
  static session::Session StandStill() {
    session::Session session;
    session.name = "still";
    for (int ms = 0; ms < 6000; ms += 20) {
      const double y_mm = ms < 2500 ? -80.0 + 0.032 * ms : ms < 3500 ? 0.0 : 0.03 * (ms - 3500);
      session::PoseSample needle{.time_ns = ms * std::int64_t{1'000'000}};
      needle.reference_from_tool = Eigen::Isometry3d(Eigen::Translation3d(0.0, y_mm, 20.0));
      session.needle.push_back(needle);
      Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
      probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      probe.translation() << (ms < 1000 ? 0.0 : 4.0), 0.0, -0.5;
      session.probe.push_back({needle.time_ns, probe, ms < 4800 || ms > 5200});
    }
    return session;
  }
};

TEST_F(ImageSleepReplay, AreThoseThatWouldHaveBeenMade) {
  const session::Session session = StandStill();
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  const simulation::Scene scene = simulation::LoadScene(
      scenario, simulation::PlanEffects(scenario, {.needle_poses = true, .probe_poses = true}),
      context_);
  const auto snapshots = Snapshots(scene, session, nullptr);
  ASSERT_EQ(snapshots.size(), 60U);
  simulation::StageTimes first(scene.plan);
  for (const int num_threads : {1, 3}) {
    const auto to = folder_ / std::to_string(num_threads);
    std::filesystem::create_directories(to);
    context_.num_threads = num_threads;
    ReplayOptions options;
    options.film = false;
    options.png = PngChoice::kNone;
    simulation::StageTimes times(scene.plan);
    RenderImages(scene, snapshots, StepLog(), to, options, &times, context_);
    session::SequenceFile sequence(to / "images.igs.mha");
    simulation::ProbeImageRenderer renderer(scene);
    for (std::size_t i = 0; i < snapshots.size(); ++i) {
      simulation::ProbeImages anew;
      renderer.Render(snapshots[i], anew);
      ASSERT_EQ(sequence.ReadImage(i), anew.b_mode.pixels) << i;
    }
    const auto& cost = times.Of(scene.plan.WriterOf(effects::ports::kBMode));
    EXPECT_EQ(cost.runs, 60);
    const auto asleep = [&cost](simulation::Sleep why) {
      return cost.asleep_for[static_cast<std::size_t>(why)];
    };
    EXPECT_GT(asleep(simulation::Sleep::kNothingMoved), 5);
    EXPECT_GT(asleep(simulation::Sleep::kNeedleOffPlane), 20);
    EXPECT_GT(asleep(simulation::Sleep::kProbeUnseen), 2);
    EXPECT_LT(cost.asleep, 57);  // The probe moves, is lost and found; the needle comes and goes.
    // As often with any number of threads.
    if (num_threads == 1) first = times;
    EXPECT_EQ(cost.asleep_for, first.Of(scene.plan.WriterOf(effects::ports::kBMode)).asleep_for);
  }
}

TEST_F(ImageSleepReplay, CostsAreThoseOfImagesMadeAnewWithoutTheFirstOfEachThread) {
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  const simulation::Scene scene = simulation::LoadScene(
      scenario, simulation::PlanEffects(scenario, {.needle_poses = true, .probe_poses = true}),
      context_);
  session::Session session = StandStill();
  session.probe.resize(20);  // 0.4 s.
  session.needle.resize(20);
  for (std::size_t i = 0; i < session.probe.size(); ++i) {
    session.probe[i].reference_from_tool =
        Eigen::Translation3d(0.05 * static_cast<double>(i), 0.0, 0.0) *
        session.probe[i].reference_from_tool.isometry();
  }
  const auto snapshots = Snapshots(scene, session, nullptr);
  ASSERT_GE(snapshots.size(), 4U);
  for (const int num_threads : {1, 3}) {
    context_.num_threads = num_threads;
    const ImageLog log = RenderImages(scene, snapshots, StepLog(), "", {}, nullptr, context_);
    EXPECT_EQ(log.cpu_s.size(), snapshots.size() - static_cast<std::size_t>(num_threads));
    for (const double cpu_s : log.cpu_s) EXPECT_GT(cpu_s, 0.0);
  }
}

}  // namespace
}  // namespace acus::replay
