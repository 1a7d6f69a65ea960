#include "acus/physics/breathing/model_building.h"

#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/physics/breathing/model_errors.h"
#include "support/breathing_box.h"

namespace acus::breathing {
namespace {

using testing_support::BreathingNodes;
using testing_support::RegularBreath;
using testing_support::TruePhases;

constexpr double kRoundedMm = 2e-3;  ///< 16 bits, three components.

TEST(ModelBuilding, EveryModelRepeatsWhatItCanExpress) {
  EXPECT_LT(ErrorOf(BuildModel(MotionKind::kSinusoid, TruePhases(10, 0.0)), TruePhases(10, 0.0), {})
                .largest_mm,
            kRoundedMm);
  EXPECT_LT(
      ErrorOf(BuildModel(MotionKind::kHalfCycle, TruePhases(10, 0.0)), TruePhases(10, 0.0), {})
          .largest_mm,
      kRoundedMm);
  for (const MotionKind kind : {MotionKind::kFullCycle, MotionKind::kSurrogate}) {
    EXPECT_LT(ErrorOf(BuildModel(kind, TruePhases(10)), TruePhases(10), {}).largest_mm, kRoundedMm)
        << NameOf(kind);
  }
}

/// What the paper says of its models: only key frames of the whole cycle and the surrogate know
/// hysteresis, only half a cycle and the surrogate a deeper breath.
TEST(ModelBuilding, ModelsDifferWhereThePaperSaysTheyDo) {
  const MotionPhases known = TruePhases(10);
  const double hysteresis_mm =
      ErrorOf(BuildModel(MotionKind::kHalfCycle, known), known, {}).mean_mm;
  EXPECT_GT(hysteresis_mm, 0.2);
  EXPECT_GT(ErrorOf(BuildModel(MotionKind::kSinusoid, known), known, {}).mean_mm, 0.2);

  const MotionPhases deeper = TruePhases(10, 1.0, 1.5);
  const double full_mm = ErrorOf(BuildModel(MotionKind::kFullCycle, known), deeper, {}).mean_mm;
  const double surrogate_mm =
      ErrorOf(BuildModel(MotionKind::kSurrogate, known), deeper, {}).mean_mm;
  const double half_mm = ErrorOf(BuildModel(MotionKind::kHalfCycle, known), deeper, {}).mean_mm;
  EXPECT_GT(full_mm, 2.0);
  EXPECT_LT(half_mm, 0.5 * full_mm);
  EXPECT_LT(surrogate_mm, kRoundedMm);
}

TEST(ModelBuilding, LeavingAPhaseOutCostsKeyFramesTheirInterpolation) {
  const MotionPhases known = TruePhases(10);
  EXPECT_LT(LeaveOneOutError(MotionKind::kSurrogate, known, {}).largest_mm, kRoundedMm);
  const ModelError frames = LeaveOneOutError(MotionKind::kFullCycle, known, {});
  // A cosine of amplitude a / 2 between frames 2 pi / 5 apart: off by up to 0.095 a.
  EXPECT_GT(frames.mean_mm, 0.2);
  EXPECT_LT(frames.mean_mm, 0.1 * 14.0);
}

TEST(ModelBuilding, FilteringInTimeTakesOutWhatOnlyOnePhaseHas) {
  MotionPhases noisy = TruePhases(10);
  RandomStream random(3, "registration");
  for (auto& phase : noisy.phases) {
    for (float& value : phase.displacement_in_ct_mm) {
      value += static_cast<float>(0.5 * random.Normal());
    }
  }
  const auto rms = [](const MotionPhases& a, const MotionPhases& b) {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t j = 1; j < a.phases.size(); ++j) {
      for (std::size_t n = 0; n < a.num_values(); ++n, ++count) {
        const double off =
            a.phases[j].displacement_in_ct_mm[n] - b.phases[j].displacement_in_ct_mm[n];
        sum += off * off;
      }
    }
    return std::sqrt(sum / static_cast<double>(count));
  };
  const MotionPhases truth = TruePhases(10);
  // Of the nine directions that noise has over time, two modes and the mean stay: sqrt(3 / 9).
  EXPECT_LT(rms(FilteredInTime(noisy, 2), truth), 0.65 * rms(noisy, truth));
  EXPECT_LT(rms(FilteredInTime(truth, 2), truth), 1e-4);
  EXPECT_TRUE(FilteredInTime(noisy, 2).phases.front().displacement_in_ct_mm.empty());
  const auto variance = VarianceOfModes(truth);
  EXPECT_NEAR(variance[0] + variance[1], 1.0, 1e-9);
  EXPECT_GT(variance[0], 0.8);
}

TEST(ModelBuilding, ResamplingKeepsALinearField) {
  const MotionPhases finer = Resampled(TruePhases(4), NodesOver(BreathingNodes(), 9));
  EXPECT_EQ(finer.nodes.num_voxels(), 9U * 9U * 9U);
  const Eigen::Affine3d ct_from_index = finer.nodes.ct_from_index();
  const std::size_t n = finer.nodes.Index(8, 3, 5);
  const Eigen::Vector3d truth = testing_support::TrueDisplacementMm(
      RegularBreath(0.5), ct_from_index * Eigen::Vector3d(8, 3, 5), 1.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(finer.phases[2].displacement_in_ct_mm[3 * n + axis],
                truth[static_cast<Eigen::Index>(axis)], kRoundedMm);
  }
}

TEST(ModelBuilding, RefusesWhatDoesNotDetermineAModel) {
  EXPECT_THROW(BuildModel(MotionKind::kFullCycle, TruePhases(2)), InputError);
  MotionPhases constant = TruePhases(5);
  for (auto& phase : constant.phases) phase.breath = RegularBreath(0.3);
  for (const MotionKind kind : {MotionKind::kSinusoid, MotionKind::kFullCycle,
                                MotionKind::kHalfCycle, MotionKind::kSurrogate}) {
    EXPECT_THROW(BuildModel(kind, constant), InputError) << NameOf(kind);
  }
  MotionPhases twice = TruePhases(5);
  twice.phases[2].displacement_in_ct_mm.clear();
  EXPECT_THROW(twice.Check(), InputError);
  MotionPhases short_field = TruePhases(5);
  short_field.phases[3].displacement_in_ct_mm.pop_back();
  EXPECT_THROW(short_field.Check(), InputError);
  MotionPhases nan = TruePhases(5);
  nan.phases[3].displacement_in_ct_mm[7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(nan.Check(), InputError);
  EXPECT_THROW(FilteredInTime(TruePhases(5), 0), InputError);
}

}  // namespace
}  // namespace acus::breathing
