// The smooth edge of a sector: pixels that it cuts are as bright as the part that is seen.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace acus::ultrasound {

class SectorEdge {
 public:
  /// Whether a place of the image is seen; column and row in pixels, whole at pixel centres.
  using Seen = std::function<bool(double column, double row)>;

  /// Goes through all pixels of an image once.
  SectorEdge() = default;
  SectorEdge(int width, int height, const Seen& seen);

  /// Part of a pixel that is seen, in 256ths.
  int Coverage(int row, int column) const;

  /// Darkens the pixels of a row that the edge cuts.
  void Blend(int row, std::uint8_t* pixels) const {
    for (std::size_t n = first_[static_cast<std::size_t>(row)];
         n < first_[static_cast<std::size_t>(row) + 1]; ++n) {
      std::uint8_t& pixel = pixels[cut_[n].column];
      pixel = static_cast<std::uint8_t>((pixel * cut_[n].coverage + 128) >> 8);
    }
  }

 private:
  struct Cut {
    std::int32_t column;
    std::int32_t coverage;
  };
  std::vector<Cut> cut_;
  std::vector<std::size_t> first_;   ///< Of each row, and the end.
  std::vector<std::uint8_t> whole_;  ///< 1 where all of a pixel is seen, by pixel.
  int width_ = 0;
};

}  // namespace acus::ultrasound
