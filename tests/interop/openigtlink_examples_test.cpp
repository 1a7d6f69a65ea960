// Programs that others wrote: OpenIGTLink's own examples against our source and our server.
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include "acus/base/core/monotonic_time.h"
#include "acus/rig/tracking/igtl_source.h"
#include "acus/rig/tracking/pose_server.h"
#include "acus/rig/tracking/socket.h"
#include "support/temporary_folder.h"
#include "support/wait_until.h"

#ifndef ACUS_IGTL_PROGRAMS
#define ACUS_IGTL_PROGRAMS ""
#define ACUS_IGTL_IMAGES ""
#endif

extern char** environ;

namespace acus::tracking {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing_support::WaitUntil;

int FreePort() {
  return PortOf(ListenTcp("127.0.0.1", 0));
}

/// One of the examples, running; ended with the test. What it says goes to a file.
class Example {
 public:
  Example(const fs::path& folder, const std::string& name, std::vector<std::string> arguments)
      : log_(folder / (name + ".txt")) {
    const std::string program = std::string(ACUS_IGTL_PROGRAMS) + "/" + name;
    arguments.insert(arguments.begin(), program);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 1, log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&files, 1, 2);
    EXPECT_EQ(posix_spawn(&pid_, program.c_str(), &files, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&files);
  }
  ~Example() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  std::string Says() const {
    std::ifstream in(log_);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  bool HasSaid(const std::string& text) const {
    return WaitUntil([&] { return Says().find(text) != std::string::npos; });
  }

 private:
  fs::path log_;
  pid_t pid_ = -1;
};

class OpenIgtLinkExamples : public testing::Test {
 protected:
  void SetUp() override {
    if (std::string(ACUS_IGTL_PROGRAMS).empty()) {
      GTEST_SKIP() << "the Debian package openigtlink-examples was not there at the build";
    }
    server_.Start();
  }

  static IgtlOptions Options(int port, const std::string& device) {
    IgtlOptions options;
    options.host = "127.0.0.1";
    options.port = port;
    options.tools = {{.tool = "tool", .device = device}};
    return options;
  }

