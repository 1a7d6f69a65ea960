#include "acus/patient/registration/pivot.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::registration {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Removed when the tests end.
std::filesystem::path Scratch() {
  static const testing_support::TemporaryFolder folder;
  return folder.path();
}

const Vector3d kTipMm(1.5, -3.0, 160.0);
const Vector3d kPivotMm(30.0, 400.0, -1200.0);

/// Poses that turn about the tip by up to `angle_rad`, with noise of the position.
std::vector<Isometry3d> Poses(int count, double angle_rad, double noise_mm,
                              std::uint64_t seed = 1) {
  RandomStream random(seed, "pivot");
  std::vector<Isometry3d> poses(static_cast<std::size_t>(count));
  for (Isometry3d& pose : poses) {
    const Vector3d axis(random.Normal(), random.Normal(), random.Normal());
    pose = Isometry3d(AngleAxisd(random.Uniform(-angle_rad, angle_rad), axis.normalized()));
    const Vector3d noise(random.Normal(), random.Normal(), random.Normal());
    pose.translation() = kPivotMm - pose.linear() * kTipMm + noise_mm * noise;
  }
  return poses;
}

TEST(CalibratePivot, IsExactWithoutNoise) {
  for (const int count : {4, 10, 500}) {
    const PivotCalibration result = CalibratePivot(Poses(count, 1.0, 0.0));
    EXPECT_LT((result.tip_mm - kTipMm).norm(), 1e-9) << count;
    EXPECT_LT((result.pivot_mm - kPivotMm).norm(), 1e-9) << count;
    EXPECT_LT(result.residual_rms_mm, 1e-9);
  }
}

TEST(CalibratePivot, StatesItsNoiseAndItsUncertainty) {
  double error2 = 0.0;
  double stated2 = 0.0;
  double noise2 = 0.0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    const PivotCalibration result = CalibratePivot(Poses(60, 0.6, 0.4, trial));
    error2 += (result.tip_mm - kTipMm).squaredNorm() / kTrials;
    stated2 += result.tip_sd_mm.squaredNorm() / kTrials;
    noise2 += result.residual_coordinate_rms_mm * result.residual_coordinate_rms_mm / kTrials;
    EXPECT_NEAR(result.residual_rms_mm, std::sqrt(3.0) * result.residual_coordinate_rms_mm, 1e-12);
  }
  EXPECT_NEAR(std::sqrt(stated2 / error2), 1.0, 0.1);
  EXPECT_NEAR(std::sqrt(noise2), 0.4 * std::sqrt(174.0 / 180.0), 0.01);
}

TEST(CalibratePivot, RefusesTooLittleRotation) {
  EXPECT_THAT([] { CalibratePivot(Poses(50, 0.02, 0.1)); },
              ThrowsMessage<NoAnswerError>(AllOf(HasSubstr("the pointer turned by only"),
                                                 HasSubstr("at least 3 deg are needed"))));
  std::vector<Isometry3d> spun;  // About one axis only: the tip along it cannot be told.
  for (int i = 0; i < 20; ++i) {
    Isometry3d pose(AngleAxisd(0.3 * i, Vector3d::UnitZ()));
    pose.translation() = kPivotMm - pose.linear() * kTipMm;
    spun.push_back(pose);
  }
  EXPECT_THROW(CalibratePivot(spun), NoAnswerError);
  EXPECT_THROW(CalibratePivotRobustly(spun), NoAnswerError);
  EXPECT_THAT([] { CalibratePivot(Poses(2, 0.7, 0.0)); },
              ThrowsMessage<InputError>(HasSubstr("at least 3 poses, got 2")));
}

/// Poses that turn at random while the tip itself moves about by `moved_mm` RMS per axis.
std::vector<Isometry3d> MovedPoses(double moved_mm) {
  return Poses(60, 0.6, moved_mm, 3);
}

TEST(RequirePivoted, AcceptsAPivotedPointer) {
  const auto poses = Poses(60, 0.6, 1.0);
  EXPECT_NO_THROW(RequirePivoted(CalibratePivot(poses), poses, 5.0));
  EXPECT_THROW(RequirePivoted(CalibratePivot(poses), poses, 0.5), NoAnswerError);
}

