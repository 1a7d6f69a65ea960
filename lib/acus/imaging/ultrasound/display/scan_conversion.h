// Grey values of scan lines to an image.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/ultrasound/display/sector_edge.h"

namespace acus::ultrasound {

/// Lines of a linear probe are the image's columns; those of a curved one are interpolated
/// bilinearly in grey. Deterministic with any number of threads.
class ScanConversion {
 public:
  /// Sample rows per piece of parallel work.
  static constexpr int kRowsPerPiece = 64;
  static int Pieces(int rows) { return (rows + kRowsPerPiece - 1) / kRowsPerPiece; }

  ScanConversion(const acoustics::Probe& probe, const acoustics::ScanGrid& grid);

  /// Writes grey[line] of all lines at sample `k`, rounded up to whole blocks of lanes. `piece` is
  /// the same for no two calls at a time: k / kRowsPerPiece.
  using GreyRow = std::function<void(int k, int piece, std::uint8_t* grey)>;

  /// Fills all of `out`. Allocates nothing after the first call.
  void Show(const GreyRow& grey_row, image::GrayImage& out, int num_threads);

  const image::ImageGeometry& image() const { return image_; }

 private:
  void PlacePixels(const acoustics::Probe& probe);
  void ShowLinear(const GreyRow& grey_row, image::GrayImage& out, int num_threads);
  void ShowFan(const GreyRow& grey_row, image::GrayImage& out, int num_threads);

  image::ImageGeometry image_;
  int lines_;
  int samples_;
  double step_mm_;
  bool fan_;
  std::vector<std::uint8_t> grey_;

  // Fan only: where each pixel reads.
  int grey_stride_ = 0;
  image::AlignedFloats across_fraction_;
  image::AlignedFloats along_fraction_;
  image::AlignedFloats offset_storage_;  ///< Holds int32.
  std::int32_t* offset_ = nullptr;
  SectorEdge edge_;
};

}  // namespace acus::ultrasound
