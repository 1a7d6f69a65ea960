// Intensities of beams to an image: gains, compression, edge enhancement, scan conversion.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/display/display_options.h"
#include "acus/imaging/ultrasound/display/edge_enhancement.h"
#include "acus/imaging/ultrasound/display/sector_edge.h"

namespace acus::ultrasound {

/// Grey = 255 (1 + (20 log10(envelope) + gain + TGC depth) / dynamic range), cut off to 0 ... 255,
/// through the curve of the display; pixels are bilinear between samples and lines, after
/// compression and edge enhancement, and black outside. Pixels that the edge of a fan cuts show the
/// part that is seen.
class BeamDisplay {
 public:
  /// @param probe  As ProbeOfLook makes it. Both it and `grid` must outlive this.
  /// @param tgc_limit_db  TGC grows with depth up to this.
  /// @throws InputError if a setting of the display is out of range.
  BeamDisplay(const acoustics::Probe& probe, const acoustics::ScanGrid& grid,
              const DisplayOptions& display = {},
              double tgc_limit_db = std::numeric_limits<double>::infinity());

  /// Compresses rows [first, last) of beams. Independent for different rows.
  void Compress(const slicing::BeamImage& intensity, int first, int last);

  /// Fills `out` with the image. All rows must be compressed. The same bits with any `num_threads`.
  void Show(image::GrayImage& out, int num_threads);

  // Show() by pieces, for several displays that make one image.
  /// Adds edges to the rows, if the display does. All rows must be compressed.
  void Enhance(int num_threads);
  /// Fills rows [first, last) of `out`, which has the image's size. If images of several angles
  /// are averaged, pixels that the edge cuts are left whole: see Blend(), Covers().
  void Convert(int first, int last, image::GrayImage& out) const;
  /// Whether this display has a pixel.
  bool Covers(int row, int column) const;
  /// Darkens the pixels of a row that the edge cuts.
  void Blend(int row, std::uint8_t* pixels) const {
    if (fan_) edge_.Blend(row, pixels);
  }

  const image::ImageGeometry& image() const { return image_; }

 private:
  void MakeLinear();
  void MakeFan(const acoustics::Probe& probe);
  const std::uint8_t* shown() const { return edges_.on() ? enhanced_.data() : grey_.data(); }
  void ConvertLinearRow(int r, std::uint8_t* out) const;
  void ConvertFanRow(int r, std::uint8_t* out) const;

  const acoustics::ScanGrid& grid_;
  image::ImageGeometry image_;
  bool fan_;
  float scale_ = 0.0F;
  std::vector<float> offset_;  ///< Of the grey, by sample.
  bool has_curve_;
  std::array<std::uint8_t, 256> curve_;  ///< By grey of the logarithm.
  EdgeEnhancement edges_;
  bool is_one_of_several_;
  int stride_ = 0;
  std::vector<std::uint8_t> grey_;      ///< stride_ bytes per sample, and two black rows.
  std::vector<std::uint8_t> enhanced_;  ///< The same with edges; empty if they are off.

  struct Span {
    int first = 0;  ///< Columns that are seen, in whole blocks of lanes.
    int last = 0;
  };
  std::vector<Span> seen_;  ///< By row of the image.
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
