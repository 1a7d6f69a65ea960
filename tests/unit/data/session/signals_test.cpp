#include "acus/data/session/signals.h"

#include <bit>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/session/session_io.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::session {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

constexpr std::int64_t kMs = 1'000'000;

Session LiveSession() {
  RandomStream random(1, "live session");
  Session session;
  session.name = "live";
  for (int i = 0; i < 500; ++i) {
    const std::int64_t time_ns = i * kMs + static_cast<std::int64_t>(random.Next() % 1000);
    session.needle.push_back({time_ns, transforms::Pose(), true});
    session.breath.push_back({.time_ns = time_ns,
                              .cycle = random.Uniform(),
                              .level = random.Normal(),
                              .level_per_s = random.Normal() * 1e-9,
                              .status = static_cast<BreathStatus>(i % 4)});
  }
  for (int i = 0; i < 11; ++i) {
    session.commands.push_back({i / 2 * kMs, static_cast<CommandKind>(i), random.Normal()});
  }
  return session;
}

TEST(Signals, ReadBackGiveTheSameBits) {
  const TemporaryFolder folder;
  const Session written = LiveSession();
  WriteSession(folder / "s", written, RunContext());
  const Session read = ReadSession(folder / "s", RunContext());
  ASSERT_EQ(read.breath.size(), written.breath.size());
  for (std::size_t i = 0; i < read.breath.size(); ++i) {
    const BreathSample& a = read.breath[i];
    const BreathSample& b = written.breath[i];
    ASSERT_EQ(a.time_ns, b.time_ns);
    ASSERT_EQ(a.status, b.status);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a.cycle), std::bit_cast<std::uint64_t>(b.cycle));
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a.level), std::bit_cast<std::uint64_t>(b.level));
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a.level_per_s),
              std::bit_cast<std::uint64_t>(b.level_per_s));
  }
  ASSERT_EQ(read.commands.size(), written.commands.size());
  for (std::size_t i = 0; i < read.commands.size(); ++i) {
    EXPECT_EQ(read.commands[i].time_ns, written.commands[i].time_ns);
    EXPECT_EQ(read.commands[i].kind, written.commands[i].kind);
    EXPECT_EQ(read.commands[i].value, written.commands[i].value);
  }
}

TEST(Signals, NoWordBeginsAnother) {
  // A line that a crash has cut off must not pass for another command.
  for (int i = 0; i < 11; ++i) {
    for (int j = 0; j < 11; ++j) {
      if (i == j) continue;
      EXPECT_FALSE(
          NameOf(static_cast<CommandKind>(i)).starts_with(NameOf(static_cast<CommandKind>(j))));
    }
  }
}

TEST(Signals, BreathBetweenSamplesIsLinearAndItsCycleGoesRound) {
  const BreathStream stream = {{.time_ns = 1000, .cycle = 0.9, .level = 1.0, .level_per_s = 2.0},
                               {.time_ns = 1010, .cycle = 0.1, .level = 0.0, .level_per_s = -2.0}};
  EXPECT_EQ(BreathAt(stream, 995).cycle, 0.9);
  EXPECT_EQ(BreathAt(stream, 1099).cycle, 0.1);
  EXPECT_EQ(BreathAt(stream, 1010).level, 0.0);
  EXPECT_NEAR(BreathAt(stream, 1004).level, 0.6, 1e-15);
  EXPECT_NEAR(BreathAt(stream, 1004).level_per_s, 0.4, 1e-15);
  EXPECT_NEAR(BreathAt(stream, 1008).cycle, 0.06, 1e-15);
}

TEST(Signals, ACutOffLastLineIsOmittedAndOtherFaultsAreErrors) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& rows) {
    WriteTextFile(folder / "b.csv", std::string(kBreathHeader) + "\n" + rows);
    return ReadBreathCsv(folder / "b.csv", RunContext());
  };
  EXPECT_EQ(read("0,0,1,0,HELD\n0.001,0,1,0,BREATH").size(), 1U);
  EXPECT_EQ(read("0,0,1,0,HELD\n0.001,0").size(), 1U);
  EXPECT_EQ(read("").size(), 0U);
  const auto fails = [&](const std::string& rows, const std::string& why) {
    EXPECT_THAT([&] { read(rows); }, ThrowsMessage<InputError>(HasSubstr(why))) << rows;
  };
  fails("0,0,1,0,BREATH\n", "status is 'BREATH'; allowed: BREATHING, HELD, PREDICTED, LOST");
  fails("0,1,1,0,HELD\n", "cycle is 1");
  fails("0,-0.1,1,0,HELD\n", "cycle is -0.1");
  fails("0,0,nan,0,HELD\n", "level is 'nan'");
  fails("0,0,2e6,0,HELD\n", "must lie within");
  fails("0,0,1,0,HELD\n-1,0,1,0,HELD\n", "time must increase");
  fails("0,0,1,HELD\n", "has 4 cells");
  WriteTextFile(folder / "c.csv", std::string(kCommandHeader) + "\n1,0,view\n0.5,0,view\n");
  EXPECT_THAT([&] { ReadCommandsCsv(folder / "c.csv", RunContext()); },
              ThrowsMessage<InputError>(HasSubstr("before the command above")));
}

TEST(Signals, DamagedFilesAreReadOrRefused) {
  const TemporaryFolder folder;
  std::string text = std::string(kBreathHeader) + "\n";
  for (const BreathSample& sample : LiveSession().breath) {
    if (sample.time_ns < 20 * kMs) AppendBreathRow(text, sample);
  }
  const int refused = testing_support::ReadDamagedCopies(
      text, folder / "b.csv", 300, [&] { ReadBreathCsv(folder / "b.csv", RunContext()); });
  EXPECT_GT(refused, 50);
  EXPECT_LT(refused, 300);
}

}  // namespace
}  // namespace acus::session
