// Files of many images of one size with their label images: PNG, NIfTI or HDF5.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/run/replay/frame_table.h"
#include "acus/run/replay/label_format.h"

namespace acus::replay {

/// Data that all images of a stack share.
struct StackGeometry {
  image::ImageGeometry image;
  std::vector<float> depth_mm;  ///< By pixel; NaN outside the field of view.
};

/// Writes into an existing folder, one image after the other; the same images give the same bytes.
class ImageStack {
 public:
  virtual ~ImageStack() = default;
  /// @throws InputError if a file cannot be written.
  virtual void Append(const image::GrayImage& image, const image::GrayImage& labels) = 0;
  /// After the last image. @throws InputError as Append.
  virtual void Finish(const FrameTable& table) = 0;
  /// File name patterns of image, labels and depth, for training code.
  virtual std::map<std::string, std::string> Files() const = 0;
};

/// @throws InputError if a file cannot be created. @pre format is not kNone.
std::unique_ptr<ImageStack> MakeImageStack(LabelFormat format, const std::filesystem::path& folder,
                                           const StackGeometry& geometry);

/// The implementation of MakeImageStack for HDF5.
std::unique_ptr<ImageStack> MakeHdf5Stack(const std::filesystem::path& folder,
                                          const StackGeometry& geometry);

}  // namespace acus::replay
