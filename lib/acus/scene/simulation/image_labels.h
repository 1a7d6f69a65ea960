// Ground truth of an ultrasound image: the tissue in each pixel, and needle and target in the
// image.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/slicing/label_slice.h"
#include "acus/scene/simulation/moment_rest.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/snapshot.h"

namespace acus::simulation {

/// Values of a label image that are no tissue. Tissues keep the numbers of the label map.
inline constexpr std::uint8_t kTargetInImage = 250;
inline constexpr std::uint8_t kShaftInImage = 251;
inline constexpr std::uint8_t kTipInImage = 252;
inline constexpr std::uint8_t kBeyondImage = 255;  ///< Outside the field of view: to be ignored.

struct ImageLabelSettings {
  std::optional<Eigen::Vector3d> target_ct_mm = std::nullopt;  ///< Position in the tissue at rest.
  double target_radius_mm = 3.0;                               ///< > 0
  double tip_radius_mm = 1.5;  ///< Radius of the disc around the tip, in the image plane; > 0.
};

/// Ground truth of one image.
struct ImageTruth {
  image::GrayImage labels;  ///< Tissue, or one of the values above; later ones cover earlier ones.
  /// Column and row in pixels (integers at pixel centres), and distance from the plane, positive
  /// along the probe's z, mm. Also for a tip outside the image. Nothing without a needle.
  std::optional<Eigen::Vector3d> tip_in_image;
  /// The same for the deformed target; nothing without one, or if its position was not found.
  std::optional<Eigen::Vector3d> target_in_image;
  double inserted_mm = 0.0;  ///< Length of the shaft in the body, to 1 mm.
  /// Share of that length within half the slice thickness of the plane and in the field of view;
  /// nothing if the length is 0. Geometry alone: shadows and gain have no influence.
  std::optional<double> visible_share;
};

/// Computes label images of a scene. Holds buffers: one for each thread.
class ImageLabeller {
 public:
  /// @param scene  Has a probe; must outlive this. @param labels  Tissues at rest.
  /// @throws InputError if there are no labels, one of them is 250 or above, or a radius is not
  ///     above 0.
  ImageLabeller(const Scene& scene, std::shared_ptr<const volume::LabelMap> labels,
                const ImageLabelSettings& settings);

  /// The same bits for the same snapshot, whatever was labelled before. If the tracker does not see
  /// the probe, all pixels are kBeyondImage.
  void Label(const Snapshot& snapshot, ImageTruth& out);

  const image::ImageGeometry& image() const { return image_; }
  /// Distance of each pixel from the probe's face, mm, row by row; NaN outside the field of view.
  const std::vector<float>& depth_mm() const { return depth_mm_; }

 private:
  void PaintNeedle(const Snapshot& snapshot, const image::NeedleInImage& needle, ImageTruth& out);
  void MeasureNeedle(const Snapshot& snapshot, const image::NeedleInImage& needle,
                     const slicing::RestMap* rest, ImageTruth& out) const;

  const Scene& scene_;
  std::shared_ptr<const volume::LabelMap> labels_;
  ImageLabelSettings settings_;
  image::ImageGeometry image_;
  acoustics::ScanGrid grid_;
  MomentRest rest_;
  slicing::LabelSlice slice_;
  slicing::BeamImage needle_;  ///< Not 0 where the needle is.
  std::vector<float> depth_mm_;
};

}  // namespace acus::simulation