TEST(RequirePivoted, SaysThatThePointerWasMoved) {
  const auto poses = MovedPoses(60.0);
  EXPECT_THAT([&] { RequirePivoted(CalibratePivot(poses), poses, 5.0); },
              ThrowsMessage<NoAnswerError>(HasSubstr("was moved, not pivoted")));
  EXPECT_THAT([&] { RequirePivoted(CalibratePivotRobustly(poses), poses, 5.0); },
              ThrowsMessage<NoAnswerError>(HasSubstr("was moved, not pivoted")));
}

TEST(RequirePivoted, SaysThatTheTipSlid) {
  const auto poses = MovedPoses(5.0);
  EXPECT_THAT([&] { RequirePivoted(CalibratePivot(poses), poses, 5.0); },
              ThrowsMessage<NoAnswerError>(HasSubstr("the tip slid")));
}

TEST(RequirePivoted, NamesOutliers) {
  auto poses = Poses(60, 0.6, 0.2);
  for (std::size_t i = 0; i < poses.size(); i += 6) poses[i].translation() += Vector3d(40, -20, 10);
  EXPECT_THAT([&] { RequirePivoted(CalibratePivot(poses), poses, 5.0); },
              ThrowsMessage<NoAnswerError>(HasSubstr("10 poses do not fit the others")));
  EXPECT_NO_THROW(RequirePivoted(CalibratePivotRobustly(poses), poses, 5.0));
}

TEST(CalibratePivotRobustly, LeavesOutWrongPoses) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    auto poses = Poses(60, 0.6, 0.2, seed);
    for (std::size_t i = 0; i < poses.size(); i += 4)
      poses[i].translation() += Vector3d(40, -20, 10);
    const PivotCalibration robust = CalibratePivotRobustly(poses);
    EXPECT_LT((robust.tip_mm - kTipMm).norm(), 0.5) << seed;
    EXPECT_GT((CalibratePivot(poses).tip_mm - kTipMm).norm(), 2.0) << seed;
    for (std::size_t i = 0; i < poses.size(); i += 4) EXPECT_FALSE(robust.used[i]);
    EXPECT_GE(std::ranges::count(robust.used, true), 44);
  }
}

TEST(ReadPoses, ReadsFoldersFilesAndStreams) {
  const auto folder = Scratch() / "poses";
  std::filesystem::create_directories(folder);
  WriteTextFile(folder / "1.txt", "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n");
  WriteTextFile(folder / "2.txt", "0 -1 0 8\n1 0 0 6\n0 0 1 7\n0 0 0 1\n");
  const auto poses = ReadPoses(folder);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[1].translation(), Vector3d(8, 6, 7));
  EXPECT_EQ(ReadPoses(folder / "1.txt").size(), 1U);
  const auto stream = Scratch() / "poses.csv";
  WriteTextFile(stream,
                "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status\n0,1,2,3,1,0,0,0,OK\n"
                "1,9,9,9,1,0,0,0,INVALID\n2,4,5,6,0,0,0,1,OK\n");
  const auto streamed = ReadPoses(stream);
  ASSERT_EQ(streamed.size(), 2U);
  EXPECT_TRUE((streamed[1] * Vector3d(1, 0, 0)).isApprox(Vector3d(3, 5, 6), 1e-12));
  WriteTextFile(stream, "x_mm,y_mm,z_mm,qw,qx,qy,qz\n1,2,3,2,0,0,0\n");
  EXPECT_THAT([&] { ReadPoses(stream); }, ThrowsMessage<InputError>(HasSubstr("poses.csv:2")));
}

TEST(ReadPoses, SurvivesBrokenFiles) {
  const auto path = Scratch() / "broken_pose.txt";
  const std::string valid = "0 -1 0 8.5\n1 0 0 6.25\n0 0 1 7\n0 0 0 1\n";
  EXPECT_GT(testing_support::ReadDamagedCopies(valid, path, 400, [&] { ReadPoses(path); }), 100);
}

}  // namespace
}  // namespace acus::registration
