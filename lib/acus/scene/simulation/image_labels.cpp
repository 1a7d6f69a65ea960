#include "acus/scene/simulation/image_labels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/data/volume/label_lookup.h"
#include "acus/imaging/acoustics/field_of_view.h"
#include "acus/imaging/slicing/needle_paint.h"
#include "acus/scene/simulation/probe_image_renderer.h"

namespace acus::simulation {
namespace {

constexpr double kShaftStepMm = 1.0;

const volume::LabelMap& CheckedLabels(const Scene& scene,
                                      const std::shared_ptr<const volume::LabelMap>& labels) {
  const bool images =
      scene.plan.Writes(effects::ports::kBMode) || scene.plan.Writes(effects::ports::kCtImage);
  ACUS_REQUIRE(images && scene.probe.has_value(),
               "labels of images: no effect of this scenario makes an image of the probe; call for "
               "ultrasound or ct_slice");
  ACUS_REQUIRE(labels != nullptr,
               "labels of images: the patient has no label map; give /patient/labels, such as "
               "labels.seg.nrrd of acus-segment");
  const auto largest = std::ranges::max_element(labels->voxels);
  ACUS_REQUIRE(largest == labels->voxels.end() || *largest < kTargetInImage,
               "labels of images: the label map has label ", int{*largest}, "; from ",
               int{kTargetInImage},
               " on, numbers stand for target, needle and what is beside the image; give the "
               "tissue a lower number");
  return *labels;
}

std::vector<float> DepthsOf(const acoustics::Probe& probe, const image::ImageGeometry& image) {
  const Eigen::Affine3d probe_from_image = image.probe_from_image();
  std::vector<float> depth_mm;
  depth_mm.reserve(static_cast<std::size_t>(image.width_px) *
                   static_cast<std::size_t>(image.height_px));
  for (int r = 0; r < image.height_px; ++r) {
    for (int c = 0; c < image.width_px; ++c) {
      const Eigen::Vector3d place_mm = probe_from_image * Eigen::Vector3d(c, r, 0.0);
      const bool seen = acoustics::IsInFieldOfView(probe, place_mm.head<2>());
      depth_mm.push_back(
          seen ? static_cast<float>(acoustics::DepthBelowFaceMm(probe, place_mm.head<2>()))
               : std::numeric_limits<float>::quiet_NaN());
    }
  }
  return depth_mm;
}

/// Column, row, and distance from the plane in mm.
Eigen::Vector3d InImage(const image::ImageGeometry& image, const Eigen::Isometry3d& ct_from_probe,
                        const Eigen::Vector3d& place_ct_mm) {
  const Eigen::Vector3d in_probe_mm = ct_from_probe.inverse() * place_ct_mm;
  Eigen::Vector3d in_image = image.probe_from_image().inverse() * in_probe_mm;
  in_image.z() = in_probe_mm.z();
  return in_image;
}

/// The deformed position of tissue, given at rest: the rest map, inverted by fixed-point steps.
/// Nothing if these do not converge to 0.1 mm.
std::optional<Eigen::Vector3d> NowFromRest(const slicing::RestMap* rest,
                                           const Eigen::Vector3d& rest_ct_mm) {
  if (rest == nullptr) return rest_ct_mm;
  constexpr int kMostSteps = 60;
  constexpr double kCloseMm = 0.005;
  constexpr double kFoundMm = 0.1;
  Eigen::Vector3d now_mm = rest_ct_mm;
  double off_mm = 0.0;
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::Vector3d off = rest_ct_mm - rest->RestInCtMm(now_mm, rest_ct_mm);
    off_mm = off.norm();
    if (!(off_mm > kCloseMm)) break;
    now_mm += off;
  }
  if (!(off_mm <= kFoundMm)) return std::nullopt;
  return now_mm;
}

/// Calls `visit` with points of the needle from the tip to the hub: the centres of pieces of length
/// kShaftStepMm.
template <typename Visit>
void AlongNeedle(const image::NeedleInImage& needle, const Visit& visit) {
  if (needle.shape.num_points < 2) {
    for (double s = 0.5 * kShaftStepMm; s < needle.length_mm; s += kShaftStepMm) {
      visit(Eigen::Vector3d(needle.tip_in_ct_mm - s * needle.axis_in_ct));
    }
    return;
  }
  double next_mm = 0.5 * kShaftStepMm;  // From the start of the piece.
  for (int i = 1; i < needle.shape.num_points; ++i) {
    const Eigen::Vector3d from_mm = needle.shape.At(i - 1);
    const Eigen::Vector3d step_mm = needle.shape.At(i) - from_mm;
    const double length_mm = step_mm.norm();
    for (; next_mm < length_mm; next_mm += kShaftStepMm) {
      visit(Eigen::Vector3d(from_mm + next_mm / length_mm * step_mm));
    }
    next_mm -= length_mm;
  }
}

Eigen::Vector3d TipOf(const image::NeedleInImage& needle) {
  return needle.shape.num_points >= 2 ? needle.shape.At(0) : needle.tip_in_ct_mm;
}

}  // namespace

