#include "acus/run/training/session_metrics.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/base/math/rigid.h"

namespace acus::training {
namespace {

using session::PoseStream;
using session::Session;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr volume::Label kSkin = 1;
constexpr volume::Label kVessel = 11;

/// 40 x 40 x 60 mm of skin, voxels of 1 mm centred at the origin in x and y, z from 0 on; a vessel
/// 2 mm thick across it at z = 30.
volume::LabelMap Tissue() {
  volume::Geometry geometry;
  geometry.size = {40, 40, 60};
  geometry.spacing_mm = {1.0, 1.0, 1.0};
  geometry.origin_mm = {-19.5, -19.5, 0.5};
  volume::LabelMap labels(geometry);
  for (int k = 0; k < 60; ++k) {
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 40; ++i) labels.At(i, j, k) = k == 30 || k == 31 ? kVessel : kSkin;
    }
  }
  labels.names = {{0, "outside"}, {kSkin, "skin"}, {kVessel, "vessel"}};
  return labels;
}

session::PoseSample At(double time_s, const Eigen::Vector3d& tip_mm,
                       const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ()) {
  return {static_cast<std::int64_t>(time_s * 1e9),
          math::PoseFromAxes(tip_mm, axis, Eigen::Vector3d::UnitX()), true};
}

double ValueOf(const std::vector<Metric>& metrics, const std::string& name) {
  for (const Metric& metric : metrics) {
    if (metric.name == name) return metric.value;
  }
  ADD_FAILURE() << "there is no metric " << name;
  return 0.0;
}

TEST(Structures, AQuickStabThroughAThinVesselIsSeen) {
  const auto labels = Tissue();
  Session session;
  session.needle = {At(0.0, {0, 0, -5}), At(0.1, {0, 0, 20}), At(0.2, {0, 0, 40}),
                    At(0.3, {0, 0, 20})};
  const auto entered = NamedStructuresOf(session, {labels});
  ASSERT_EQ(entered.size(), 2);
  EXPECT_EQ(entered[1].name, "vessel");
  EXPECT_EQ(entered[1].entered.num_entries, 2) << "in and out again";
  EXPECT_NEAR(entered[1].entered.path_mm, 4.0, 0.5);
  EXPECT_EQ(entered[1].entered.first_ns, 200'000'000);
  EXPECT_EQ(EntriesInto({"vessel"}, entered).value, 2.0);
  EXPECT_EQ(EntriesInto({"bowel"}, entered).value, 0.0);
}

TEST(Structures, TremorAtAWallIsOneEntry) {
  const auto labels = Tissue();
  Session session;
  for (int i = 0; i < 40; ++i) session.needle.push_back(At(0.01 * i, {0, 0, i % 2 ? 30.2 : 29.8}));
  const auto entered = NamedStructuresOf(session, {labels});
  ASSERT_EQ(entered.size(), 2);
  EXPECT_EQ(entered[1].entered.num_entries, 1);
}

// A hand that trembles by 0.1 mm rests for 10 s where the vessel begins, once in; at any rate it is
// one entry, one attempt. Its path outside grows with the rate.
TEST(Structures, EntriesDoNotGrowWithTheRateOfSamples) {
  const auto labels = Tissue();
  for (const double z_mm : {30.0, 0.0}) {  // The vessel's wall, the skin.
    for (const int hz : {8, 60, 1000}) {
      RandomStream random(7, "tremor", 0);
      Session session;
      session.needle.push_back(At(-1.0, {0, 0, -20.0}));
      for (int i = 0; i < 10 * hz; ++i) {
        session.needle.push_back(
            At(static_cast<double>(i) / hz, {0, 0, z_mm + 0.1 * random.Normal()}));
      }
      const auto entered = NamedStructuresOf(session, {labels});
      for (const auto& structure : entered) {
        EXPECT_EQ(structure.entered.num_entries, 1) << structure.name << " at " << hz << " Hz";
      }
      EXPECT_EQ(entered.size(), z_mm > 0.0 ? 2 : 1);
      EXPECT_EQ(ValueOf(NeedleMetricsOf(session, {labels}), "attempts"), 1.0) << hz;
    }
  }
}

// A hand that trembles by 0.1 mm advances by 50 mm in 10 s, 48 mm of them in skin.
TEST(Structures, PathsAddUpToThePathInTissueAtAnyRate) {
  const auto labels = Tissue();
  for (const int hz : {8, 60, 1000}) {
    RandomStream random(7, "tremor", 0);
    Session session;
    for (int i = 0; i <= 10 * hz; ++i) {
      const double t_s = static_cast<double>(i) / hz;
      session.needle.push_back(At(t_s, {0, 0, 2.0 + 5.0 * t_s + 0.1 * random.Normal()}));
    }
    const auto entered = NamedStructuresOf(session, {labels});
    ASSERT_EQ(entered.size(), 2);
    EXPECT_NEAR(entered[0].entered.path_mm, 48.0, 2.0) << hz;
    EXPECT_NEAR(entered[1].entered.path_mm, 2.0, 0.6) << hz;
    EXPECT_NEAR(entered[0].entered.path_mm + entered[1].entered.path_mm,
                ValueOf(NeedleMetricsOf(session, {labels}), "needle path in tissue"), 0.3)
        << hz;
  }
}

