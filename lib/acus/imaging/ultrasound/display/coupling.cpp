#include "acus/imaging/ultrasound/display/coupling.h"

#include <algorithm>
#include <cmath>

namespace acus::ultrasound {

void FillCouplingGap(double gap_mm, double step_mm, slicing::BeamImage& hu) {
  // The CT blurs the skin over this.
  constexpr double kSkinBlurMm = 2.0;
  const int blur_samples = static_cast<int>(kSkinBlurMm / step_mm);
  const int gap_samples = static_cast<int>(std::floor(gap_mm / step_mm + 1e-9));
  const int reach = std::min(gap_samples, hu.samples() - 1);
  for (int l = 0; l < hu.lines(); ++l) {
    int k = 0;
    while (k < reach && hu.row(k)[l] < kAirBelowHu) ++k;
    if (hu.row(k)[l] < kAirBelowHu) continue;
    // With gel on it, there is no slope from air up to skin.
    const int end = std::min(k + blur_samples, hu.samples() - 1);
    while (k < end && hu.row(k + 1)[l] > hu.row(k)[l]) ++k;
    const float skin = hu.row(k)[l];
    for (int above = 0; above < k; ++above) hu.row(above)[l] = skin;
  }
}

}  // namespace acus::ultrasound
