#include "acus/data/session/session_io.h"

#include <bit>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/random.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/pose_csv.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

constexpr std::string_view kHeader = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status\n";

PoseStream ReadRows(const std::string& rows, const RunContext& context = {}) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "needle.csv", std::string(kHeader) + rows);
  return ReadPoseCsv(folder / "needle.csv", context);
}

Eigen::Isometry3d RandomPose(RandomStream& random) {
  Eigen::Vector4d q;
  for (double& x : q) x = random.Normal();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
  pose.translation() << random.Normal() * 100, random.Normal() * 1e-7, random.Normal() * 1e4;
  return pose;
}

Session RandomSession(int num_samples) {
  RandomStream random(3, "session");
  Session session;
  session.name = "a \"quoted\" name";
  session.reference_frame = "Phantom";
  std::int64_t time_ns = -1'500'000'001;
  for (int i = 0; i < num_samples; ++i) {
    time_ns += 1 + static_cast<std::int64_t>(random.Next() % 2'000'000);
    const bool valid = i == 0 || random.Uniform() < 0.9;
    const transforms::Pose pose =
        valid ? transforms::Pose(RandomPose(random)) : session.needle.back().reference_from_tool;
    session.needle.push_back({time_ns, pose, valid});
  }
  session.probe = {{1'700'000'000'123'456'789, RandomPose(random), true}};
  return session;
}

bool SameBits(const PoseSample& a, const PoseSample& b) {
  for (int i = 0; i < 16; ++i) {
    const double x = a.reference_from_tool.matrix()(i % 4, i / 4);
    const double y = b.reference_from_tool.matrix()(i % 4, i / 4);
    if (std::bit_cast<std::uint64_t>(x) != std::bit_cast<std::uint64_t>(y)) return false;
  }
  return a.time_ns == b.time_ns && a.valid == b.valid;
}

TEST(Pose, IsTheMatrixToWithinRounding) {
  RandomStream random(1, "pose");
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Isometry3d matrix = RandomPose(random);
    const transforms::Pose pose = matrix;
    EXPECT_LT((pose.matrix() - matrix.matrix()).cwiseAbs().maxCoeff(), 3e-15);
  }
}

TEST(Pose, NormalisingTwiceChangesNothing) {
  RandomStream random(2, "pose");
  for (int i = 0; i < 20000; ++i) {
    const transforms::Pose once(
        Eigen::Quaterniond(random.Normal(), random.Normal(), random.Normal(), 0.1),
        Eigen::Vector3d::Zero());
    const transforms::Pose twice(once.quaternion(), Eigen::Vector3d::Zero());
    ASSERT_EQ(once.quaternion().coeffs(), twice.quaternion().coeffs());
    ASSERT_NEAR(once.quaternion().norm(), 1.0, 1e-15);
  }
}

TEST(Session, ReadsBackTheSameBits) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary / "session";
  const Session written = RandomSession(5000);
  WriteSession(folder, written, RunContext{});
  const Session read = ReadSession(folder, RunContext{});
  EXPECT_EQ(read.name, written.name);
  EXPECT_EQ(read.reference_frame, "Phantom");
  EXPECT_TRUE(std::ranges::equal(read.needle, written.needle, SameBits));
  EXPECT_TRUE(std::ranges::equal(read.probe, written.probe, SameBits));
  EXPECT_TRUE(fs::exists(folder / "provenance.json"));
}

TEST(Session, WrittenTwiceGivesTheSameFile) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary / "session";
  WriteSession(folder / "a", RandomSession(500), RunContext{});
  WriteSession(folder / "b", ReadSession(folder / "a", RunContext{}), RunContext{});
  EXPECT_EQ(ReadTextFile(folder / "a/needle.csv"), ReadTextFile(folder / "b/needle.csv"));
}

