// Echoes of single reflectors on their way into the complex beams.
#pragma once

#include <vector>

#include "acus/imaging/ultrasound/beams/beam_filter.h"

namespace acus::ultrasound {

/// Holds a fixed number of echoes; more are dropped, so that nothing is allocated after Reserve().
class EchoList {
 public:
  void Reserve(std::size_t count) { echoes_.reserve(count); }
  void Clear() { echoes_.clear(); }

  /// An echo of line `line` at a sample number that need not be whole: shared by two samples, so
  /// that its peak on the grid is the amplitude wherever it lies.
  void Add(const BeamFilter& filter, double sample, int line, float re, float im = 0.0F);

  /// Adds all echoes to `out`, each spread along the beam as speckle is by its grain.
  void PutInto(const BeamFilter& filter, ComplexBeams& out) const;

 private:
  struct Echo {
    int sample;
    int line;
    float re;
    float im;
  };
  std::vector<Echo> echoes_;
};

}  // namespace acus::ultrasound
