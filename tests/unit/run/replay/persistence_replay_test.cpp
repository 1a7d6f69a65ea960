// Persistence in a replay: frames are rendered out of order, and averaged in order.
#include <gtest/gtest.h>

#include "acus/data/session/sequence_file.h"
#include "acus/run/replay/image_log.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"

namespace acus::replay {
namespace {

class PersistenceReplay : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(
        folder_,
        R"({"ultrasound": {"model": "beams", "display": "displays/smooth.json", "needle": false}})",
        10);
  }

  /// Three seconds: the probe moves, halts, and is lost for a while.
  static session::Session MoveAndHalt() {
    session::Session session;
    session.name = "halt";
    for (int ms = 0; ms < 3000; ms += 20) {
      Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
      probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      probe.translation() << 0.004 * std::min(ms, 1500), 0.0, -0.5;
      session.probe.push_back({ms * std::int64_t{1'000'000}, probe, ms < 2200 || ms > 2400});
    }
    return session;
  }
};

TEST_F(PersistenceReplay, IsThatOfFramesInOrderWithAnyNumberOfThreads) {
  const session::Session session = MoveAndHalt();
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  const simulation::Scene scene = simulation::LoadScene(
      scenario, simulation::PlanEffects(scenario, {.probe_poses = true}), context_);
  const auto snapshots = Snapshots(scene, session, nullptr);
  ASSERT_EQ(snapshots.size(), 30U);
  // As a live session renders: one frame after the other, those that do not change asleep.
  std::vector<std::vector<std::uint8_t>> in_order;
  std::vector<std::vector<std::uint8_t>> single;
  simulation::ProbeImageRenderer renderer(scene);
  simulation::ProbeImageRenderer of_single(scene, nullptr, simulation::ImageChoice::kAll,
                                           simulation::Frames::kSingle);
  simulation::ProbeImages images;
  simulation::ProbeImages alone;
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    renderer.Render(snapshots[i], images, nullptr, i > 0 ? &snapshots[i - 1] : nullptr);
    in_order.push_back(images.b_mode.pixels);
    of_single.Render(snapshots[i], alone);
    single.push_back(alone.b_mode.pixels);
  }
  EXPECT_EQ(in_order.front(), single.front());
  EXPECT_NE(in_order[10], single[10]);    // Moves.
  EXPECT_NE(in_order[16], in_order[18]);  // Stands still, and settles.
  EXPECT_EQ(in_order[23], std::vector<std::uint8_t>(single[23].size(), 0));  // Lost: black at once.
  EXPECT_EQ(in_order[25], single[25]);                                       // Begins again.
  for (const int num_threads : {1, 3}) {
    const auto to = folder_ / std::to_string(num_threads);
    std::filesystem::create_directories(to);
    context_.num_threads = num_threads;
    ReplayOptions options;
    options.film = false;
    options.png = PngChoice::kNone;
    RenderImages(scene, snapshots, StepLog(), to, options, nullptr, context_);
    session::SequenceFile sequence(to / "images.igs.mha");
    for (std::size_t i = 0; i < snapshots.size(); ++i) {
      ASSERT_EQ(sequence.ReadImage(i), in_order[i]) << i << ", " << num_threads << " threads";
    }
  }
}

}  // namespace
}  // namespace acus::replay