ImageLabeller::ImageLabeller(const Scene& scene, std::shared_ptr<const volume::LabelMap> labels,
                             const ImageLabelSettings& settings)
    : scene_(scene),
      labels_(std::move(labels)),
      settings_(settings),
      image_((CheckedLabels(scene, labels_), acoustics::ImageOf(*scene.probe))),
      grid_(acoustics::ScanGridOf(image_)),
      rest_(scene),
      slice_(*labels_, image_),
      depth_mm_(DepthsOf(*scene.probe, image_)) {
  ACUS_REQUIRE(settings.target_radius_mm > 0.0 && settings.tip_radius_mm > 0.0,
               "labels of images: radius of the target ", settings.target_radius_mm,
               " mm, of the tip ", settings.tip_radius_mm, " mm; both must be above 0");
}

void ImageLabeller::PaintNeedle(const Snapshot& snapshot, const image::NeedleInImage& needle,
                                ImageTruth& out) {
  needle_.Resize(image_.width_px, image_.height_px);
  for (int r = 0; r < image_.height_px; ++r) {
    std::fill_n(needle_.row(r), image_.width_px, 0.0F);
  }
  slicing::PaintNeedle(needle, snapshot.ct_from_probe, scene_.probe->slice_thickness_mm, grid_,
                       needle_);
  const Eigen::Vector3d tip = InImage(image_, snapshot.ct_from_probe, TipOf(needle));
  out.tip_in_image = tip;
  const bool tip_in_slice =
      std::abs(tip.z()) <= 0.5 * scene_.probe->slice_thickness_mm + needle.radius_mm;
  const double coarsest_mm = std::max(image_.lateral_mm_per_px, image_.axial_mm_per_px);
  const double tip_reach_mm = std::max(settings_.tip_radius_mm, coarsest_mm);
  for (int r = 0; r < image_.height_px; ++r) {
    for (int c = 0; c < image_.width_px; ++c) {
      auto& label =
          out.labels
              .pixels[static_cast<std::size_t>(r) * static_cast<std::size_t>(image_.width_px) +
                      static_cast<std::size_t>(c)];
      if (needle_.row(r)[c] != 0.0F) label = kShaftInImage;
      const double off_mm = std::hypot((c - tip.x()) * image_.lateral_mm_per_px,
                                       (r - tip.y()) * image_.axial_mm_per_px);
      if (tip_in_slice && off_mm <= tip_reach_mm) label = kTipInImage;
    }
  }
}

void ImageLabeller::MeasureNeedle(const Snapshot& snapshot, const image::NeedleInImage& needle,
                                  const slicing::RestMap* rest, ImageTruth& out) const {
  const Eigen::Isometry3d probe_from_ct = snapshot.ct_from_probe.inverse();
  const Eigen::Affine3d index_from_ct = labels_->geometry.index_from_ct();
  const double half_slice_mm = 0.5 * scene_.probe->slice_thickness_mm + needle.radius_mm;
  int inserted = 0;
  int visible = 0;
  AlongNeedle(needle, [&](const Eigen::Vector3d& place_mm) {
    const Eigen::Vector3d rest_mm =
        rest == nullptr ? place_mm : rest->RestInCtMm(place_mm, place_mm);
    if (volume::LabelAt(*labels_, index_from_ct, rest_mm) == 0) return;
    ++inserted;
    const Eigen::Vector3d in_probe_mm = probe_from_ct * place_mm;
    if (std::abs(in_probe_mm.z()) > half_slice_mm) return;
    if (acoustics::IsInFieldOfView(*scene_.probe, in_probe_mm.head<2>())) ++visible;
  });
  out.inserted_mm = inserted * kShaftStepMm;
  if (inserted > 0) out.visible_share = static_cast<double>(visible) / inserted;
}

void ImageLabeller::Label(const Snapshot& snapshot, ImageTruth& out) {
  out.tip_in_image.reset();
  out.target_in_image.reset();
  out.visible_share.reset();
  out.inserted_mm = 0.0;
  out.labels.Resize(image_.width_px, image_.height_px);
  if (!snapshot.probe_valid) {
    std::ranges::fill(out.labels.pixels, kBeyondImage);
    return;
  }
  const slicing::RestMap* rest = rest_.At(snapshot);
  slice_.Render(snapshot.ct_from_probe, rest, out.labels);
  if (settings_.target_ct_mm) {
    slice_.MarkSphere(*settings_.target_ct_mm, settings_.target_radius_mm, kTargetInImage,
                      out.labels);
    if (const auto now_mm = NowFromRest(rest, *settings_.target_ct_mm)) {
      out.target_in_image = InImage(image_, snapshot.ct_from_probe, *now_mm);
    }
  }
  if (const auto needle = scene_.needle ? ImagedNeedle(scene_, snapshot) : std::nullopt) {
    PaintNeedle(snapshot, *needle, out);
    MeasureNeedle(snapshot, *needle, rest, out);
  }
  for (std::size_t pixel = 0; pixel < depth_mm_.size(); ++pixel) {
    if (std::isnan(depth_mm_[pixel])) out.labels.pixels[pixel] = kBeyondImage;
  }
}

}  // namespace acus::simulation
