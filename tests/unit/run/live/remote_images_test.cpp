// A session whose images another computer makes: those of its replay, and what happens when that
// computer is another one, is gone, or says what it should not.
#include "acus/run/live/remote_images.h"

#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/random.h"
#include "acus/run/live/image_server.h"
#include "acus/run/live/live_session.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"
#include "support/wait_until.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double kRateHz = 30.0;
// Fluoroscopy has moments of its own, 8 a second: each fourth is one of the ultrasound, too.
constexpr std::size_t kUltrasoundAtBoth = 15;
constexpr std::size_t kFluoroscopyAtBoth = 4;

/// The images of a sequence that is not compressed, one after the other.
std::string PixelsOf(const fs::path& file) {
  const std::string text = ReadTextFile(file);
  const std::string end = "ElementDataFile = LOCAL\n";
  return text.substr(text.find(end) + end.size());
}

class SecondComputer : public testing_support::ReplayFolder {
 protected:
  struct Shown {
    std::int64_t time_ns = 0;
    std::string b_mode, fluoroscopy;
  };

  void SetUp() override {
    testing_support::WriteLayeredFolder(folder_, R"({"needle_force": {}, "ultrasound": {},
        "ct_slice": {}, "fluoroscopy": {}, "tissue": {"model": "displacement_functions"}})");
  }
  ~SecondComputer() override { StopServer(); }

  LiveDevices Devices(int port) {
    WriteTextFile(folder_ / "devices.json", Message(R"({"format": "acus-devices/1", "devices": [
      {"name": "right", "driver": "virtual_hand", "virtual_hand": {"repeats": true, "path": [
        {"time_s": 0, "translation_mm": [0, 20, -5]}, {"time_s": 1, "translation_mm": [0, 20, 20]},
        {"time_s": 2, "translation_mm": [0, 20, -5]}]}},
      {"name": "left", "driver": "virtual_hand", "virtual_hand": {"repeats": true, "path": [
        {"time_s": 0, "translation_mm": [0, 20, 1], "quaternion_wxyz": [0.7071067811865476, 0.7071067811865476, 0, 0]},
        {"time_s": 1, "translation_mm": [4, 20, 0], "quaternion_wxyz": [0.7071067811865476, 0.7071067811865476, 0, 0]},
        {"time_s": 2, "translation_mm": [0, 20, 1], "quaternion_wxyz": [0.7071067811865476, 0.7071067811865476, 0, 0]}]}}],
      "needle": {"device": "right"}, "probe": {"device": "left"},
      "images_from": {"port": )",
                                                    port, "}}"));
    return ReadLiveDevices(folder_ / "devices.json");
  }

  void StartServer(const std::vector<scenario::Override>& changes = {}) {
    const auto scenario = scenario::ReadScenario(folder_ / "scene.json", changes);
    scene_ = std::make_unique<simulation::Scene>(LoadLiveScene(scenario, Devices(1), context_));
    server_ = std::make_unique<ImageServer>(*scene_, DigestOf(scenario, *scene_),
                                            ImageServerOptions{.port = 0});
    stop_ = false;
    thread_ = std::thread([this] { server_->Run(&stop_); });
  }
  void StopServer() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  std::unique_ptr<LiveSession> StartSession(int port) {
    LiveOptions options;
    options.session_folder = folder_ / "s";
    auto session = std::make_unique<LiveSession>(scenario::ReadScenario(folder_ / "scene.json", {}),
                                                 Devices(port), options, context_);
    session->Start();
    return session;
  }

  bool PollUntil(LiveSession& session, const std::function<bool()>& done) {
    return testing_support::WaitUntil([&] {
      EXPECT_TRUE(session.Poll());
      if (session.images().Refresh()) {
        const LiveImage& image = session.images().Front();
        const auto text = [](const std::vector<std::uint8_t>& pixels) {
          return std::string(pixels.begin(), pixels.end());
        };
        shown_.push_back({image.time_ns, text(image.images.b_mode.pixels),
                          text(image.effects.at(0).pixels.gray.pixels)});
        age_of_snapshot_ns_ = image.time_ns - image.snapshot.moment.time_ns;
      }
      return done();
    });
  }

  /// The recording is whole, and replays to the forces that were felt.
  void ExpectReplaySame() {
    replay::ReplayOptions options;
    options.run_folder = folder_ / "r";
    options.film = false;
    replay::ReplaySession(scenario::ReadScenario(folder_ / "scene.json", {}), folder_ / "s",
                          options, context_);
    const std::string live = ReadTextFile(folder_ / "s/forces.csv");
    EXPECT_GT(live.size(), 10'000U);
    EXPECT_TRUE(live == ReadTextFile(folder_ / "r/forces.csv"));
    const auto summary = config::ReadJson(folder_ / "s/summary.json");
    EXPECT_EQ(summary.at("recording").at("steps_lost"), 0);
  }

  std::string FirstStatus(const LiveSession& session) {
    const auto lines = session.Status();
    return lines.empty() ? "" : lines.front().text;
  }

  std::unique_ptr<simulation::Scene> scene_;
  std::unique_ptr<ImageServer> server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
  std::vector<Shown> shown_;
  std::int64_t age_of_snapshot_ns_ = 0;
};

