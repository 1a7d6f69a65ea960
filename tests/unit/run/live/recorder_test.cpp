// A recording outlives its process, and a disk that is full or slow never reaches the producer.
#include "acus/run/live/recorder.h"

#include <csignal>
#include <fstream>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/random.h"
#include "acus/data/session/session_io.h"
#include "support/layered_scene.h"
#include "support/temporary_folder.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

constexpr std::int64_t kRecorderMs = 1'000'000;
constexpr session::StreamNames kRecorderAll{
    .needle = true, .probe = true, .breathing = true, .commands = true, .tracker = true};

const simulation::Scene& ForceScene() {
  static const simulation::Scene scene =
      testing_support::LayeredScene(testing_support::PlanOf(true, false, false, false), false);
  return scene;
}

StepRecord RecordAt(std::int64_t time_ns) {
  RandomStream random(1, "record", static_cast<std::uint64_t>(time_ns));
  StepRecord record;
  record.time_ns = time_ns;
  for (session::PoseSample* sample : {&record.needle, &record.probe}) {
    *sample = {time_ns,
               transforms::Pose(Eigen::Quaterniond(random.Normal(), random.Normal(),
                                                   random.Normal(), random.Normal()),
                                Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal())),
               true};
  }
  record.breath.time_ns = time_ns;
  record.breath.level = random.Normal();
  record.output.time_ns = time_ns;
  record.output.force.force_in_ct_n = {0.0, random.Normal(), 0.0};
  if (time_ns % (100 * kRecorderMs) == 0) {
    record.command[0] = {time_ns, session::CommandKind::kMarkTarget, 0.0};
    record.num_commands = 1;
  }
  return record;
}

std::unique_ptr<Recorder> Record(const fs::path& folder, const RecorderSettings& settings = {},
                                 const RunContext& context = {}) {
  return std::make_unique<Recorder>(folder, "test", kRecorderAll, ForceScene(), 0, settings,
                                    context);
}

void WaitFor(const std::function<bool()>& done) {
  const std::int64_t give_up_ns = MonotonicNs() + 30'000 * kRecorderMs;
  while (!done() && MonotonicNs() < give_up_ns) std::this_thread::sleep_for(milliseconds(5));
  EXPECT_TRUE(done());
}

void ExpectWhole(const fs::path& folder, std::size_t count) {
  const session::Session session = session::ReadSession(folder, RunContext());
  ASSERT_EQ(session.needle.size(), count);
  ASSERT_EQ(session.probe.size(), count);
  ASSERT_EQ(session.breath.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    const StepRecord expected = RecordAt(static_cast<std::int64_t>(i) * kRecorderMs);
    ASSERT_EQ(session.needle[i].time_ns, expected.time_ns);
    ASSERT_EQ(session.needle[i].reference_from_tool, expected.needle.reference_from_tool);
    ASSERT_EQ(session.probe[i].reference_from_tool, expected.probe.reference_from_tool);
    ASSERT_EQ(session.breath[i].level, expected.breath.level);
  }
  EXPECT_EQ(session.commands.size(), (count + 99) / 100);
}

TEST(Recorder, WritesWhatItWasGivenToTheLastBit) {
  const TemporaryFolder folder;
  const auto recorder = Record(folder / "s");
  EXPECT_TRUE(fs::exists(folder / "s/session.json"));
  recorder->Start();
  for (int i = 0; i < 3000; ++i) recorder->Push(RecordAt(i * kRecorderMs));
  recorder->Close();
  ExpectWhole(folder / "s", 3000);
  const RecordingStatus status = recorder->status();
  EXPECT_EQ(status.steps_on_disk, 3000);
  EXPECT_EQ(status.steps_lost, 0);
  EXPECT_EQ(status.steps_waiting, 0);
  EXPECT_EQ(status.trouble, "");
}

TEST(Recorder, DoesNotReplaceWhatIsNotItsOwn) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "s");
  WriteTextFile(folder / "s/notes.txt", "mine");
  RunContext context;
  EXPECT_THAT([&] { Record(folder / "s", {}, context); },
              ThrowsMessage<InputError>(HasSubstr("is there already")));
  context.overwrite = true;
  EXPECT_THAT([&] { Record(folder / "s", {}, context); },
              ThrowsMessage<InputError>(HasSubstr("not the output of an earlier run")));
  EXPECT_TRUE(fs::exists(folder / "s/notes.txt"));
  Record(folder / "t");
  EXPECT_NO_THROW(Record(folder / "t", {}, context));
}