TEST(Session, IsNotWrittenWithoutStreamsOrWithTimeStandingStill) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary / "session";
  EXPECT_THAT([&] { WriteSession(folder, Session{}, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("neither needle nor probe")));
  Session session = RandomSession(3);
  session.needle[2].time_ns = session.needle[1].time_ns;
  EXPECT_THAT([&] { WriteSession(folder, session, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("sample 2")));
  session = RandomSession(3);
  session.needle[1].reference_from_tool =
      transforms::Pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(NAN, 0, 0));
  EXPECT_THAT([&] { WriteSession(folder, session, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("not finite")));
  EXPECT_FALSE(fs::exists(folder));
}

TEST(PoseCsv, FindsColumnsByNameAndSkipsComments) {
  const TemporaryFolder folder;
  const fs::path path = folder / "columns.csv";
  WriteTextFile(
      path,
      "# made by hand\nstatus, time_s,qw,qx,qy,qz,x_mm,y_mm,z_mm\r\n\nOK,0.5,0,1,0,0,7,8,9\r\n");
  const PoseStream stream = ReadPoseCsv(path, RunContext{});
  ASSERT_EQ(stream.size(), 1U);
  EXPECT_EQ(stream[0].time_ns, 500'000'000);
  EXPECT_EQ(Eigen::Vector3d(stream[0].reference_from_tool.translation()), Eigen::Vector3d(7, 8, 9));
  // Half a turn about x: y to -y.
  EXPECT_EQ(stream[0].reference_from_tool * Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(7, 7, 9));
}

TEST(PoseCsv, NamesRowAndValueOfWhatIsWrong) {
  const std::string good = "0,0,0,0,1,0,0,0,OK\n";
  const auto expect = [](const std::string& rows, const std::string& message) {
    EXPECT_THAT([&] { ReadRows(rows); }, ThrowsMessage<InputError>(HasSubstr(message))) << rows;
  };
  expect(good + "1,nan,0,0,1,0,0,0,OK\n", "needle.csv:3: x_mm is 'nan'");
  expect(good + "1,0,0,inf,1,0,0,0,OK\n", "needle.csv:3: z_mm is 'inf'");
  expect(good + "1,0,0,1e9,1,0,0,0,OK\n", "needle.csv:3: z_mm is 1e9");
  expect(good + "nan,0,0,0,1,0,0,0,OK\n", "needle.csv:3: time_s is 'nan'");
  expect(good + "1e300,0,0,0,1,0,0,0,OK\n", "needle.csv:3: time_s is '1e300'");
  expect(good + "-0.001,0,0,0,1,0,0,0,OK\n", "time must increase");
  expect("0,0,0,0,1.002,0,0,0,OK\n", "needle.csv:2: the quaternion (qw,qx,qy,qz) has norm 1.002");
  expect("0,0,0,0,0,0,0,0,OK\n", "has norm 0");
  expect(good + "1,0,0,0,1,0,0,0,ok\n", "needle.csv:3: status is 'ok'; allowed: OK, INVALID");
  expect(good + "1,0,0,0,1,0,0,OK\n", "needle.csv:3: has 8 cells");
  expect(good + "1,0,0,0,1,0,0,0,OK,7\n", "needle.csv:3: has 10 cells");
  expect("", "has no samples");
}

TEST(PoseCsv, KeepsTheFirstOfRowsWithOneStamp) {
  const PoseStream stream =
      ReadRows("0,1,0,0,1,0,0,0,OK\n0,2,0,0,1,0,0,0,OK\n1,3,0,0,1,0,0,0,OK\n");
  ASSERT_EQ(stream.size(), 2U);
  EXPECT_EQ(stream[0].reference_from_tool.translation().x(), 1.0);
  EXPECT_EQ(stream[1].reference_from_tool.translation().x(), 3.0);
}

TEST(PoseCsv, AcceptsAQuaternionAtTheEdgeOfTheToleranceAndNormalisesIt) {
  const PoseStream stream = ReadRows("0,0,0,0,0,0.9991,0,0,OK\n");
  EXPECT_EQ(stream[0].reference_from_tool.quaternion().x(), 1.0);
}

TEST(PoseCsv, DropsALastLineThatIsCutOffAndWarns) {
  const std::string rows = "0,1,2,3,1,0,0,0,OK\n1,1,2,3,1,0,0,0,INVALID";
  for (std::size_t cut = rows.find('\n') + 2; cut <= rows.size(); ++cut) {
    int warnings = 0;
    RunContext context;
    context.on_warning = [&](std::string_view text) {
      ++warnings;
      EXPECT_THAT(std::string(text), HasSubstr("needle.csv:3: the last line is cut off"));
    };
    const PoseStream stream = ReadRows(rows.substr(0, cut), context);
    // Only the whole status shows that the line is whole.
    EXPECT_EQ(stream.size(), cut == rows.size() ? 2U : 1U) << cut;
    EXPECT_EQ(warnings, cut == rows.size() ? 0 : 1) << cut;
  }
}

TEST(PoseCsv, InvalidSamplesKeepTheLastGoodPose) {
  const PoseStream stream = ReadRows(
      "0,nan,nan,nan,0,0,0,0,INVALID\n1,5,0,0,1,0,0,0,OK\n2,9,9,9,1,0,0,0,INVALID\n"
      "3,,,,,,,,INVALID\n4,6,0,0,1,0,0,0,OK\n");
  std::vector<double> x_mm;
  std::vector<bool> valid;
  for (const PoseSample& sample : stream) {
    x_mm.push_back(sample.reference_from_tool.translation().x());
    valid.push_back(sample.valid);
  }
  EXPECT_THAT(x_mm, ElementsAre(5, 5, 5, 5, 6));
  EXPECT_THAT(valid, ElementsAre(false, true, false, false, true));
}

TEST(PoseCsv, RowsWithEmptyCellsAreInvalidAndCounted) {
  std::vector<std::string> warnings;
  RunContext context;
  context.on_warning = [&](std::string_view text) { warnings.emplace_back(text); };
  const PoseStream stream =
      ReadRows("0,5,0,0,1,0,0,0,OK\n1,,0,0,1,0,0,0,OK\n2,7,0,0,1,0,0,0,OK\n", context);
  ASSERT_EQ(stream.size(), 3U);
  EXPECT_FALSE(stream[1].valid);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], HasSubstr("1 row with empty cells taken as INVALID"));
}

