#include "acus/rig/tracking/simulators/playback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/rig/tracking/igtl_source.h"
#include "acus/rig/tracking/simulators/scripted_hand.h"
#include "support/wait_until.h"

namespace acus::simulators {
namespace {

using testing_support::WaitUntil;

TEST(Faults, AreReadFromText) {
  const Fault fault = ParseFault("occlude@5:2.5");
  EXPECT_EQ(fault.kind, FaultKind::kOcclude);
  EXPECT_EQ(fault.begin_ns, 5'000'000'000);
  EXPECT_EQ(fault.end_ns, 7'500'000'000);
  EXPECT_EQ(ParseFault("drop@0").end_ns, 1'000'000'000) << "a second, if it is not said";
  for (const char* bad : {"", "drop", "drop@", "drop@-1", "drop@1:0", "drop@1:-1", "drop@x", "@1",
                          "explode@1", "drop@1:2:3", "drop@nan", "drop:1@2"}) {
    EXPECT_THROW(ParseFault(bad), InputError) << bad;
    EXPECT_THAT(FaultProblem(bad), testing::HasSubstr("occlude@5:2")) << bad;
  }
  EXPECT_TRUE(IsOn({fault}, FaultKind::kOcclude, fault.begin_ns));
  EXPECT_FALSE(IsOn({fault}, FaultKind::kOcclude, fault.end_ns));
  EXPECT_FALSE(IsOn({fault}, FaultKind::kDrop, fault.begin_ns));
}

/// Plays a hand at 200 Hz in a thread of its own, until it is told to stop.
class Playing {
 public:
  explicit Playing(PlaybackOptions options, ImageSource* images = nullptr) {
    options.server.host = "127.0.0.1";
    options.server.port = 0;
    options.wait_for_client = true;
    options.on_listening = [this](int port) { port_ = port; };
    thread_ = std::thread([this, options, images] {
      HandScript script;
      script.rate_hz = 200.0;
      script.tremor_mm = 0.0;
      script.insertion_mm_s = 1.0;
      RunContext context;
      context.stop = &stop_;
      report_ = Play(*ScriptedHand(script, {}, 1), images, options, context);
    });
    EXPECT_TRUE(WaitUntil([this] { return port_ != 0; }));
  }
  ~Playing() { Stop(); }
  PlaybackReport Stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return report_;
  }
  int port() const { return port_; }

 private:
  std::atomic<int> port_{0};
  std::atomic<bool> stop_{false};
  PlaybackReport report_;
  std::thread thread_;
};

std::unique_ptr<tracking::IgtlSource> Listening(int port) {
  tracking::IgtlOptions options;
  options.host = "127.0.0.1";
  options.port = port;
  options.tools = {{.tool = "needle", .device = "NeedleToReference"},
                   {.tool = "probe", .device = "ProbeToReference"}};
  options.keep_images = true;
  options.journal_capacity = 100'000;
  options.message_ms = 20'000;  // A loaded machine is no slow peer.
  auto source = std::make_unique<tracking::IgtlSource>(options);
  source->Start();
  return source;
}

TEST(Playback, SendsTheMotionUntilItIsStopped) {
  Playing playing({});
  const auto source = Listening(playing.port());
  ASSERT_TRUE(WaitUntil([&] { return source->board().Latest(0).number > 100; }));
  EXPECT_TRUE(source->board().Latest(0).valid);
  EXPECT_TRUE(source->board().Latest(1).valid);
  // The needle hovers 40 mm above the skin and moves slowly.
  EXPECT_NEAR(source->board().Latest(0).reference_from_tool.translation().z(), 40.0, 1.0);
  const PlaybackReport report = playing.Stop();
  EXPECT_GT(report.sent, 100u);
  EXPECT_NEAR(report.played_s, double(report.sent) / 200.0, 0.5);
  EXPECT_THAT(Text(report), testing::HasSubstr("instants"));
}

TEST(Playback, EndsWithTheMotionOrAfterItsSeconds) {
  session::Session session;
  for (int i = 0; i < 5; ++i) session.needle.push_back({.time_ns = i * 20'000'000});
  PlaybackOptions options;
  options.server.port = 0;
  options.server.host = "127.0.0.1";
  EXPECT_EQ(Play(*RecordedMotion(session, {}), nullptr, options, {}).sent, 5u);
  options.speed = 2.0;
  options.seconds = 0.025;  // 50 ms of the motion.
  EXPECT_EQ(Play(*RecordedMotion(session, {}), nullptr, options, {}).sent, 3u);
  options.speed = 0.0;
  EXPECT_THROW(Play(*RecordedMotion(session, {}), nullptr, options, {}), InputError);
}

// Each fault shows at the client as what it is, and is over when it is over. Judged by counts,
// which a loaded machine cannot miss.
TEST(Playback, FaultsShowAndEnd) {
  using tracking::SourceCounts;
  const struct {
    const char* fault;
    std::uint64_t SourceCounts::*shows;
    std::uint64_t more_than;
  } cases[] = {{"drop@0.3:0.5", &SourceCounts::connects, 1},
               {"freeze@0.3:0.5", &SourceCounts::fell_silent, 1},
               {"occlude@0.3:0.5", &SourceCounts::not_seen, 10},
               {"nan@0.3:0.5", &SourceCounts::bad_poses, 10}};
  for (const auto& one : cases) {
    PlaybackOptions options;
    options.faults = {ParseFault(one.fault)};
    options.server.send_validity = true;
    Playing playing(options);
    const auto source = Listening(playing.port());
    const auto counts = [&] { return source->status().counts; };
    EXPECT_TRUE(WaitUntil([&] { return counts().*one.shows > one.more_than; })) << one.fault;
    EXPECT_TRUE(WaitUntil([&] { return source->board().Latest(0).valid; })) << one.fault;
    EXPECT_EQ(counts().connects == 1, one.shows != &SourceCounts::connects) << one.fault;
    EXPECT_EQ(counts().bad_poses > 0, one.shows == &SourceCounts::bad_poses) << one.fault;
    EXPECT_EQ(counts().not_seen > 0, one.shows == &SourceCounts::not_seen) << one.fault;
    EXPECT_EQ(counts().bad_messages, 0u) << one.fault;
  }
}

TEST(Playback, AJumpIsFiftyMillimetresAndGarbageIsSkipped) {
  PlaybackOptions options;
  options.faults = {ParseFault("jump@0.3:0.5"), ParseFault("garbage@0:100")};
  Playing playing(options);
  const auto source = Listening(playing.port());
  std::vector<tracking::ToolReading> taken(1000);
  int aside = 0, back = 0;
  ASSERT_TRUE(WaitUntil([&] {
    const std::size_t count = source->board().TakeReadings(taken);
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [tool, pose] = taken[i];
      if (tool != 0 || !pose.valid) continue;
      const double x_mm = pose.reference_from_tool.translation().x();
      EXPECT_TRUE(std::abs(x_mm) < 1e-3 || std::abs(x_mm - 50.0) < 1e-3) << x_mm;
      aside += x_mm > 1.0 ? 1 : 0;
      back += aside > 0 && x_mm < 1.0 ? 1 : 0;
    }
    return back > 10;
  }));
  EXPECT_GE(aside, 10);
  EXPECT_TRUE(WaitUntil([&] { return source->status().counts.skipped_bytes > 1000; }));
  EXPECT_EQ(source->status().counts.connects, 1u);
}

class GreyImages final : public ImageSource {
 public:
  std::vector<std::string> streams() const override { return {"Video"}; }
  double rate_hz() const override { return 50.0; }
  std::vector<tracking::Image> Draw(std::span<const tracking::NamedPose> poses,
                                    std::int64_t) override {
    if (fails) throw InputError("the camera is made of wood");
    return {{.width = 2, .height = 1, .channels = 1, .pixels = {1, std::uint8_t(poses.size())}}};
  }
  std::atomic<bool> fails{false};
};

TEST(Playback, SendsImagesOfWhatTheToolsDo) {
  GreyImages images;
  Playing playing({}, &images);
  const auto source = Listening(playing.port());
  ASSERT_TRUE(WaitUntil([&] {
    const auto image = source->Image("Video");
    return image != nullptr && image->number >= 3;
  }));
  EXPECT_EQ(source->Image("Video")->image.pixels, (std::vector<std::uint8_t>{1, 2}));
  images.fails = true;  // No more images; poses go on.
  const auto number = source->board().Latest(0).number;
  EXPECT_TRUE(WaitUntil([&] { return source->board().Latest(0).number > number + 20; }));
  EXPECT_GE(playing.Stop().images, 3u);
}

}  // namespace
}  // namespace acus::simulators
