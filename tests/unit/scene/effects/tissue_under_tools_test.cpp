#include "acus/scene/effects/view_3d/tissue_under_tools.h"

#include <cmath>
#include <gtest/gtest.h>

#include "support/view_scenes.h"

namespace acus::effects {
namespace {

using testing_support::At;
using testing_support::DiaphragmMm;
using testing_support::FieldOf;

constexpr math::InverseSettings kAsImages{.max_iterations = 5, .tolerance_mm = 0.02};
constexpr double kDentWideMm = 18.0;

/// A map as images have it: what is now at a place was pressed along y by a Gaussian around
/// `at_mm`, and breathed before that.
class PressedBreath : public slicing::RestMap {
 public:
  PressedBreath(const breathing::MotionMap* breath, const Eigen::Vector3d& at_mm, double deep_mm)
      : breath_(breath), at_mm_(at_mm), deep_mm_(deep_mm) {}

  Eigen::Vector3d Breathed(const Eigen::Vector3d& place) const {
    const double far_2 = (place - at_mm_).squaredNorm() / (kDentWideMm * kDentWideMm);
    if (far_2 > 9.0) return place;
    return place -
           deep_mm_ * std::exp(-0.5 * far_2) * (1.0 - far_2 / 9.0) * Eigen::Vector3d::UnitY();
  }
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place,
                             const Eigen::Vector3d& /*guess*/) const noexcept override {
    const Eigen::Vector3d breathed = Breathed(place);
    return breath_ == nullptr ? breathed : breath_->RestOf(breathed, breathed, kAsImages).rest_mm;
  }
  double SpacingMm() const noexcept override { return 5.0; }

 private:
  const breathing::MotionMap* breath_;
  Eigen::Vector3d at_mm_;
  double deep_mm_;
};

ToolsOnTissue NeedleAt(const Eigen::Vector3d& tip_mm) {
  ToolsOnTissue tools;
  tools.needle.emplace();
  tools.needle->tip_in_ct_mm = tip_mm;
  tools.needle->axis_in_ct = Eigen::Vector3d::UnitY();
  tools.needle->length_mm = 80.0;
  tools.needle->radius_mm = 0.8;
  return tools;
}

/// The largest and the mean error of a place where breath alone would have the tissue.
struct Error {
  double worst_mm = 0.0;
  double mean_mm = 0.0;
};
Error ErrorOf(const volume_rendering::PressedTissue& pressed, const PressedBreath& truth,
              const Eigen::Vector3d& around_mm) {
  Error out;
  int count = 0;
  for (double z = -50.0; z <= 50.0; z += 4.7) {
    for (double y = -50.0; y <= 50.0; y += 5.3) {
      for (double x = -50.0; x <= 50.0; x += 4.1) {
        const Eigen::Vector3d place = around_mm + Eigen::Vector3d(x, y, z);
        const Eigen::Vector3d seen = place + pressed.OffsetMm(place.cast<float>()).cast<double>();
        const double error_mm = (seen - truth.Breathed(place)).norm();
        out.worst_mm = std::max(out.worst_mm, error_mm);
        out.mean_mm += error_mm;
        ++count;
      }
    }
  }
  out.mean_mm /= count;
  return out;
}

TEST(PressedIn, IsWhatToolsAddToTheBreath) {
  const auto field = FieldOf(DiaphragmMm);
  const Eigen::Vector3d at(4.0, -20.0, 10.0);
  for (const double amount : {0.0, 0.6, 1.0}) {
    const auto breath = At(field, amount);
    const PressedBreath map(&breath, at, 12.0);
    const auto pressed = PressedIn(map, &breath, ReachOf(NeedleAt(at)), {});
    ASSERT_FALSE(pressed.empty());
    const Error error = ErrorOf(pressed, map, at);
    // Of 12 mm: the knots' spacing, the inversion's 0.02 mm, and what is below 0.1 mm.
    EXPECT_LT(error.worst_mm, 0.3) << amount;
    EXPECT_LT(error.mean_mm, 0.03) << amount;
  }
}

TEST(PressedIn, MoreKnotsAreNearer) {
  const Eigen::Vector3d at(0.0, 0.0, 0.0);
  const PressedBreath map(nullptr, at, 12.0);
  double before_mm = 1e9;
  for (const int knots : {1'000, 8'000, 30'000}) {
    const auto pressed = PressedIn(map, nullptr, ReachOf(NeedleAt(at)), {.most_knots = knots});
    const double worst_mm = ErrorOf(pressed, map, at).worst_mm;
    EXPECT_LT(worst_mm, before_mm) << knots;
    before_mm = worst_mm;
  }
  EXPECT_LT(before_mm, 0.2);
}

TEST(PressedIn, WithoutToolsThereIsNothing) {
  const auto field = FieldOf(DiaphragmMm);
  const auto breath = At(field, 1.0);
  const PressedBreath only_breath(&breath, Eigen::Vector3d::Zero(), 0.0);
  EXPECT_TRUE(
      PressedIn(only_breath, &breath, ReachOf(NeedleAt(Eigen::Vector3d::Zero())), {}).empty());
  EXPECT_TRUE(PressedIn(only_breath, &breath, ReachOf({}), {}).empty());
  const PressedBreath far_away(nullptr, Eigen::Vector3d(500.0, 0.0, 0.0), 10.0);
  EXPECT_TRUE(PressedIn(far_away, nullptr, ReachOf(NeedleAt(Eigen::Vector3d::Zero())), {}).empty());
  EXPECT_TRUE(ReachOf(NeedleAt(Eigen::Vector3d::Constant(std::nan("")))).isEmpty());
}

TEST(PressedIn, SameBitsWithAnyNumberOfThreads) {
  const Eigen::Vector3d at(0.0, 5.0, 0.0);
  const PressedBreath map(nullptr, at, 8.0);
  const auto one = PressedIn(map, nullptr, ReachOf(NeedleAt(at)), {.num_threads = 1});
  const auto three = PressedIn(map, nullptr, ReachOf(NeedleAt(at)), {.num_threads = 3});
  for (double x = -30.0; x < 30.0; x += 1.3) {
    const Eigen::Vector3f place(static_cast<float>(x), 4.0F, -2.0F);
    EXPECT_EQ(one.OffsetMm(place), three.OffsetMm(place));
  }
}

}  // namespace
}  // namespace acus::effects
