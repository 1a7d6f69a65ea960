#include "acus/imaging/ultrasound/columns/echo_list.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace acus::ultrasound {

void EchoList::Add(const BeamFilter& filter, double sample, int line, float re, float im) {
  if (echoes_.size() + 2 > echoes_.capacity()) return;
  const int nearest = static_cast<int>(std::lround(sample));
  const BeamFilter::Shares shares = filter.SharesAt(sample - nearest);
  const auto here = static_cast<float>(shares.nearest);
  const auto there = static_cast<float>(shares.neighbour);
  echoes_.push_back({nearest, line, re * here, im * here});
  if (there < 1e-3F) return;
  const int neighbour = sample > nearest ? nearest + 1 : nearest - 1;
  echoes_.push_back({neighbour, line, re * there, im * there});
}

void EchoList::PutInto(const BeamFilter& filter, ComplexBeams& out) const {
  const std::vector<float>& spread = filter.Spread();
  const int half = static_cast<int>(spread.size()) - 1;
  for (const Echo& echo : echoes_) {
    const int low = std::max(0, echo.sample - half);
    const int high = std::min(out.re.samples() - 1, echo.sample + half);
    for (int k = low; k <= high; ++k) {
      const float weight = spread[static_cast<std::size_t>(std::abs(k - echo.sample))];
      out.re.row(k)[echo.line] += echo.re * weight;
      out.im.row(k)[echo.line] += echo.im * weight;
    }
  }
}

}  // namespace acus::ultrasound