TEST(SecondsText, IsExactToTheNanosecond) {
  for (const std::int64_t time_ns :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{-1}, std::int64_t{1'000'000},
        std::int64_t{-1'500'000'001}, std::int64_t{1'700'000'000'123'456'789}}) {
    EXPECT_EQ(NanosecondsFromText(SecondsText(time_ns)), time_ns);
  }
  EXPECT_EQ(SecondsText(-1'500'000'000), "-1.5");
  EXPECT_EQ(NanosecondsFromText("1.5e-3"), 1'500'000);
  EXPECT_EQ(NanosecondsFromText("0.00000000149"), 1);
  EXPECT_EQ(NanosecondsFromText("1,5"), std::nullopt);
  EXPECT_EQ(NanosecondsFromText(""), std::nullopt);
}

TEST(SessionFolder, NamesWhatIsMissingOrLeadsOutside) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary / "session";
  const auto read = [&](const std::string& streams) {
    WriteTextFile(folder / "session.json",
                  R"({"format": "acus-session/1", "streams": )" + streams + "}");
    return [folder] { ReadSession(folder, RunContext{}); };
  };
  EXPECT_THAT([&] { ReadSession(folder, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("has no session.json")));
  EXPECT_THAT(read(R"([{"tool": "probe", "file": "p.csv"}])"),
              ThrowsMessage<InputError>(HasSubstr("/streams/0/file: there is no file")));
  EXPECT_THAT(read(R"([{"tool": "probe", "file": "../p.csv"}])"),
              ThrowsMessage<InputError>(HasSubstr("beside session.json")));
  EXPECT_THAT(read(R"([{"tool": "hand", "file": "p.csv"}])"),
              ThrowsMessage<InputError>(HasSubstr("/streams/0/tool")));
  EXPECT_THAT(read("[]"), ThrowsMessage<InputError>(HasSubstr("/streams")));
  WriteTextFile(folder / "p.csv", std::string(kHeader) + "0,0,0,0,1,0,0,0,OK\n");
  EXPECT_THAT(read(R"([{"tool": "probe", "file": "p.csv"}, {"tool": "probe", "file": "p.csv"}])"),
              ThrowsMessage<InputError>(HasSubstr("/streams/1/tool: \"probe\" is given twice")));
}

TEST(SessionFolder, SurvivesDamagedFiles) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary / "session";
  WriteSession(folder, RandomSession(40), RunContext{});
  for (const char* name : {"session.json", "needle.csv"}) {
    const std::string valid = ReadTextFile(folder / name);
    const int refused = testing_support::ReadDamagedCopies(
        valid, folder / name, 400, [&] { ReadSession(folder, RunContext{}); });
    EXPECT_GT(refused, 100) << name;
    WriteTextFile(folder / name, valid);
  }
}

}  // namespace
}  // namespace acus::session