TEST_F(SecondComputer, MakesTheImagesOfTheReplay) {
  StartServer();
  const auto session = StartSession(server_->port());
  const RemoteImages& remote = *session->remote_images();
  ASSERT_TRUE(PollUntil(*session, [&] { return remote.num_images() >= 60; }));
  EXPECT_THAT(FirstStatus(*session), HasSubstr("Images come from localhost:"));
  EXPECT_GE(age_of_snapshot_ns_, 0);
  EXPECT_LT(age_of_snapshot_ns_, 100'000'000) << "the tools of another moment";
  session->Stop();
  EXPECT_TRUE(session->complete());
  ExpectReplaySame();

  const std::string b_mode = PixelsOf(folder_ / "r/images.igs.mha");
  const std::string fluoroscopy = PixelsOf(folder_ / "r/fluoroscopy.igs.mha");
  std::ifstream needle(folder_ / "s/needle.csv");
  std::string row;
  std::getline(needle, row);
  std::getline(needle, row);
  const double first_s = std::stod(row);
  int compared = 0;
  int compared_of_effect = 0;
  int of_here = 0;
  for (const Shown& image : shown_) {
    const double number = (1e-9 * static_cast<double>(image.time_ns) - first_s) * kRateHz;
    const auto at = static_cast<std::size_t>(std::lround(number));
    if (std::abs(number - std::round(number)) > 1e-6) {
      ++of_here;  // Before the first from there: of any moment.
      continue;
    }
    ASSERT_LE((at + 1) * image.b_mode.size(), b_mode.size());
    EXPECT_TRUE(b_mode.compare(at * image.b_mode.size(), image.b_mode.size(), image.b_mode) == 0)
        << "B-mode " << at;
    ++compared;
    if (at % kUltrasoundAtBoth != 0) continue;
    const std::size_t of_effect =
        at / kUltrasoundAtBoth * kFluoroscopyAtBoth * image.fluoroscopy.size();
    ASSERT_LE(of_effect + image.fluoroscopy.size(), fluoroscopy.size());
    EXPECT_TRUE(fluoroscopy.compare(of_effect, image.fluoroscopy.size(), image.fluoroscopy) == 0)
        << "fluoroscopy " << at;
    ++compared_of_effect;
  }
  EXPECT_GE(compared, 30);
  EXPECT_GE(compared_of_effect, 2);
  EXPECT_LE(of_here, 30);
  EXPECT_NE(shown_.back().b_mode, shown_[shown_.size() - 5].b_mode) << "the probe moves";
  const auto from = config::ReadJson(folder_ / "s/summary.json").at("images_from");
  EXPECT_GE(from.at("images"), 60);
  EXPECT_GT(from.at("age").at("median_ms"), 0.0);
  EXPECT_EQ(from.at("trouble"), "");
}

TEST_F(SecondComputer, IsGoneHalfWayAndImagesAreMadeHere) {
  StartServer();
  const auto session = StartSession(server_->port());
  const RemoteImages& remote = *session->remote_images();
  ASSERT_TRUE(PollUntil(*session, [&] { return remote.num_images() >= 10; }));
  StopServer();
  ASSERT_TRUE(PollUntil(*session, [&] { return !remote.works(); }));
  const std::size_t before = shown_.size();
  const double lost_s = session->session_s();
  ASSERT_TRUE(PollUntil(*session, [&] { return shown_.size() >= before + 10; }));
  EXPECT_THAT(FirstStatus(*session), HasSubstr("Images are made on this computer: "));
  EXPECT_THAT(FirstStatus(*session), HasSubstr("closed the link"));
  EXPECT_GT(shown_.back().time_ns, std::llround(1e9 * lost_s)) << "they are of now";
  session->Stop();
  EXPECT_TRUE(session->complete());
  ExpectReplaySame();
}

