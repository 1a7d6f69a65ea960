// Persistence: the mean of the last frames on a scanner's screen.
#pragma once

#include <cstdint>
#include <vector>

#include "acus/data/image/image.h"

namespace acus::ultrasound {

/// The recursive filter y += (1 - exp(-dt / tau)) (x - y) on every pixel, dt the time between the
/// frames: a step of brightness is passed by 63 % after tau, at any frame rate. With frames of
/// independent noise, dt apart, the standard deviation falls by sqrt(tanh(dt / (2 tau))).
class FramePersistence {
 public:
  /// @throws InputError if the time constant is negative or not finite.
  explicit FramePersistence(double time_constant_s);

  bool on() const { return time_constant_s_ > 0.0; }

  /// The mean so far takes in `frame`, and is written to `out` (not `frame`). The first frame, one
  /// of another size, and one that is not after the last start again. Allocates only if frames
  /// grow.
  void Add(std::int64_t time_ns, const image::GrayImage& frame, image::GrayImage& out);

  /// The next frame starts a new average.
  void Reset() { mean_.clear(); }

 private:
  double time_constant_s_;
  std::int64_t last_ns_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<float> mean_;  ///< Greys by pixel; empty: there is none.
};

}  // namespace acus::ultrasound
