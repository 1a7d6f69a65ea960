// An example image of a tissue's texture: its greys, how far they hang together, and the same field
// made Gaussian, which is what textures like it are blended in.
// Equations: docs/models/ultrasound_alamilla.md, "Textures from example images".
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/data/image/image.h"

namespace acus::ultrasound {

/// Const after construction. Columns run along the fibres, or along any direction where there are
/// none; rows across.
class TextureExample {
 public:
  /// @param label  Stands for the file in messages.
  /// @throws InputError if it has less than 32 pixels along or across, only one grey, or a pattern
  ///     that hangs together over more than a sixteenth of its length or width.
  TextureExample(const image::GrayImage& image, double mm_per_px, const std::string& label);

  /// Reads an 8-bit PNG. @throws InputError also if it cannot be read or has colours.
  static TextureExample Read(const std::filesystem::path& path, double mm_per_px);

  double mean() const { return mean_; }                     ///< Of the greys, 0 to 1.
  double deviation() const { return deviation_; }           ///< Standard, of the greys.
  double along_mm() const { return along_mm_; }             ///< Correlation falls to 1/e; along.
  double across_mm() const { return across_mm_; }           ///< The same across.
  double length_mm() const { return width_ * mm_per_px_; }  ///< Along.
  double breadth_mm() const { return height_ * mm_per_px_; }
  double mm_per_px() const { return mm_per_px_; }

  /// The field with the distribution of standard normal numbers, bilinear between pixels; beyond
  /// the example it continues as its mirror image, so that no pixel counts more than another.
  float GaussianAt(float along_mm, float across_mm) const noexcept;

  /// The grey, 0 to 1, that as large a share of the example's pixels is below as of standard normal
  /// numbers is below `gaussian`.
  float GreyOf(float gaussian) const noexcept;

 private:
  static constexpr int kSteps = 1024;
  void SetGreys(const image::GrayImage& image, const std::string& label);
  void KeepVariance();

  int width_;
  int height_;
  double mm_per_px_;
  float px_per_mm_;
  double mean_ = 0.0;
  double deviation_ = 0.0;
  double along_mm_ = 0.0;
  double across_mm_ = 0.0;
  std::vector<float> gaussian_;              ///< Row by row.
  std::array<float, kSteps + 2> grey_of_{};  ///< From -kReach to kReach standard deviations.
};

}  // namespace acus::ultrasound
