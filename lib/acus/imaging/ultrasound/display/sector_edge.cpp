#include "acus/imaging/ultrasound/display/sector_edge.h"

namespace acus::ultrasound {

SectorEdge::SectorEdge(int width, int height, const Seen& seen)
    : whole_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0), width_(width) {
  constexpr int kPerSide = 4;
  const auto corners = [&](int row) {
    std::vector<bool> out;
    for (int c = 0; c <= width; ++c) out.push_back(seen(c - 0.5, row - 0.5));
    return out;
  };
  std::vector<bool> upper = corners(0);
  for (int r = 0; r < height; ++r) {
    first_.push_back(cut_.size());
    const std::vector<bool> lower = corners(r + 1);
    for (int c = 0; c < width; ++c) {
      const auto n = static_cast<std::size_t>(c);
      const int number = upper[n] + upper[n + 1] + lower[n] + lower[n + 1];
      if (number == 4) {
        whole_[static_cast<std::size_t>(r) * width + n] = 1;
        continue;
      }
      if (number == 0 && !seen(c, r)) continue;
      int inside = 0;
      for (int i = 0; i < kPerSide; ++i) {
        for (int j = 0; j < kPerSide; ++j) {
          inside += seen(c + (j + 0.5) / kPerSide - 0.5, r + (i + 0.5) / kPerSide - 0.5) ? 1 : 0;
        }
      }
      if (inside > 0) cut_.push_back({c, 256 * inside / (kPerSide * kPerSide)});
    }
    upper = lower;
  }
  first_.push_back(cut_.size());
}

int SectorEdge::Coverage(int row, int column) const {
  if (whole_[static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column)] != 0) {
    return 256;
  }
  for (std::size_t n = first_[static_cast<std::size_t>(row)];
       n < first_[static_cast<std::size_t>(row) + 1]; ++n) {
    if (cut_[n].column == column) return cut_[n].coverage;
  }
  return 0;
}

}  // namespace acus::ultrasound
