// Where lines leave the volume that was scanned. Nothing is known of the patient beyond: no
// interface is drawn there, and no echo.
#pragma once

#include <vector>

#include "acus/imaging/slicing/ct_sampler.h"

namespace acus::ultrasound {

/// The last scanned sample of each line.
class ScanEnds {
 public:
  /// Finds the ends in samples whose value is CtSampler::kNotScanned where they lie outside the
  /// volume, and fills those: with air where the line has not entered the volume, with the last
  /// value where it has left it. Allocates only if there are more lines than before.
  void FindAndFill(slicing::BeamImage& hu);

  /// The first sample at which a line has left the volume.
  int earliest() const { return earliest_; }

  /// Sets row `k` to zero where lines have left the volume.
  template <typename Value>
  void Clear(int k, Value* row) const {
    if (k < earliest_) return;
    const int lines = static_cast<int>(ends_.size());
    for (int l = 0; l < lines; ++l) {
      row[l] = k < ends_[static_cast<std::size_t>(l)] ? row[l] : Value{0};
    }
  }

 private:
  void Find(const slicing::BeamImage& hu);

  std::vector<int> ends_;  ///< By line: samples up to the last scanned one.
  int earliest_ = 0;
};

}  // namespace acus::ultrasound