TEST_F(SecondComputer, WithAnotherScenarioOrPatientIsRefused) {
  StartServer({{"/effects/ultrasound/model", "beams"}});
  {
    const auto session = StartSession(server_->port());
    EXPECT_THAT(FirstStatus(*session), HasSubstr("another patient, scenario or build"));
    EXPECT_TRUE(PollUntil(*session, [&] { return shown_.size() >= 5; }));
    EXPECT_EQ(session->remote_images()->num_images(), 0);
    session->Stop();
  }
  StopServer();
  auto ct = volume::ReadCt(folder_ / "ct.nrrd", "", context_);
  ct.voxels[1000] = static_cast<std::int16_t>(ct.voxels[1000] + 1);
  volume::WriteCt(folder_ / "other.nrrd", ct);
  StartServer({{"/patient/ct", (folder_ / "other.nrrd").string()}});
  context_.overwrite = true;
  const auto session = StartSession(server_->port());
  EXPECT_THAT(FirstStatus(*session), HasSubstr("another patient, scenario or build"));
  session->Stop();
}

TEST_F(SecondComputer, IsNotThere) {
  const int port = tracking::PortOf(tracking::ListenTcp("localhost", 0));
  const auto session = StartSession(port);
  EXPECT_THAT(FirstStatus(*session), HasSubstr("no answer from localhost:"));
  EXPECT_TRUE(PollUntil(*session, [&] { return shown_.size() >= 5; }));
  session->Stop();
  EXPECT_TRUE(session->complete());
}

/// Accepts one session as the second computer would, then sends bytes.
class Impostor {
 public:
  explicit Impostor(std::function<void(tracking::IgtlLink&)> then)
      : listener_(tracking::ListenTcp("localhost", 0)), thread_([this, then] {
          tracking::Descriptor socket;
          if (!testing_support::WaitUntil([&] {
                socket = tracking::AcceptTcp(listener_);
                return socket.valid();
              })) {
            return;
          }
          tracking::IgtlLink link(std::move(socket));
          while (link.Exchange(20, wake_) && !link.Next()) {
          }
          link.Queue(tracking::PackStatus("Images", 0, true, "images follow"));
          then(link);
          // Until the session has had enough.
          testing_support::WaitUntil([&] {
            while (link.Next()) {
            }
            return !link.Exchange(20, wake_);
          });
        }) {}
  ~Impostor() { thread_.join(); }
  int port() const { return tracking::PortOf(listener_); }

 private:
  tracking::WakeUp wake_;
  tracking::Descriptor listener_;
  std::thread thread_;
};

TEST_F(SecondComputer, ThatSendsSomethingElseIsLeft) {
  context_.overwrite = true;
  const tracking::Bytes wrong[] = {
      tracking::Bytes(1000, 0xa5),
      tracking::PackImage("Photo", 5, {.width = 1, .height = 1, .pixels = {7}}),
      tracking::PackTable("Moment", 5, {.columns = 2, .values = {std::nan(""), 1.0}}),
      tracking::PackTable("Moment", 5, {.columns = 1, .values = {1.0}}),
      tracking::PackText("Ultrasound", "no image"),
      tracking::PackStatus("Images", 0, false, "no more")};
  for (const tracking::Bytes& bytes : wrong) {
    Impostor impostor([&](tracking::IgtlLink& link) { link.Queue(bytes); });
    const auto session = StartSession(impostor.port());
    EXPECT_TRUE(PollUntil(*session, [&] { return !session->remote_images()->trouble().empty(); }));
    EXPECT_THAT(FirstStatus(*session), HasSubstr("Images are made on this computer"));
    shown_.clear();
    EXPECT_TRUE(PollUntil(*session, [&] { return shown_.size() >= 3; }));
    session->Stop();
    EXPECT_TRUE(session->complete());
  }
}

