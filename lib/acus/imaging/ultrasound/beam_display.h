// Intensities of beams to a picture: gains, logarithmic compression, scan conversion.
#pragma once

#include <cstdint>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/sector_edge.h"

namespace acus::ultrasound {

/// Grey = 255 (1 + (20 log10(envelope) + gain + TGC depth) / dynamic range), cut off to 0 ... 255;
/// pixels are bilinear between samples and lines, after compression, and black outside. Pixels that
/// the edge of a fan cuts show the part that is seen.
class BeamDisplay {
 public:
  BeamDisplay(const acoustics::Probe& probe, const acoustics::ScanGrid& grid);

  /// Compresses rows [first, last). Independent for different rows.
  void Compress(const slicing::BeamImage& intensity, int first, int last);

  /// Fills rows [first, last) of `out`, which has the picture's size. All rows must be compressed.
  void Convert(int first, int last, image::GrayImage& out) const;

  const image::ImageGeometry& picture() const { return picture_; }

 private:
  void MakeLinear();
  void MakeFan(const acoustics::Probe& probe);
  void ConvertLinearRow(int r, std::uint8_t* out) const;
  void ConvertFanRow(int r, std::uint8_t* out) const;

  const acoustics::ScanGrid& grid_;
  image::ImageGeometry picture_;
  bool fan_;
  float scale_ = 0.0F;
  std::vector<float> offset_;  ///< Of the grey, by sample.
  int stride_ = 0;
  std::vector<std::uint8_t> grey_;  ///< stride_ bytes per sample, and two black rows.

  struct Span {
    int first = 0;  ///< Columns that are seen, in whole blocks of lanes.
    int last = 0;
  };
  std::vector<Span> seen_;  ///< By row of the picture.
  // Linear: by column, and by row.
  image::AlignedFloats column_fraction_;
  std::vector<std::int32_t> column_;
  std::vector<std::int32_t> sample_;
  std::vector<float> sample_fraction_;
  // Fan: by pixel.
  std::vector<std::int32_t> at_;
  std::vector<std::uint16_t> fractions_;
  SectorEdge edge_;
};

}  // namespace acus::ultrasound