  /// Poses 20 times a second, until `done`.
  bool Serve(const std::function<bool()>& done) {
    return WaitUntil([&] {
      const transforms::Pose pose(Eigen::Isometry3d(Eigen::Translation3d(11.5, -22.25, 33.125)));
      const NamedPose poses[] = {{.name = "NeedleToReference", .reference_from_tool = pose}};
      server_.SendPoses(poses, MonotonicNs());
      usleep(50'000);
      return done();
    });
  }

  testing_support::TemporaryFolder folder_;
  PoseServer server_{{.name = "Acus", .host = "127.0.0.1", .port = 0}};
};

TEST_F(OpenIgtLinkExamples, TheirTrackerServerIsHeard) {
  const int port = FreePort();
  const Example server(folder_.path(), "TrackerServer", {std::to_string(port), "100"});
  IgtlSource source(Options(port, "Tracker"));
  source.Start();
  ASSERT_TRUE(WaitUntil([&] { return source.status().counts.readings >= 30; }));
  const SourceStatus status = source.status();
  EXPECT_EQ(status.counts.bad_messages + status.counts.skipped_bytes, 0u);
  EXPECT_EQ(status.counts.other_tools, 0u);
  // Its needle goes round on a circle of 50 mm; x equals z.
  const auto pose = source.board().Latest(0).reference_from_tool;
  EXPECT_EQ(status.counts.bad_poses, 0u);
  EXPECT_NEAR(std::hypot(pose.translation().x(), pose.translation().y()), 50.0, 1e-3);
  EXPECT_NEAR(pose.translation().x(), pose.translation().z(), 1e-4);
}

TEST_F(OpenIgtLinkExamples, TheirTrackerMayConnectToUs) {
  IgtlOptions options = Options(0, "Tracker");
  options.listen = true;
  IgtlSource source(options);
  source.Start();
  const Example tracker(folder_.path(), "TrackerClient",
                        {"127.0.0.1", std::to_string(source.port()), "100"});
  ASSERT_TRUE(WaitUntil([&] { return source.status().counts.readings >= 30; }));
  EXPECT_EQ(source.status().counts.bad_messages, 0u);
  EXPECT_TRUE(source.status().clock.known) << "it sends stamps";
}

TEST_F(OpenIgtLinkExamples, TheirTrackingDataComesWhenWeAskForIt) {
  const int port = FreePort();
  const Example server(folder_.path(), "TrackingDataServer", {std::to_string(port)});
  IgtlOptions options = Options(port, "Channel 1");
  options.tdata_interval_ms = 20;
  IgtlSource source(options);
  source.Start();
  ASSERT_TRUE(WaitUntil([&] { return source.status().counts.readings >= 20; }));
  EXPECT_EQ(source.status().counts.bad_messages, 0u);
  EXPECT_THAT(source.status().other_names, testing::UnorderedElementsAre("Channel 0", "Channel 2"));
}

TEST_F(OpenIgtLinkExamples, TheirImagesArrivePixelByPixel) {
  const int port = FreePort();
  const Example imager(folder_.path(), "ImagerServer",
                       {std::to_string(port), "20", ACUS_IGTL_IMAGES});
  IgtlOptions options = Options(port, "x");
  options.keep_images = true;
  IgtlSource source(options);
  source.Start();
  ASSERT_TRUE(WaitUntil([&] { return source.Image("ImagerClient") != nullptr; }));
  const auto image = source.Image("ImagerClient");
  ASSERT_EQ(image->image.width, 256);
  ASSERT_EQ(image->image.height, 256);
  std::set<std::vector<std::uint8_t>> theirs;
  for (int i = 1; i <= 5; ++i) {
    std::ifstream in(std::string(ACUS_IGTL_IMAGES) + "/igtlTestImage" + std::to_string(i) + ".raw",
                     std::ios::binary);
    theirs.insert({std::istreambuf_iterator<char>(in), {}});
  }
  EXPECT_TRUE(theirs.contains(image->image.pixels));
}

TEST_F(OpenIgtLinkExamples, TheirStatusIsShown) {
  const int port = FreePort();
  const Example server(folder_.path(), "StatusServer", {std::to_string(port)});
  IgtlSource source(Options(port, "x"));
  source.Start();
  ASSERT_TRUE(WaitUntil([&] { return !source.status().peer_status.empty(); }));
  EXPECT_THAT(source.status().peer_status, HasSubstr("This is a test to send status message"));
}

TEST_F(OpenIgtLinkExamples, TheirReceiverUnderstandsAllThatWeSend) {
  const Example receiver(folder_.path(), "ReceiveClient",
                         {"127.0.0.1", std::to_string(server_.port())});
  ASSERT_TRUE(WaitUntil([&] { return server_.status().clients == 1; }));
  Image image{.width = 320, .height = 240, .channels = 1};
  image.pixels.assign(320 * 240, 1);
  server_.SendImage("Ultrasound", image, MonotonicNs());
  server_.SetStatus(true, "all is well");
  EXPECT_TRUE(Serve([&] { return receiver.Says().find("33.125") != std::string::npos; }));
  const std::string said = receiver.Says();
  EXPECT_THAT(said, HasSubstr("Receiving TRANSFORM data type"));
  EXPECT_THAT(said, HasSubstr("11.5"));
  EXPECT_THAT(said, HasSubstr("-22.25"));
  EXPECT_TRUE(receiver.HasSaid("Receiving IMAGE data type"));
  EXPECT_TRUE(receiver.HasSaid("Dimension"));
  EXPECT_TRUE(receiver.HasSaid("(320, 240, 1)")) << said;
  EXPECT_TRUE(receiver.HasSaid("all is well"));
}

TEST_F(OpenIgtLinkExamples, TheirClientGetsTheTrackingDataItRequests) {
  const Example client(folder_.path(), "TrackingDataClient",
                       {"127.0.0.1", std::to_string(server_.port()), "50"});
  EXPECT_TRUE(Serve([&] { return client.Says().find("Element #0") != std::string::npos; }));
  EXPECT_TRUE(client.HasSaid("Name       : NeedleToReference"));
  EXPECT_TRUE(client.HasSaid("-22.25"));
  // After ten messages it wants no more, and gets none: TRANSFORM again.
  EXPECT_TRUE(Serve([&] { return client.Says().find("STP_TDATA") != std::string::npos; }));
  EXPECT_TRUE(
      Serve([&] { return client.Says().find("Receiving : TRANSFORM") != std::string::npos; }));
}

TEST_F(OpenIgtLinkExamples, TheirPushersDoNotDisturbOurServer) {
  const std::string port = std::to_string(server_.port());
  const Example tracker(folder_.path(), "TrackerClient", {"127.0.0.1", port, "500"});
  const Example imager(folder_.path(), "ImagerClient", {"127.0.0.1", port, "50", ACUS_IGTL_IMAGES});
  const Example status(folder_.path(), "StatusClient", {"127.0.0.1", port});
  const Example capability(folder_.path(), "CapabilityClient", {"127.0.0.1", port});
  ASSERT_TRUE(WaitUntil([&] { return server_.status().connects == 4; }));
  const Example receiver(folder_.path(), "ReceiveClient", {"127.0.0.1", port});
  EXPECT_TRUE(Serve([&] { return receiver.Says().find("33.125") != std::string::npos; }));
  EXPECT_EQ(server_.status().rubbish, 0u);
}

}  // namespace
}  // namespace acus::tracking