TEST(Structures, ReportsWhatThePatientsMapDoesNotDistinguish) {
  const auto labels = Tissue();
  EXPECT_THAT(NotInMap({"vessel", "bowel"}, labels), ElementsAre("bowel"));
  EXPECT_THAT(
      [&] { NotInMap({"vesel"}, labels); },
      ThrowsMessage<InputError>(testing::AllOf(HasSubstr("\"vesel\""), HasSubstr("skin, vessel"))));
}

TEST(SessionMetrics, MeasuresTheDistanceToTheTarget) {
  const auto labels = Tissue();
  Session session;
  for (int i = 0; i <= 50; ++i) session.needle.push_back(At(0.1 * i, {3, 0, -10.0 + i}));
  for (int i = 1; i <= 50; ++i) session.needle.push_back(At(5.0 + 0.1 * i, {3, 0, 40.0 - i}));
  // The reference is 5 mm off the CT.
  Anatomy anatomy{labels, Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 5.0))};
  Exercise exercise;
  exercise.target_radius_mm = 5.0;
  const auto metrics = TargetMetricsOf(session, anatomy, {3.0, 4.0, 38.0}, exercise);
  EXPECT_NEAR(ValueOf(metrics, "tip to target, closest"), 4.0, 1e-12);
  // The deepest point is z = 40 of the reference, 45 of the CT: 7 deeper and 4 aside.
  EXPECT_NEAR(ValueOf(metrics, "tip to target at the end"), std::hypot(4.0, 7.0), 1e-12);
  // Within 5 mm from 3 mm before on: z = 30 of the reference, the 40th sample.
  EXPECT_NEAR(ValueOf(metrics, kTimeToTarget), 4.0, 1e-9);
  exercise.target_radius_mm = 3.0;
  for (const Metric& m : TargetMetricsOf(session, anatomy, {3.0, 4.0, 38.0}, exercise)) {
    EXPECT_NE(m.name, kTimeToTarget) << "it was never reached";
  }
}

TEST(PlaneShare, CountsTheTimeThatTheImageShowsTheNeedle) {
  const auto labels = Tissue();
  Session session;
  // In the plane z-y of the probe (its normal is x) for 2 s, then drawn 5 mm aside for 1 s, then
  // crossing it at 30 degrees for 1 s.
  for (int i = 0; i <= 400; ++i) {
    const double time_s = 0.01 * i;
    const double x_mm = time_s > 2.0 + 1e-9 && time_s < 3.0 + 1e-9 ? 5.0 : 0.0;
    const bool crosses = time_s > 3.0 + 1e-9;
    session.needle.push_back(
        At(time_s, {x_mm, 0, 20},
           crosses ? Eigen::Vector3d(0.5, 0.0, std::sqrt(0.75)) : Eigen::Vector3d::UnitZ()));
  }
  // Columns: x along the face, y the beam, z the normal.
  Eigen::Matrix3d axes;
  axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = axes;
  session.probe = {{0, pose, true}, {10'000'000'000, pose, true}};
  const auto metrics = NeedleMetricsOf(session, {labels});
  EXPECT_NEAR(ValueOf(metrics, "tip in the image plane"), 75.0, 1e-6);
  EXPECT_NEAR(ValueOf(metrics, "needle in the image plane"), 50.0, 1e-6);
  EXPECT_NEAR(ValueOf(metrics, "needle time in tissue"), 4.0, 1e-9);
}

TEST(PlaneShare, IsNothingWhereOneOfTheToolsIsNotSeen) {
  Session session;
  for (int i = 0; i < 10; ++i) session.needle.push_back(At(0.1 * i, {0, 0, 20}));
  const auto inside = [](const Eigen::Vector3d&) { return true; };
  EXPECT_EQ(ComputePlaneShare(session, inside).seconds, 0.0);
  session.probe = {At(0.0, {0, 0, 0}), At(1.0, {0, 0, 0})};
  session.probe[0].valid = session.probe[1].valid = false;
  EXPECT_EQ(ComputePlaneShare(session, inside).seconds, 0.0);
  session.probe[0].valid = session.probe[1].valid = true;
  EXPECT_NEAR(ComputePlaneShare(session, inside).seconds, 0.9, 1e-9);
  session.needle[5].valid = false;
  EXPECT_NEAR(ComputePlaneShare(session, inside).seconds, 0.7, 1e-9);
}

TEST(Structures, ASwapOfHandsIsNoMotionOfTheNeedle) {
  const auto labels = Tissue();
  Session session;
  // 10 mm deep; then the other hand, 30 mm outside, holds the needle.
  session.needle = {At(0.0, {0, 0, -5}), At(0.1, {0, 0, 10}), At(0.2, {0, 0, -30}),
                    At(0.3, {0, 0, -30})};
  const Anatomy anatomy{labels};
  EXPECT_EQ(ValueOf(MotionMetricsOf(session), "needle path length"), 55.0);
  session.commands = {{200'000'000, session::CommandKind::kSwapHands, 0.0}};
  const auto motion = MotionMetricsOf(session);
  EXPECT_EQ(ValueOf(motion, "needle path length"), 15.0);
  EXPECT_DOUBLE_EQ(ValueOf(motion, "needle elapsed time"), 0.3);
  EXPECT_NEAR(ValueOf(motion, "needle largest speed"), 150.0, 1e-9);
  const auto needle = NeedleMetricsOf(session, anatomy);
  EXPECT_EQ(ValueOf(needle, "passes"), 0.0) << "the first sample in tissue is the deepest";
  EXPECT_EQ(ValueOf(needle, "attempts"), 1.0);
}

}  // namespace
}  // namespace acus::training
