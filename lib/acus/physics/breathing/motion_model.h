// How breath moves the patient: the models of Fortmeier-2016, section 3.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "acus/physics/breathing/breath.h"
#include "acus/physics/breathing/motion_field.h"

namespace acus::breathing {

enum class MotionKind {
  kSinusoid,   ///< One field, swung by the level: no hysteresis, no recorded shape of the cycle.
  kFullCycle,  ///< Key frames along the whole cycle, eq. 9: hysteresis, but no deeper breath.
  kHalfCycle,  ///< Key frames from inspiration to expiration, eq. 9, and eq. 10 beyond them.
  kSurrogate,  ///< Linear in the signal and its derivative, eq. 11-13: both.
};
std::string_view NameOf(MotionKind kind);
/// @throws InputError if no model has that name.
MotionKind MotionKindOf(std::string_view name);

/// One displacement field at a known moment of breath.
struct KeyFrame {
  static constexpr int kReference = -1;
  double at = 0.0;             ///< Cycle in [0, 1), or level: whichever the model goes by.
  int component = kReference;  ///< kReference: nothing moves in the reference image itself.
};

/// u(X, t) of a patient. A value; const access from any number of threads.
class MotionModel {
 public:
  /// kSinusoid: displacement is component 0 times (reference_level - level).
  static MotionModel Sinusoid(MotionField field, double reference_level);
  /// @param frames  In order of `at`; kFullCycle: in [0, 1), the cycle closes from the last to the
  ///     first; kHalfCycle: levels, at least two, falling or rising.
  /// @throws InputError if they are too few, not in order, or name components that are not there.
  static MotionModel FullCycle(MotionField field, std::vector<KeyFrame> frames);
  static MotionModel HalfCycle(MotionField field, std::vector<KeyFrame> frames);
  /// Components 0, 1, 2 are a1, a2, a3 of eq. 13.
  static MotionModel Surrogate(MotionField field);

  /// Eq. 9, 10, 13 for a moment, once for all places. `amplitude` scales the motion: 0 holds the
  /// patient in the reference state. Not finite: the reference state.
  MotionWeights WeightsAt(const Breath& breath, double amplitude = 1.0) const noexcept;

  MotionKind kind() const { return kind_; }
  const MotionField& field() const { return field_; }
  std::span<const KeyFrame> frames() const { return frames_; }
  double reference_level() const { return reference_level_; }

 private:
  MotionModel(MotionKind kind, MotionField field) : kind_(kind), field_(std::move(field)) {}
  void AddFrame(const KeyFrame& frame, double share, MotionWeights& out) const noexcept;
  void BetweenFrames(double at, double amplitude, MotionWeights& out) const noexcept;

  MotionKind kind_ = MotionKind::kSinusoid;
  MotionField field_;
  std::vector<KeyFrame> frames_;
  double reference_level_ = 1.0;
};

}  // namespace acus::breathing
