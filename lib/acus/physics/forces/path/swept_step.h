// Nothing is stepped over: the tip's way between two samples is searched for tissue, and a model
// takes it in as many steps as there are things to meet on it.
//
// docs/models/needle_forces.md, "Between two samples".
#pragma once

#include <array>

#include "acus/physics/forces/laws/tissue_lookup.h"
#include "acus/physics/forces/path/needle_sample.h"

namespace acus::forces {

/// What happened to the needle on its way through one step.
struct PassedEvent {
  NeedleEvent event = NeedleEvent::kNone;
  volume::Label tissue = 0;     ///< At the tip.
  double depth_mm = 0.0;        ///< Of the tip along its path.
  double force_axial_n = 0.0;   ///< Then: after a puncture, when the force has fallen.
  double force_before_n = 0.0;  ///< Just before: at a puncture, what it took.
};

/// All of one step, in order. Plain memory; those beyond the capacity are only counted.
struct PassedEvents {
  static constexpr int kMost = 32;
  std::array<PassedEvent, kMost> event{};
  int num = 0;
  int num_beyond = 0;

  void Clear() noexcept { num = num_beyond = 0; }
  void Add(const PassedEvent& passed) noexcept {
    if (num == kMost) {
      ++num_beyond;
    } else {
      event[static_cast<std::size_t>(num++)] = passed;
    }
  }
};

/// Where a sweep looks for tissue.
struct SweptTissue {
  const TissueLookup* lookup = nullptr;  ///< Null: nothing is swept. Not owned.
  /// From the input's tip to where the tip is, as that of a bent needle.
  Eigen::Vector3d tip_offset_mm = Eigen::Vector3d::Zero();
};

/// Bounds of the search.
struct SweepLimits {
  /// A sample that moves the tip no farther than this is one step, with the bits of the model's
  /// Step; on longer ways each event is found as closely.
  static constexpr double kResolvedMm = 0.02;
  /// Half a voxel apart, or more on ways of over so many halves.
  static constexpr int kMostLooks = 256;
  /// The same where a look is an interpolation of the CT and its gradient.
  static constexpr int kMostLooksAtHu = 96;
  /// Layers thinner than this take more steps than thick ones.
  static constexpr double kThinMm = 2.0;
  /// A tip that jumps farther was not followed by its tracker: one step.
  static constexpr double kFarthestMm = 100.0;
  /// Steps of the model in one sample. What is met after them is met in one step, as without a
  /// sweep.
  static constexpr int kMostModelSteps = 128;
};

}  // namespace acus::forces
