#include "references/closed_loop.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/base/math/driven_mass.h"
#include "acus/physics/forces/path/chatter_meter.h"

namespace acus::forces {
namespace {

constexpr int kStepsPerSample = 20;
constexpr double kFreeN = 1e-12;

Eigen::Vector3d Measured(const Eigen::Vector3d& place_mm, double encoder_mm) {
  if (encoder_mm <= 0.0) return place_mm;
  return (place_mm / encoder_mm).array().round().matrix() * encoder_mm;
}

/// From 0 to 1 with no speed and no acceleration at both ends.
double MinimumJerk(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
}

struct Move {
  double begin_s;
  double moving_s;
  Eigen::Vector3d from_mm;
  Eigen::Vector3d to_mm;
};

}  // namespace

void PassivityObserver::Add(const Eigen::Vector3d& force_n,
                            const Eigen::Vector3d& travel_mm) noexcept {
  if (force_n.norm() <= kFreeN) {
    balance_mj_ = 0.0;
    return;
  }
  const double taken_mj = -force_n.dot(travel_mm);  // 1 N mm is 1 mJ.
  balance_mj_ += taken_mj;
  total_mj_ += taken_mj;
  generated_mj_ = std::max(generated_mj_, -balance_mj_);
}

LoopResult RunClosedLoop(const HapticDevice& device, const Hand& hand, const ForceOfPlace& model,
                         double duration_s) {
  ACUS_REQUIRE(device.mass_kg > 0.0 && device.rate_hz > 0.0 && duration_s > 0.0,
               "a device needs mass and rate above 0 and some time: mass ", device.mass_kg,
               " kg, rate ", device.rate_hz, " Hz, duration ", duration_s, " s");
  ACUS_REQUIRE(hand.wants_in_ct_mm != nullptr, "the hand has nowhere to go");
  const double sample_s = 1.0 / device.rate_hz;
  const double dt_s = sample_s / kStepsPerSample;
  const math::DrivenMass mass{.mass_kg = device.mass_kg,
                              .damping_n_s_per_mm = device.damping_n_s_per_m * 1e-3,
                              .hand_n_per_mm = hand.stiffness_n_per_m * 1e-3,
                              .hand_n_s_per_mm = hand.damping_n_s_per_m * 1e-3,
                              .dry_friction_n = device.dry_friction_n};

  LoopResult result;
  PassivityObserver observer;
  math::DrivenMass::State state;
  state.place_mm = hand.wants_in_ct_mm(0.0);
  state.wanted_mm = state.place_mm;
  std::deque<Eigen::Vector3d> late(static_cast<std::size_t>(std::max(0, device.delay_steps)),
                                   Eigen::Vector3d::Zero());
  const auto num_samples = static_cast<std::size_t>(std::llround(duration_s * device.rate_hz));
  result.samples.reserve(num_samples);
  for (std::size_t n = 0; n < num_samples; ++n) {
    const double time_s = static_cast<double>(n) * sample_s;
    late.push_back(model(time_s, Measured(state.place_mm, device.encoder_mm)));
    const Eigen::Vector3d force_n = late.front();
    late.pop_front();
    result.samples.push_back({time_s, state.place_mm, state.velocity_mm_s, force_n});
    for (int i = 1; i <= kStepsPerSample; ++i) {
      const Eigen::Vector3d wanted_mm = hand.wants_in_ct_mm(time_s + i * dt_s);
      const Eigen::Vector3d travel_mm = mass.Step(state, wanted_mm, force_n, dt_s);
      observer.Add(force_n, travel_mm);
    }
  }
  result.generated_mj = observer.generated_mj();
  result.taken_mj = observer.taken_mj();
  return result;
}

double LoopResult::ChatterN(double from_s, double to_s) const {
  if (samples.size() < 2) return 0.0;
  const double sample_s = samples[1].time_s - samples[0].time_s;
  ChatterMeter meter;
  for (const LoopSample& sample : samples) {
    meter.Add(sample_s, sample.force_n, sample.time_s >= from_s && sample.time_s < to_s);
  }
  return meter.RmsN();
}

double LoopResult::SwingMm(double from_s, double to_s) const {
  constexpr double kFar = 1e300;
  Eigen::Array3d low = Eigen::Array3d::Constant(kFar);
  Eigen::Array3d high = -low;
  for (const LoopSample& sample : samples) {
    if (sample.time_s < from_s || sample.time_s >= to_s) continue;
    low = low.min(sample.device_in_ct_mm.array());
    high = high.max(sample.device_in_ct_mm.array());
  }
  return std::max(0.0, (high - low).maxCoeff());
}

std::function<Eigen::Vector3d(double time_s)> RandomMotion(const RandomHand& hand,
                                                           double duration_s, std::uint64_t seed) {
  RandomStream random(seed, "random hand");
  const Eigen::Vector3d axis = hand.axis_in_ct.normalized();
  const Eigen::Vector3d aside = axis.unitOrthogonal();
  const Eigen::Vector3d up = axis.cross(aside);
  std::vector<Move> moves;
  double time_s = 0.0;
  Eigen::Vector3d place_mm = hand.origin_in_ct_mm + hand.from_mm * axis;
  while (time_s < duration_s) {
    Move move{time_s, hand.slowest_s * random.Uniform(0.1, 1.0), place_mm, place_mm};
    const double turn = random.Uniform(0.0, 2.0 * std::numbers::pi);
    const double across_mm = hand.across_mm * std::sqrt(random.Uniform());
    move.to_mm = hand.origin_in_ct_mm + random.Uniform(hand.from_mm, hand.to_mm) * axis +
                 across_mm * (std::cos(turn) * aside + std::sin(turn) * up);
    if (random.Uniform() < 0.15) move.to_mm = hand.origin_in_ct_mm + hand.from_mm * axis;  // Out.
    place_mm = move.to_mm;
    time_s += move.moving_s + random.Uniform(0.0, 0.6);
    moves.push_back(move);
  }
  return [moves, hand, axis, aside, up](double t) {
    const auto after =
        std::upper_bound(moves.begin(), moves.end(), t,
                         [](double value, const Move& m) { return value < m.begin_s; });
    const Move& move = after == moves.begin() ? moves.front() : *(after - 1);
    const double share = MinimumJerk((t - move.begin_s) / move.moving_s);
    const double phase = 2.0 * std::numbers::pi * 9.0 * t;
    const Eigen::Vector3d tremor = std::sin(phase) * axis + std::sin(1.13 * phase + 1.0) * aside +
                                   std::sin(0.91 * phase + 2.0) * up;
    return Eigen::Vector3d(move.from_mm + share * (move.to_mm - move.from_mm) +
                           hand.tremor_mm * tremor);
  };
}

}  // namespace acus::forces