/// Raw readings, in the time of the session.
TEST(Recorder, KeepsRawReadingsOfTrackers) {
  const TemporaryFolder folder;
  tracking::PoseBoard board({"needle", "probe"}, 1000);
  auto recorder = std::make_unique<Recorder>(folder / "s", "test", kRecorderAll, ForceScene(),
                                             5'000 * kRecorderMs, RecorderSettings{}, RunContext());
  recorder->AddBoards({{"polaris/", &board}});
  recorder->Start();
  tracking::TrackedPose pose;
  pose.time_ns = 5'250 * kRecorderMs;
  pose.source_time_ns = 77;
  pose.valid = true;
  pose.reference_from_tool = Eigen::Isometry3d(Eigen::Translation3d(1.0, 2.0, 3.0));
  board.Publish(1, pose);
  recorder->Close();
  EXPECT_THAT(ReadTextFile(folder / "s/tracker.csv"),
              HasSubstr("\n0.25,0.000000077,polaris/probe,1,2,3,1,0,0,0,OK\n"));
  EXPECT_EQ(recorder->status().readings_recorded, 1);
}

TEST(Recorder, WhatCannotBePutOnTheMediumIsReportedAtTheEnd) {
  const TemporaryFolder folder;
  const auto recorder = Record(folder / "s", RecorderSettings());
  recorder->Start();
  recorder->Push(RecordAt(0));
  fs::rename(folder / "s", folder / "moved");
  recorder->Close();
  EXPECT_THAT(recorder->status().trouble,
              HasSubstr("may not survive a power failure (No such file or directory)"));
  ExpectWhole(folder / "moved", 1);
}

/// Takes bytes as long as there is room, and as slowly as told.
struct Disk {
  std::atomic<std::int64_t> room{0};
  std::atomic<int> delay_ms{0};
  SinkFactory Factory() {
    return [this](const fs::path& file) -> std::unique_ptr<ByteSink> {
      struct Sink : ByteSink {
        Disk& disk;
        std::unique_ptr<ByteSink> file;
        Sink(Disk& d, const fs::path& path) : disk(d), file(OpenOnDisk(path)) {}
        std::ptrdiff_t Write(std::string_view bytes) noexcept override {
          std::this_thread::sleep_for(milliseconds(disk.delay_ms));
          const auto room = static_cast<std::size_t>(std::max<std::int64_t>(0, disk.room));
          if (room == 0) return -ENOSPC;
          const std::ptrdiff_t taken = file->Write(bytes.substr(0, room));
          disk.room -= taken;
          return taken;
        }
      };
      return std::make_unique<Sink>(*this, file);
    };
  }
};

RecorderSettings Quick(Disk& disk) {
  RecorderSettings settings;
  settings.write_s = 0.01;
  settings.retry_s = 0.02;
  settings.open = disk.Factory();
  return settings;
}

TEST(Recorder, AFullDiskCostsMemorySaysSoAndLosesNothingWhenThereIsRoomAgain) {
  const TemporaryFolder folder;
  Disk disk;
  disk.room = 100'000;
  const auto recorder = Record(folder / "s", Quick(disk));
  recorder->Start();
  for (int i = 0; i < 2000; ++i) recorder->Push(RecordAt(i * kRecorderMs));
  WaitFor([&] { return !recorder->status().trouble.empty(); });
  const RecordingStatus full = recorder->status();
  EXPECT_THAT(full.trouble, HasSubstr("the disk is full"));
  EXPECT_THAT(full.trouble, HasSubstr("s are kept in memory. Make room for"));
  EXPECT_GT(full.refusals, 0);
  EXPECT_EQ(full.steps_lost, 0);
  EXPECT_EQ(full.steps_on_disk + full.steps_waiting, 2000);
  // What is on the full disk can be read, and every needle row has its others.
  const session::Session cut = session::ReadSession(folder / "s", RunContext());
  EXPECT_GE(cut.breath.size(), cut.probe.size());
  EXPECT_GE(cut.probe.size(), cut.needle.size());
  disk.room = 1'000'000'000;
  WaitFor([&] { return recorder->status().steps_on_disk == 2000; });
  EXPECT_EQ(recorder->status().trouble, "");
  recorder->Close();
  ExpectWhole(folder / "s", 2000);
}

TEST(Recorder, WhenMemoryIsFullAsWellItCountsWhatItLoses) {
  const TemporaryFolder folder;
  Disk disk;
  disk.room = 3'000;
  RecorderSettings settings = Quick(disk);
  settings.memory_bytes = 200'000;
  settings.patience_s = 0.05;
  const auto recorder = Record(folder / "s", settings);
  recorder->Start();
  for (int i = 0; i < 4000; ++i) recorder->Push(RecordAt(i * kRecorderMs));
  WaitFor([&] { return recorder->status().steps_lost > 0; });
  EXPECT_THAT(recorder->status().trouble, HasSubstr("is no longer recorded"));
  recorder->Close();
  const RecordingStatus status = recorder->status();
  EXPECT_EQ(status.steps_on_disk + status.steps_lost, 4000);
  EXPECT_EQ(status.steps_waiting, 0);
}

TEST(Recorder, ASlowDiskNeverDelaysTheProducer) {
  const TemporaryFolder folder;
  Disk disk;
  disk.room = 1'000'000'000;
  const auto recorder = Record(folder / "s", Quick(disk));
  recorder->Start();
  disk.delay_ms = 200;  // For each write.
  const double begin_s = 1e-9 * static_cast<double>(MonotonicNs());
  for (int i = 0; i < 3000; ++i) recorder->Push(RecordAt(i * kRecorderMs));
  const double pushed_s = 1e-9 * static_cast<double>(MonotonicNs()) - begin_s;
  EXPECT_LT(pushed_s, 1.0);  // Some 20 ms; one block takes 1.2 s.
  WaitFor([&] { return recorder->status().longest_write_s > 0.5; });
  disk.delay_ms = 0;
  recorder->Close();
  EXPECT_EQ(recorder->status().steps_lost, 0);
  ExpectWhole(folder / "s", 3000);
}

TEST(Recorder, ARingThatIsFullLosesRecordsAndCountsThem) {
  const TemporaryFolder folder;
  RecorderSettings settings;
  settings.ring_steps = 100;
  const auto recorder = Record(folder / "s", settings);  // Not started: nobody takes.
  for (int i = 0; i < 150; ++i) recorder->Push(RecordAt(i * kRecorderMs));
  EXPECT_EQ(recorder->status().steps_lost, 50);
  recorder->Start();
  recorder->Close();
  ExpectWhole(folder / "s", 100);
  EXPECT_THAT(recorder->status().trouble, HasSubstr("50 steps are missing"));
}

/// Runs `body` in a process of its own. @returns its id.
pid_t Fork(const std::function<void()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    body();
    _exit(0);
  }
  return child;
}

