#include "acus/rig/tracking/igtl_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/random.h"
#include "acus/rig/tracking/igtl_wire.h"
#include "acus/rig/tracking/pose_server.h"
#include "acus/rig/tracking/socket.h"
#include "support/wait_until.h"

namespace acus::tracking {
namespace {

using testing_support::WaitUntil;

transforms::Pose PoseAt(double x_mm) {
  return Eigen::Isometry3d(Eigen::Translation3d(x_mm, 2.0, 3.0));
}
double XMm(IgtlSource& source) {
  return source.board().Latest(0).reference_from_tool.translation().x();
}
IgtlOptions Options(int port) {
  IgtlOptions options;
  options.host = "127.0.0.1";
  options.port = port;
  options.tools = {{.tool = "needle", .device = "NeedleToReference"}};
  // A loaded machine is no slow peer.
  options.message_ms = 20'000;
  options.lost_after_ms = 5'000;
  return options;
}
PoseServerOptions AnyPort() {
  PoseServerOptions options;
  options.host = "127.0.0.1";
  options.port = 0;
  return options;
}

/// A peer that says just what the test has it say.
struct IgtlSourcePeer {
  Descriptor listener = ListenTcp("127.0.0.1", 0);
  Descriptor socket;

  int port() const { return PortOf(listener); }
  void Accept() {
    ASSERT_TRUE(WaitUntil([&] { return (socket = AcceptTcp(listener)).valid(); }));
  }
  void Say(ByteView bytes) {
    while (!bytes.empty()) {
      const Transfer sent = Send(socket, bytes);
      if (sent.state == TransferState::kClosed) return;
      bytes = bytes.subspan(sent.bytes);
    }
  }
};

TEST(IgtlSource, ReceivesWhatTheServerSends) {
  PoseServer server(AnyPort());
  server.Start();
  IgtlSource source(Options(server.port()));
  source.Start();
  ASSERT_TRUE(WaitUntil([&] { return server.status().clients == 1; }));
  const std::int64_t measured_ns = MonotonicNs();
  const NamedPose poses[] = {{.name = "NeedleToReference", .reference_from_tool = PoseAt(7.0)}};
  server.SendPoses(poses, measured_ns);
  ASSERT_TRUE(WaitUntil([&] { return source.board().Latest(0).number == 1; }));
  const TrackedPose pose = source.board().Latest(0);
  EXPECT_TRUE(pose.valid);
  EXPECT_EQ(XMm(source), 7.0);
  EXPECT_GE(pose.time_ns, measured_ns);
  EXPECT_LE(pose.time_ns, MonotonicNs());
  EXPECT_GT(pose.source_time_ns, 1'500'000'000'000'000'000) << "UTC, after 2017";
  server.SetStatus(false, "camera is covered");
  ASSERT_TRUE(WaitUntil([&] { return !source.status().peer_status.empty(); }));
  EXPECT_EQ(source.status().peer_status, "code 13: NotReady: camera is covered");
  EXPECT_EQ(source.status().state, SourceState::kConnected);
  EXPECT_EQ(source.status().counts.messages, 2u);
  source.Stop();
  EXPECT_EQ(source.status().state, SourceState::kStopped);
  EXPECT_FALSE(source.board().Latest(0).valid) << "a link that is closed shows nothing";
}

TEST(IgtlSource, ComesBackAfterThePeerWasGone) {
  auto server = std::make_unique<PoseServer>(AnyPort());
  server->Start();
  const int port = server->port();
  IgtlSource source(Options(port));
  source.Start();
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(WaitUntil([&] { return server->status().clients == 1; })) << round;
    const NamedPose poses[] = {
        {.name = "NeedleToReference", .reference_from_tool = PoseAt(round + 1.0)}};
    server->SendPoses(poses, MonotonicNs());
    ASSERT_TRUE(
        WaitUntil([&] { return source.board().Latest(0).valid && XMm(source) == round + 1.0; }));
    server.reset();
    ASSERT_TRUE(WaitUntil([&] { return !source.board().Latest(0).valid; })) << "pose was lost";
    PoseServerOptions options = AnyPort();
    options.port = port;
    server = std::make_unique<PoseServer>(options);
    server->Start();
  }
  EXPECT_GE(source.status().counts.connects, 3u);
  EXPECT_THAT(source.status().last_error, testing::Not(testing::IsEmpty()));
}

TEST(IgtlSource, SaysWhyItIsNotConnected) {
  int free_port = 0;
  { free_port = PortOf(ListenTcp("127.0.0.1", 0)); }
  IgtlSource source(Options(free_port));
  source.Start();
  ASSERT_TRUE(WaitUntil([&] { return !source.status().last_error.empty(); }));
  EXPECT_THAT(source.status().last_error, testing::HasSubstr("Connection refused"));
  EXPECT_EQ(source.status().state, SourceState::kConnecting);
}

TEST(IgtlSource, RequestsTrackingData) {
  PoseServer server(AnyPort());
  server.Start();
  IgtlOptions options = Options(server.port());
  options.tdata_interval_ms = 0;
  IgtlSource source(options);
  source.Start();
  const NamedPose seen[] = {{.name = "NeedleToReference", .reference_from_tool = PoseAt(1.0)}};
  const NamedPose lost[] = {
      {.name = "NeedleToReference", .reference_from_tool = PoseAt(1.0), .valid = false}};
  ASSERT_TRUE(WaitUntil([&] {
    server.SendPoses(seen, MonotonicNs());
    return source.board().Latest(0).valid;
  }));
  // TDATA without the tool says that it is not seen, at once, if TDATA had it: what came before the
  // request was read is a transform.
  const auto before = source.status().counts.fell_silent;
  ASSERT_TRUE(WaitUntil([&] {
    server.SendPoses(seen, MonotonicNs());
    server.SendPoses(lost, MonotonicNs());
    return !source.board().Latest(0).valid;
  }));
  EXPECT_GE(source.status().counts.not_seen, 0u);
  EXPECT_EQ(source.status().counts.fell_silent, before);
}

TEST(IgtlSource, WaitsForTrackersThatConnectThemselves) {
  IgtlOptions options = Options(0);
  options.listen = true;
  IgtlSource source(options);
  source.Start();
  const WakeUp never;
  for (int round = 1; round <= 2; ++round) {
    Connection tracker = ConnectTcp("127.0.0.1", source.port(), 10'000, never);
    ASSERT_EQ(tracker.error, "");
    Send(tracker.socket, PackTransform("NeedleToReference", 1, PoseAt(round)));
    ASSERT_TRUE(WaitUntil([&] { return XMm(source) == round; }));
  }
}

TEST(IgtlSource, KeepsTheNewestImage) {
  PoseServer server(AnyPort());
  server.Start();
  IgtlOptions options = Options(server.port());
  options.keep_images = true;
  IgtlSource source(options);
  source.Start();
  ASSERT_TRUE(WaitUntil([&] { return server.status().clients == 1; }));
  EXPECT_EQ(source.Image(""), nullptr);
  Image image{.width = 640, .height = 480, .channels = 3};
  image.pixels.assign(640 * 480 * 3, 9);
  for (const std::uint8_t grey : {std::uint8_t{10}, std::uint8_t{20}}) {
    image.pixels.back() = grey;
    server.SendImage("Video", image, MonotonicNs());
    ASSERT_TRUE(WaitUntil([&] {
      const auto received = source.Image("Video");
      return received != nullptr && received->image.pixels.back() == grey;
    }));
  }
  EXPECT_EQ(source.Image("")->number, 2u);
  EXPECT_EQ(source.Image("Other"), nullptr);
}

TEST(IgtlSource, ContinuesAfterInvalidDataBetweenMessages) {
  IgtlSourcePeer peer;
  IgtlSource source(Options(peer.port()));
  source.Start();
  peer.Accept();
  RandomStream random(1, "rubbish");
  for (int i = 1; i <= 50; ++i) {
    Bytes rubbish(random.Next() % 2000);
    for (std::uint8_t& byte : rubbish) byte = static_cast<std::uint8_t>(random.Next());
    peer.Say(rubbish);
    peer.Say(PackTransform("NeedleToReference", i, PoseAt(i)));
    ASSERT_TRUE(WaitUntil([&] { return XMm(source) == i; })) << i;
  }
  EXPECT_EQ(source.status().counts.connects, 1u);
  EXPECT_EQ(source.status().counts.readings, 50u);
  EXPECT_GT(source.status().counts.skipped_bytes, 20'000u);
}

TEST(IgtlSource, CountsWhatWasBadOverAllConnections) {
  IgtlSourcePeer peer;
  IgtlSource source(Options(peer.port()));
  source.Start();
  for (std::uint64_t round = 1; round <= 3; ++round) {
    peer.Accept();
    Bytes broken = PackTransform("NeedleToReference", 1, PoseAt(1.0));
    broken.back() ^= 1U;  // The checksum is wrong.
    peer.Say(broken);
    peer.Say(PackTransform("NeedleToReference", 2, PoseAt(static_cast<double>(round))));
    ASSERT_TRUE(WaitUntil([&] { return XMm(source) == static_cast<double>(round); }));
    ASSERT_TRUE(WaitUntil([&] { return source.status().counts.bad_messages == round; })) << round;
    peer.socket = Descriptor();
  }
}

TEST(IgtlSource, LeavesAPeerThatSpeaksSomethingElse) {
  IgtlSourcePeer peer;
  IgtlSource source(Options(peer.port()));
  source.Start();
  peer.Accept();
  peer.Say(Bytes(200'000, 'x'));
  ASSERT_TRUE(WaitUntil([&] {
    return source.status().last_error.find("no OpenIGTLink message") != std::string::npos;
  }));
  peer.Accept();  // It tries again, and a peer that has come to its senses is heard.
  peer.Say(PackTransform("NeedleToReference", 1, PoseAt(4.0)));
  ASSERT_TRUE(WaitUntil([&] { return XMm(source) == 4.0; }));
}

TEST(IgtlSource, LeavesAPeerThatNeverFinishesAMessage) {
  IgtlSourcePeer peer;
  IgtlOptions options = Options(peer.port());
  options.message_ms = 300;
  IgtlSource source(options);
  source.Start();
  peer.Accept();
  const Bytes message = PackTransform("NeedleToReference", 1, PoseAt(4.0));
  bool left = false;
  for (std::size_t i = 0; i + 1 < message.size() && !left; ++i) {  // A byte every 20 ms.
    left = Send(peer.socket, ByteView(message).subspan(i, 1)).state == TransferState::kClosed;
    usleep(20'000);
    left = left || source.status().last_error.find("did not finish") != std::string::npos;
  }
  EXPECT_TRUE(left);
  EXPECT_EQ(source.board().Latest(0).number, 0u);
}

TEST(IgtlSource, LeavesAPeerThatIsSilent) {
  IgtlSourcePeer peer;
  IgtlOptions options = Options(peer.port());
  options.silence_ms = 200;
  IgtlSource source(options);
  source.Start();
  peer.Accept();
  ASSERT_TRUE(WaitUntil(
      [&] { return source.status().last_error.find("was silent") != std::string::npos; }));
  peer.Accept();
}

TEST(IgtlSource, StopsSoonWhateverItIsDoing) {
  IgtlSourcePeer peer;
  for (const bool is_there : {true, false}) {
    IgtlSource source(Options(is_there ? peer.port() : 1));
    source.Start();
    if (is_there) peer.Accept();
    const std::int64_t before_ns = MonotonicNs();
    source.Stop();
    EXPECT_LT(MonotonicNs() - before_ns, 3'000'000'000);
    source.Stop();
  }
}

TEST(IgtlSource, RefusesOptionsThatCannotWork) {
  EXPECT_THROW(IgtlSource(Options(0)), InputError);
  EXPECT_THROW(IgtlSource(Options(65536)), InputError);
  IgtlOptions options = Options(18944);
  options.lost_after_ms = 0;
  EXPECT_THROW(IgtlSource{options}, InputError);
  options = Options(18944);
  options.tools.push_back(options.tools[0]);
  EXPECT_THROW(IgtlSource{options}, InputError);
}

// Another process is killed in the middle of what it sends, frozen, and let go on.
TEST(IgtlSource, HearsAnotherProcessThroughItsFaults) {
  int port_pipe[2];
  ASSERT_EQ(pipe(port_pipe), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    PoseServer server(AnyPort());
    server.Start();
    const int port = server.port();
    if (write(port_pipe[1], &port, sizeof(port)) != sizeof(port)) _exit(1);
    for (int i = 0;; ++i) {
      const NamedPose poses[] = {{.name = "NeedleToReference", .reference_from_tool = PoseAt(i)}};
      server.SendPoses(poses, MonotonicNs());
      usleep(1000);
    }
  }
  int port = 0;
  ASSERT_EQ(read(port_pipe[0], &port, sizeof(port)), ssize_t{sizeof(port)});
  IgtlOptions options = Options(port);
  options.lost_after_ms = 200;
  IgtlSource source(options);
  source.Start();
  const auto hears = [&] { return source.board().Latest(0).valid; };
  const auto is_deaf = [&] { return !source.board().Latest(0).valid; };
  EXPECT_TRUE(WaitUntil(hears));
  for (int i = 0; i < 2; ++i) {
    kill(child, SIGSTOP);
    EXPECT_TRUE(WaitUntil(is_deaf)) << "a frozen peer's last pose must not pass for news";
    kill(child, SIGCONT);
    EXPECT_TRUE(WaitUntil(hears));
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(WaitUntil(is_deaf));
  EXPECT_EQ(source.status().counts.bad_messages, 0u);
  EXPECT_EQ(source.status().counts.out_of_order, 0u);
  EXPECT_GE(source.status().counts.fell_silent, 3u);
  close(port_pipe[0]);
  close(port_pipe[1]);
}

}  // namespace
}  // namespace acus::tracking