TEST_F(SecondComputer, ThatSendsNothingIsLeftAfterTwoSeconds) {
  Impostor impostor([](tracking::IgtlLink&) {});
  const auto session = StartSession(impostor.port());
  EXPECT_TRUE(PollUntil(*session, [&] { return shown_.size() >= 5; })) << "made here meanwhile";
  EXPECT_TRUE(PollUntil(*session, [&] { return !session->remote_images()->trouble().empty(); }));
  EXPECT_THAT(FirstStatus(*session), HasSubstr("no image for 2 s"));
  session->Stop();
}

/// One set of images and no more: these stay, the tools move, and the age is that of now.
TEST_F(SecondComputer, ThatStallsLeavesTheToolsMoving) {
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  const simulation::Scene scene = LoadLiveScene(scenario, Devices(1), context_);
  const image::ImageGeometry size = acoustics::ImageOf(*scene.probe);
  const auto count =
      static_cast<std::size_t>(size.width_px) * static_cast<std::size_t>(size.height_px);
  const tracking::Image white{.width = size.width_px,
                              .height = size.height_px,
                              .channels = 1,
                              .pixels = std::vector<std::uint8_t>(count, 255)};
  Impostor impostor([&](tracking::IgtlLink& link) {
    link.Queue(tracking::PackImage("Ultrasound", 5, white));
    link.Queue(tracking::PackTable("Moment", 5, {.columns = 2, .values = {1e6, 1.0}}));
  });
  const auto session = StartSession(impostor.port());
  std::set<std::int64_t> moments;
  ASSERT_TRUE(PollUntil(*session, [&] {
    const LiveImage& image = session->images().Front();
    if (image.time_ns == 1'000'000) {
      moments.insert(image.snapshot.moment.time_ns);
      EXPECT_EQ(image.images.b_mode.pixels, white.pixels);
    }
    return session->session_s() > 1.0;
  }));
  EXPECT_GT(moments.size(), 20U);
  EXPECT_GT(session->remote_images()->age_ms(), 900.0);
  EXPECT_THAT(FirstStatus(*session), testing::ContainsRegex("Images come from .*, [0-9]+ ms old"));
  session->Stop();
}

/// Images of a size that the probe does not have are not shown.
TEST_F(SecondComputer, ImagesOfAnotherSizeAreNotShown) {
  Impostor impostor([](tracking::IgtlLink& link) {
    link.Queue(tracking::PackImage("Ultrasound", 5, {.width = 1, .height = 2, .pixels = {7, 8}}));
    link.Queue(tracking::PackTable("Moment", 5, {.columns = 2, .values = {1e6, 1.0}}));
  });
  const auto session = StartSession(impostor.port());
  EXPECT_TRUE(PollUntil(*session, [&] { return session->remote_images()->num_images() == 1; }));
  EXPECT_TRUE(PollUntil(*session, [&] { return !session->remote_images()->trouble().empty(); }));
  for (const Shown& image : shown_) EXPECT_NE(image.b_mode.size(), 2U);
  session->Stop();
}

/// A client that speaks nonsense costs the second computer nothing but that link.
TEST_F(SecondComputer, OutlivesClientsThatSendAnything) {
  StartServer();
  RandomStream random(8, "clients");
  const tracking::WakeUp wake;
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  const tracking::Bytes request = PackRequest(DigestOf(scenario, *scene_));
  StepInput step;
  step.time_ns = step.needle.time_ns = step.probe.time_ns = 1'000'000;
  const tracking::Bytes steps = PackSteps({&step, 1}, 0);
  for (int client = 0; client < 40; ++client) {
    tracking::IgtlLink link(
        std::move(tracking::ConnectTcp("localhost", server_->port(), 2000, wake).socket));
    if (client % 4 == 0) continue;  // Leaves at once.
    tracking::Bytes bytes = request;
    bytes.insert(bytes.end(), steps.begin(), steps.end());
    for (int i = 0; i < 3; ++i) {
      bytes[random.Next() % bytes.size()] = static_cast<std::uint8_t>(random.Next());
    }
    if (client % 4 == 1) bytes.resize(random.Next() % bytes.size() + 1);
    link.Queue(std::move(bytes));
    for (int turn = 0; turn < 20 && link.Exchange(5, wake); ++turn) {
      while (link.Next()) {
      }
    }
  }
  const auto session = StartSession(server_->port());
  EXPECT_EQ(session->remote_images()->trouble(), "");
  EXPECT_TRUE(PollUntil(*session, [&] { return session->remote_images()->num_images() >= 5; }));
  session->Stop();
}

}  // namespace
}  // namespace acus::live
