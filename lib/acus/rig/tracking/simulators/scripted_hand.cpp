#include "acus/rig/tracking/simulators/scripted_hand.h"

#include <array>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/base/math/rigid.h"

namespace acus::simulators {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// From 0 to 1 with the least jerk, at rest at both ends.
double Smooth(double fraction) {
  const double s = std::clamp(fraction, 0.0, 1.0);
  return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

class Hand final : public ToolMotion {
 public:
  Hand(const HandScript& script, const ToolNames& names, std::uint64_t seed)
      : script_(script), names_(names) {
    const double depth_mm = (script.target_mm - script.entry_mm).norm();
    ACUS_REQUIRE(std::isfinite(depth_mm) && depth_mm >= 1.0 && depth_mm <= 1000.0,
                 "the hand's target is ", depth_mm, " mm from its entry; allowed are 1 to 1000");
    ACUS_REQUIRE(script.rate_hz >= 0.1 && script.rate_hz <= 5000.0, "rate is ", script.rate_hz,
                 " Hz; allowed are 0.1 to 5000");
    ACUS_REQUIRE(script.insertion_mm_s >= 0.1 && script.insertion_mm_s <= 1000.0,
                 "the hand's speed is ", script.insertion_mm_s, " mm/s; allowed are 0.1 to 1000");
    ACUS_REQUIRE(script.tremor_mm >= 0.0 && script.tremor_mm <= 10.0, "the hand's tremor is ",
                 script.tremor_mm, " mm; allowed are 0 to 10");
    needle_frame_ = math::PoseFromAxes(
        script.entry_mm, (script.target_mm - script.entry_mm).normalized(), Vector3d::UnitX());
    step_ns_ = std::llround(1e9 / script.rate_hz);
    way_s_ = (depth_mm + script.hover_mm) / script.insertion_mm_s;
    depth_mm_ = depth_mm;
    RandomStream random(seed, "tremor of the scripted hand");
    for (Sine& sine : sines_) {
      sine.hz = random.Uniform(7.0, 12.0);
      for (double& phase : sine.phase) phase = random.Uniform(0.0, 2.0 * std::numbers::pi);
    }
  }

  std::optional<std::int64_t> end_ns() const override { return std::nullopt; }

  std::optional<std::int64_t> Next(std::int64_t time_ns) const override {
    return time_ns < 0 ? 0 : (time_ns / step_ns_ + 1) * step_ns_;
  }

  std::vector<tracking::NamedPose> At(std::int64_t time_ns) const override {
    const double time_s = 1e-9 * static_cast<double>(time_ns);
    return {{.name = names_.needle, .reference_from_tool = Needle(time_s)},
            {.name = names_.probe, .reference_from_tool = Probe(time_s)}};
  }

 private:
  struct Sine {
    double hz = 0.0;
    std::array<double, 3> phase{};
  };

  Vector3d Tremor(double time_s) const {
    Vector3d sum = Vector3d::Zero();
    for (const Sine& sine : sines_) {
      for (int axis = 0; axis < 3; ++axis) {
        sum[axis] +=
            std::sin(2.0 * std::numbers::pi * sine.hz * time_s + sine.phase[std::size_t(axis)]);
      }
    }
    // Each sine has a mean square of a half.
    return sum * script_.tremor_mm * std::sqrt(2.0 / static_cast<double>(sines_.size()));
  }

  Isometry3d Needle(double time_s) const {
    const double cycle_s = 2.0 * (way_s_ + script_.hold_s);
    const double t = std::fmod(time_s, cycle_s);
    const double in = Smooth(t / way_s_);
    const double out = Smooth((t - way_s_ - script_.hold_s) / way_s_);
    const double depth_mm = -script_.hover_mm + (depth_mm_ + script_.hover_mm) * (in - out);
    return Translation3d(Tremor(time_s)) * needle_frame_ * Translation3d(0.0, 0.0, depth_mm);
  }

  /// Probe frame: +y along the beam into the body, which is the needle's +z.
  Isometry3d Probe(double time_s) const {
    const double sweep = std::sin(2.0 * std::numbers::pi * 0.1 * time_s);
    const Isometry3d needle_from_probe =
        Translation3d(script_.probe_aside_mm, script_.sweep_mm * sweep, 0.0) *
        AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX()) *
        AngleAxisd(script_.sweep_deg * kRadPerDeg * sweep, Vector3d::UnitX());
    return needle_frame_ * needle_from_probe;
  }

  HandScript script_;
  ToolNames names_;
  Isometry3d needle_frame_;
  double depth_mm_ = 0.0, way_s_ = 0.0;
  std::int64_t step_ns_ = 1;
  std::array<Sine, 6> sines_;
};

}  // namespace

std::unique_ptr<ToolMotion> ScriptedHand(const HandScript& script, const ToolNames& names,
                                         std::uint64_t seed) {
  return std::make_unique<Hand>(script, names, seed);
}

}  // namespace acus::simulators
