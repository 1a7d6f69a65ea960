#include "acus/imaging/ultrasound/beams/scan_end.h"

#include <algorithm>

namespace acus::ultrasound {

using slicing::CtSampler;

void ScanEnds::Find(const slicing::BeamImage& hu) {
  const auto lines = static_cast<std::size_t>(hu.lines());
  ends_.assign(lines, hu.samples());
  bool any = true;
  for (int k = hu.samples() - 1; any && k >= 0; --k) {
    const float* row = hu.row(k);
    any = false;
    for (std::size_t l = 0; l < lines; ++l) {
      const bool outside = ends_[l] == k + 1 && row[l] == CtSampler::kNotScanned;
      ends_[l] -= outside ? 1 : 0;
      any = any || outside;
    }
  }
  earliest_ = ends_.empty() ? 0 : std::ranges::min(ends_);
}

void ScanEnds::FindAndFill(slicing::BeamImage& hu) {
  Find(hu);
  bool entering = true;
  for (int k = 0; k < hu.samples(); ++k) {
    if (!entering && k < earliest_) continue;  // Within the volume: most of the image.
    float* row = hu.row(k);
    const float* above = k > 0 ? hu.row(k - 1) : row;
    bool any = false;
    for (int l = 0; l < hu.lines(); ++l) {
      const bool left = k > 0 && k >= ends_[static_cast<std::size_t>(l)];
      const bool outside = row[l] == CtSampler::kNotScanned;
      row[l] = left ? above[l] : (outside ? CtSampler::kOutsideHu : row[l]);
      any = any || (outside && !left);
    }
    entering = entering && any;
  }
}

}  // namespace acus::ultrasound