TEST(Recorder, ALimitOfTheOperatingSystemIsTroubleThatPasses) {
  const TemporaryFolder folder;
  const pid_t child = Fork([&] {
    signal(SIGXFSZ, SIG_IGN);
    RecorderSettings settings;
    settings.write_s = 0.01;
    settings.retry_s = 0.02;
    const auto recorder = Record(folder / "s", settings);
    const rlimit small{60'000, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &small);
    recorder->Start();
    for (int i = 0; i < 2000; ++i) recorder->Push(RecordAt(i * kRecorderMs));
    for (int i = 0; i < 3000 && recorder->status().refusals == 0; ++i) usleep(10'000);
    if (recorder->status().trouble.find("File too large") == std::string::npos) _exit(1);
    const rlimit all{RLIM_INFINITY, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &all);
    recorder->Close();
    _exit(recorder->status().steps_on_disk == 2000 ? 0 : 2);
  });
  int result = -1;
  waitpid(child, &result, 0);
  EXPECT_EQ(result, 0);
  ExpectWhole(folder / "s", 2000);
}

TEST(Recorder, WhatIsKilledAtAnyMomentLosesLessThanASecondAndCanBeRead) {
  auto* newest_ns = static_cast<std::atomic<std::int64_t>*>(
      mmap(nullptr, sizeof(std::atomic<std::int64_t>), PROT_READ | PROT_WRITE,
           MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(newest_ns, MAP_FAILED);
  RandomStream random(1, "kill");
  double worst_s = 0.0;
  for (int kill_number = 0; kill_number < 5; ++kill_number) {
    const TemporaryFolder folder;
    *newest_ns = 0;
    const pid_t child = Fork([&] {
      const auto recorder = Record(folder / "s");
      recorder->Start();
      const std::int64_t begin_ns = MonotonicNs();
      for (std::int64_t i = 0;; ++i) {
        while (MonotonicNs() < begin_ns + i * kRecorderMs) usleep(200);
        recorder->Push(RecordAt(i * kRecorderMs));
        *newest_ns = i * kRecorderMs;
      }
    });
    const std::int64_t until_ns = std::llround((600.0 + 900.0 * random.Uniform()) * kRecorderMs);
    WaitFor([&] { return *newest_ns >= until_ns; });
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const std::int64_t killed_ns = *newest_ns;
    const session::Session session = session::ReadSession(folder / "s", RunContext());
    const double lost_s = 1e-9 * static_cast<double>(killed_ns - session.needle.back().time_ns);
    worst_s = std::max(worst_s, lost_s);
    EXPECT_LT(lost_s, 1.0);
    ASSERT_GE(session.probe.size(), session.needle.size());
    ASSERT_GE(session.breath.size(), session.needle.size());
    for (std::size_t i = 0; i < session.needle.size(); ++i) {
      ASSERT_EQ(session.needle[i].reference_from_tool,
                RecordAt(session.needle[i].time_ns).needle.reference_from_tool);
    }
  }
  RecordProperty("longest_loss_ms", static_cast<int>(1e3 * worst_s));
  munmap(newest_ns, sizeof(std::atomic<std::int64_t>));
}

}  // namespace
}  // namespace acus::live
