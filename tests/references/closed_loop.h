// A force model in the loop with a haptic device and a hand, and an account of its energy: does it
// chatter, does it drive the hand? For tests and comparisons, not for a step.
//
// The device is a mass with damping, driven by the hand (spring and damper to where it wants to be)
// and by the model's force, which is held between samples and comes late; the model sees positions
// in steps of the encoder. docs/models/forces_stability.md.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace acus::forces {

struct HapticDevice {
  double mass_kg = 0.1;
  double damping_n_s_per_m = 0.5;
  double dry_friction_n = 0.0;  ///< Of the device itself; 0.04 to 0.3 N in those on the market.
  double encoder_mm = 0.02;     ///< 0: exact.
  double rate_hz = 1000.0;
  int delay_steps = 1;  ///< From the sample to its force: 1 is the force of the sample before.
};

struct Hand {
  double stiffness_n_per_m = 400.0;
  double damping_n_s_per_m = 4.0;
  std::function<Eigen::Vector3d(double time_s)> wants_in_ct_mm;
};

/// The model: a measured position to a force on the device. Called once per sample.
using ForceOfPlace =
    std::function<Eigen::Vector3d(double time_s, const Eigen::Vector3d& measured_in_ct_mm)>;

/// Energy that went into the model, from the device's true motion and the force that acted on it.
/// Passive means that it never gives back more than it took since it was last free (force zero).
class PassivityObserver {
 public:
  /// @param travel_mm  while `force_n` acted.
  void Add(const Eigen::Vector3d& force_n, const Eigen::Vector3d& travel_mm) noexcept;

  /// Largest energy given beyond what was taken, of all stretches between free moments, mJ.
  double generated_mj() const { return generated_mj_; }
  /// All that was taken less all that was given, mJ.
  double taken_mj() const { return total_mj_; }

 private:
  double balance_mj_ = 0.0;  ///< Since the last free moment.
  double generated_mj_ = 0.0;
  double total_mj_ = 0.0;
};

struct LoopSample {
  double time_s = 0.0;
  Eigen::Vector3d device_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mm_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< On the device in this step.
};

struct LoopResult {
  std::vector<LoopSample> samples;  ///< One per sample of the device.
  double generated_mj = 0.0;        ///< By PassivityObserver.
  double taken_mj = 0.0;

  /// As ChatterMeter, over [from_s, to_s).
  double ChatterN(double from_s, double to_s) const;
  /// Largest extent of the device's motion along any axis over [from_s, to_s), mm.
  double SwingMm(double from_s, double to_s) const;
};

/// Integrates with 20 steps per sample, damping implicitly. Deterministic.
/// @throws InputError if mass, rate or duration are not positive or the hand wants nothing.
LoopResult RunClosedLoop(const HapticDevice& device, const Hand& hand, const ForceOfPlace& model,
                         double duration_s);

/// A hand that goes to random places along an axis and across it, stays there for a while, and
/// trembles: minimum-jerk moves. Deterministic by seed.
struct RandomHand {
  Eigen::Vector3d origin_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();
  double from_mm = -5.0;  ///< Along the axis.
  double to_mm = 40.0;
  double across_mm = 2.0;  ///< Largest distance from the axis.
  double tremor_mm = 0.1;  ///< Amplitude, at 9 Hz.
  double slowest_s = 1.5;  ///< Duration of a move; the fastest takes a tenth.
};
std::function<Eigen::Vector3d(double time_s)> RandomMotion(const RandomHand& hand,
                                                           double duration_s, std::uint64_t seed);

}  // namespace acus::forces
