// Images for people: depth scale, marks, text, B-mode and CT slice side by side.
#pragma once

#include <Eigen/Geometry>
#include <string_view>
#include <utility>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"

namespace acus::ultrasound {

/// Writes text into an image, its upper left corner at (column, row). What is not inside the
/// image is omitted. Letters are about 10 pixels high times `scale`.
void DrawText(image::GrayImage& image, int column, int row, std::string_view text,
              std::uint8_t grey = 230, double scale = 1.0);

/// Where the CT ends, in the probe's frame.
struct ScanExtent {
  Eigen::Affine3d index_from_probe;  ///< Voxels: the CT reaches from -0.5 to size - 0.5.
  Eigen::Array3i size;
};

/// Lays out the frame that videos and stills show. Nothing is written on the images: marks and text
/// lie in strips beside them. Marks are drawn once, so that a frame costs two copies.
class Screen {
 public:
  enum class Shows { kBMode, kCtSlice, kBoth };

  /// Strips around each panel's image, pixels.
  static constexpr int kScalePx = 44;  ///< Left of it: the depth scale.
  static constexpr int kTextPx = 22;   ///< Above all panels, and below.

  /// The B-mode is on the left of the two; they have the same scale. Beside each image a depth
  /// scale: ticks each 5 mm (10 mm for depths above 100 mm), labelled each second one in cm, and
  /// with a B-mode a triangle at the focus. Above it its name and a ring on the marked side; below
  /// the probe's name and depth, with a B-mode also frequency, gain and dynamic range. Rows below
  /// the probe's depth are omitted, so that the sector fills the frame.
  Screen(const acoustics::Probe& probe, Shows shows);

  /// @param left  The B-mode, or the CT slice alone.
  /// @param ct_slice  Beside a B-mode: must be given if and only if the screen shows both.
  /// @param text  One line above the images, such as the time and the force.
  /// @param scan  If given, what lies beyond the CT is hatched: in the sector of a B-mode, and in
  ///     the whole of a slice.
  /// @throws InputError if an image has another size than the probe's.
  void Compose(const image::GrayImage& left, const image::GrayImage* ct_slice,
               std::string_view text, image::GrayImage& out,
               const ScanExtent* scan = nullptr) const;

  int width_px() const { return panels() * (kScalePx + image_.width_px); }
  int height_px() const { return kTextPx + rows_ + kTextPx; }

 private:
  /// Columns of one row of a panel, first to before last.
  struct Span {
    int first = 0;
    int last = 0;
  };
  void FindSector(const acoustics::Probe& probe);
  void DrawMarks(const acoustics::Probe& probe);
  void DrawScale(const acoustics::Probe& probe, int left, bool focus,
                 image::GrayImage& marks) const;
  void CopyPanel(const image::GrayImage& from, int panel, image::GrayImage& to) const;
  void Hatch(const ScanExtent& scan, int panel, image::GrayImage& out) const;
  Span InScan(const ScanExtent& scan, int row) const;
  int panels() const { return shows_ == Shows::kBoth ? 2 : 1; }
  int LeftOf(int panel) const { return panel * (kScalePx + image_.width_px) + kScalePx; }
  bool IsBMode(int panel) const { return panel == 0 && shows_ != Shows::kCtSlice; }

  image::ImageGeometry image_;
  Shows shows_;
  int rows_ = 0;                                             ///< Of an image that are shown.
  std::vector<Span> sector_;                                 ///< By row.
  std::vector<std::pair<std::size_t, std::uint8_t>> marks_;  ///< Pixel of the screen, grey.
};

}  // namespace acus::ultrasound
