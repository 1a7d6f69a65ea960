#include "acus/rig/tracking/pose_server.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/rig/tracking/igtl_reader.h"
#include "acus/rig/tracking/igtl_source.h"
#include "acus/rig/tracking/socket.h"
#include "support/wait_until.h"

namespace acus::tracking {
namespace {

using testing_support::WaitUntil;

PoseServerOptions PoseServerAnyPort() {
  PoseServerOptions options;
  options.host = "127.0.0.1";
  options.port = 0;
  return options;
}

std::vector<NamedPose> TwoTools(double x_mm) {
  const transforms::Pose pose(Eigen::Isometry3d(Eigen::Translation3d(x_mm, 0.0, 0.0)));
  return {{.name = "NeedleToReference", .reference_from_tool = pose},
          {.name = "ProbeToReference", .reference_from_tool = pose}};
}

/// A client that hears what the test reads, when the test reads it.
struct Client {
  WakeUp never;
  Descriptor socket;
  IgtlReader reader{{.keep_images = true, .check_crc = true}};
  std::vector<IgtlHeader> headers;
  std::vector<Bytes> contents;

  explicit Client(const PoseServer& server)
      : socket(ConnectTcp("127.0.0.1", server.port(), 10'000, never).socket) {}

  void Read() {
    Bytes chunk(1 << 20);
    for (;;) {
      const Transfer transfer = Receive(socket, chunk);
      if (transfer.state != TransferState::kOk) return;
      reader.Append(ByteView(chunk).first(transfer.bytes));
      while (const auto message = reader.Next()) {
        headers.push_back(message->header);
        contents.emplace_back(message->body.content.begin(), message->body.content.end());
      }
    }
  }
  std::size_t Count(const std::string& type) {
    Read();
    return std::size_t(std::count_if(headers.begin(), headers.end(),
                                     [&](const IgtlHeader& h) { return h.type == type; }));
  }
};

TEST(PoseServer, SendsEachClientWhatItRequested) {
  PoseServer server(PoseServerAnyPort());
  server.Start();
  Client plain(server), list(server);
  Send(list.socket, PackStartTrackingData("x", 0));
  ASSERT_TRUE(WaitUntil([&] { return list.Count("RTS_TDATA") == 1; }));
  ASSERT_TRUE(WaitUntil([&] { return server.status().clients == 2; }));
  for (int i = 0; i < 10; ++i) server.SendPoses(TwoTools(i), 1000 * i);
  ASSERT_TRUE(WaitUntil([&] { return plain.Count("TRANSFORM") == 20; }));
  ASSERT_TRUE(WaitUntil([&] { return list.Count("TDATA") == 10; }));
  EXPECT_EQ(plain.Count("TDATA"), 0u);
  EXPECT_EQ(list.Count("TRANSFORM"), 0u);
  EXPECT_EQ(plain.headers[1].device, "ProbeToReference");
  const auto tools = ReadTrackingData(list.contents.back());
  ASSERT_TRUE(tools && tools->size() == 2);
  EXPECT_EQ((*tools)[0].matrix(0, 3), 9.0);

  Send(list.socket, PackStopTrackingData("x"));
  ASSERT_TRUE(WaitUntil([&] {
    server.SendPoses(TwoTools(1.0), MonotonicNs());
    return list.Count("TRANSFORM") > 0;
  }));
}

TEST(PoseServer, TrackingDataComesAtTheIntervalThatWasRequested) {
  PoseServer server(PoseServerAnyPort());
  server.Start();
  Client list(server);
  Send(list.socket, PackStartTrackingData("x", 20));
  ASSERT_TRUE(WaitUntil([&] { return list.Count("RTS_TDATA") == 1; }));
  for (int i = 0; i < 1000; ++i) server.SendPoses(TwoTools(i), 1'000'000 * i);  // A second.
  server.SetStatus(true, "end");
  ASSERT_TRUE(WaitUntil([&] { return list.Count("STATUS") == 1; }));
  EXPECT_NEAR(double(list.Count("TDATA")), 50.0, 3.0);
}

TEST(PoseServer, SaysWhatIsNotSeenInTheFormThatWasChosen) {
  for (const bool send_validity : {false, true}) {
    PoseServerOptions options = PoseServerAnyPort();
    options.send_validity = send_validity;
    PoseServer server(options);
    server.Start();
    Client client(server);
    ASSERT_TRUE(WaitUntil([&] { return server.status().clients == 1; }));
    std::vector<NamedPose> poses = TwoTools(1.0);
    poses[0].valid = false;
    server.SendPoses(poses, 1);
    server.SetStatus(true, "end");
    ASSERT_TRUE(WaitUntil([&] { return client.Count("STATUS") == 1; }));
    EXPECT_EQ(client.Count("TRANSFORM"), send_validity ? 2u : 1u);
    EXPECT_EQ(client.headers[0].version, send_validity ? 2 : 1);
  }
}

TEST(PoseServer, AnswersQuestions) {
  PoseServer server(PoseServerAnyPort());
  server.Start();
  server.SetStatus(false, "warming up");
  Client client(server);
  Send(client.socket, PackQuery("GET_STATUS", ""));
  // Twice, if it came just before the status was sent to all.
  ASSERT_TRUE(WaitUntil([&] { return client.Count("STATUS") >= 1; }));
  EXPECT_EQ(ReadStatus(client.contents[0]), "code 13: NotReady: warming up");
  Send(client.socket, PackQuery("GET_CAPABIL", ""));
  ASSERT_TRUE(WaitUntil([&] {
    client.Read();
    return client.reader.counts().other_messages == 1;  // CAPABILITY.
  }));
}

TEST(PoseServer, WhatIsKeptGoesOnceToEveryClientAndIsNoBacklog) {
  PoseServerOptions options = PoseServerAnyPort();
  options.max_backlog_bytes = 100'000;
  PoseServer server(options);
  const std::vector<std::uint8_t> labels(200 * 200 * 200, 7);
  const VolumeView volume{.size = {200, 200, 200}, .voxels = labels};
  server.KeepVolume("Labels", volume);
  server.KeepPose({.name = "TargetToRas"});
  server.Start();
  Client first(server);
  const auto has_all = [](Client& client) {
    return client.Count("IMAGE") == 1 && client.Count("TRANSFORM") == 1;
  };
  ASSERT_TRUE(WaitUntil([&] { return has_all(first); }));
  EXPECT_EQ(first.headers[0].type, "TRANSFORM") << "small things come first";
  Client second(server);
  ASSERT_TRUE(WaitUntil([&] { return has_all(second); }));
  const NamedPoint target[] = {{.name = "target", .ras_mm = {1, 2, 3}}};
  server.KeepPoints("Targets", target);
  server.KeepPose({.name = "TargetToRas"});
  Client third(server);
  for (Client* client : {&first, &second, &third}) {
    ASSERT_TRUE(WaitUntil([&] {
      client->Read();
      return client->reader.counts().other_messages >= 1;  // POINT.
    }));
  }
  ASSERT_TRUE(WaitUntil([&] { return first.Count("TRANSFORM") == 2; }));
  EXPECT_EQ(first.Count("IMAGE"), 1u);
  EXPECT_EQ(server.status().too_slow, 0u);
}

TEST(PoseServer, ASlowClientLosesOldImagesAndDelaysNoOther) {
  PoseServer server(PoseServerAnyPort());
  server.Start();
  Client slow(server), quick(server);
  ASSERT_TRUE(WaitUntil([&] { return server.status().clients == 2; }));
  Image image{.width = 1000, .height = 1000, .channels = 1};
  image.pixels.assign(1'000'000, 0);
  constexpr int kImages = 40;
  for (int i = 1; i <= kImages; ++i) {
    image.pixels[0] = std::uint8_t(i);
    server.SendPoses(TwoTools(i), MonotonicNs());
    server.SendImage("Ultrasound", image, MonotonicNs());
    ASSERT_TRUE(WaitUntil([&] { return quick.Count("IMAGE") == std::size_t(i); })) << i;
  }
  EXPECT_EQ(quick.Count("TRANSFORM"), 2u * kImages);
  EXPECT_GT(server.status().images_replaced, 20u);
  // The slow one wakes up: every pose is there, and the last image is the newest.
  ASSERT_TRUE(WaitUntil([&] { return slow.Count("TRANSFORM") == 2u * kImages; }));
  ASSERT_TRUE(WaitUntil([&] {
    slow.Read();
    const auto last =
        slow.headers.back().type == "IMAGE" ? ReadImage(slow.contents.back()) : std::nullopt;
    return last && last->pixels[0] == kImages;
  }));
  EXPECT_EQ(slow.Count("IMAGE") + server.status().images_replaced, kImages);
  EXPECT_EQ(server.status().too_slow, 0u);
}

TEST(PoseServer, AClientThatTakesNoPosesIsDisconnected) {
  PoseServerOptions options = PoseServerAnyPort();
  options.max_backlog_bytes = 100'000;
  PoseServer server(options);
  server.Start();
  Client slow(server);
  ASSERT_TRUE(WaitUntil([&] { return server.status().clients == 1; }));
  const std::vector<NamedPose> many(1000, TwoTools(1.0)[0]);
  ASSERT_TRUE(WaitUntil([&] {
    server.SendPoses(many, MonotonicNs());
    return server.status().too_slow == 1;
  }));
  EXPECT_TRUE(WaitUntil([&] { return server.status().clients == 0; }));
}

TEST(PoseServer, InvalidDataFromAClientIsSurvivedAndLongInvalidDataEndsTheLink) {
  PoseServer server(PoseServerAnyPort());
  server.Start();
  Client noisy(server), other(server);
  Send(noisy.socket, Bytes(1000, 'x'));
  Send(noisy.socket, PackQuery("GET_STATUS", ""));
  ASSERT_TRUE(WaitUntil([&] { return noisy.Count("STATUS") == 1; }));
  ASSERT_TRUE(WaitUntil([&] {
    Send(noisy.socket, Bytes(50'000, 'x'));
    return server.status().rubbish == 1;
  }));
  EXPECT_TRUE(WaitUntil([&] { return server.status().clients == 1; }));
  server.SendPoses(TwoTools(1.0), 1);
  ASSERT_TRUE(WaitUntil([&] { return other.Count("TRANSFORM") == 2; }));
}

TEST(PoseServer, TakesNoMoreClientsThanItHasPlaces) {
  PoseServerOptions options = PoseServerAnyPort();
  options.max_clients = 2;
  PoseServer server(options);
  server.Start();
  Client a(server), b(server), c(server);
  ASSERT_TRUE(WaitUntil([&] { return server.status().refused == 1; }));
  EXPECT_TRUE(WaitUntil([&] { return server.status().clients == 2; }));
}

TEST(PoseServer, APortThatIsTakenIsAnErrorThatSaysSo) {
  PoseServer first(PoseServerAnyPort());
  first.Start();
  PoseServerOptions options = PoseServerAnyPort();
  options.port = first.port();
  PoseServer second(options);
  EXPECT_THROW(second.Start(), InputError);
  options.port = 70'000;
  EXPECT_THROW(PoseServer{options}, InputError);
}

TEST(PoseServer, CanBeUsedBeforeItStartsAndAfterItStops) {
  PoseServer server(PoseServerAnyPort());
  server.SendPoses(TwoTools(1.0), 1);
  server.SetStatus(true, "");
  server.Start();
  server.Stop();
  server.Stop();
  server.SendPoses(TwoTools(1.0), 1);
  server.Disconnect();
  server.Start();
  Client client(server);
  ASSERT_TRUE(WaitUntil([&] { return server.status().clients == 1; }));
}

}  // namespace
}  // namespace acus::tracking
