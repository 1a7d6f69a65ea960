#include "acus/patient/segmentation/segmenters/organ_vessels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/text_table.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/voxels/crop.h"
#include "acus/patient/segmentation/voxels/line_filter.h"

namespace acus::segmentation {
namespace {

constexpr std::array kVesselRadiiMm = {1.4, 2.0, 2.8, 4.0, 5.6};
constexpr double kLeastSigmaVoxels = 0.6;  ///< Thinner lines are lost between the slices.
constexpr float kCertainLine = 5.0F;       ///< Standard deviations of the response to noise.
constexpr double kEdgeMm = 2.0;            ///< At the surface of the organ no line is certain.
constexpr double kWiderVessels = 0.75;     ///< Quantile of the HU on lines: thin ones are blurred.
constexpr float kHalf = 0.5F;              ///< The edge of a wide vessel.
constexpr float kThinPart = 0.35F;         ///< Of the contrast, on a certain line.
constexpr double kBlurMm = 0.8;
constexpr double kBlurVoxels = 0.5;
constexpr double kSurroundingsMm = 12.0;
constexpr float kLeastWeight = 1e-3F;
constexpr double kLeastPartMl = 0.1;
constexpr double kLeastLineMl = 0.003;  ///< Certain line in each part.
constexpr double kLeastBrightMl = 0.5;  ///< Of certain lines.
constexpr double kMostDark = 0.4;       ///< Of what is bright.
constexpr double kMostOfOrgan = 0.15;   ///< Vessels of a liver are 3 to 8 % of it.
constexpr double kDarkPartMm = 4.0;     ///< Blur; also the distance to be kept.
constexpr double kEnclosedMm = 7.0;     ///< Between parts of the liver.
constexpr int kMarginVoxels = 2;

double Ml(const Mask& mask) {
  return static_cast<double>(Count(mask)) * mask.geometry.voxel_volume_mm3() / 1000.0;
}

/// A lower quantile of values; reorders them. @pre not empty.
float QuantileOf(std::vector<float>& values, double fraction) {
  const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[static_cast<std::size_t>(at)];
}

std::vector<float> ValuesIn(const volume::Grid<float>& image, const Mask& mask) {
  std::vector<float> values;
  for (std::size_t n = 0; n < mask.voxels.size(); ++n) {
    if (mask.voxels[n] != 0) values.push_back(image.voxels[n]);
  }
  return values;
}

/// Where lines are certain: away from the surface, and from cysts and tumours, whose edges have
/// dark lines. A dark vessel is too thin to be excluded.
Mask WithoutDarkParts(const volume::Grid<float>& image, Mask inner, double noise_hu,
                      int num_threads) {
  const volume::Grid<float> blurred = Blurred(image, kDarkPartMm, num_threads);
  Mask dark(image.geometry);
  for (std::size_t n = 0; n < dark.voxels.size(); ++n) {
    dark.voxels[n] = static_cast<double>(blurred.voxels[n]) < -noise_hu ? 1 : 0;
  }
  dark = Dilated(dark, kDarkPartMm, num_threads);
  for (std::size_t n = 0; n < inner.voxels.size(); ++n) {
    if (dark.voxels[n] != 0) inner.voxels[n] = 0;
  }
  return inner;
}

/// Bright and dark lines, in standard deviations of the response to noise.
struct Lines {
  volume::Grid<float> bright, dark;
};

/// Standard deviation of responses that are symmetric about 0, from the weaker dark ones: bright
/// lines do not count, and few dark ones do not matter.
float SpreadOfDark(const volume::Grid<float>& response, const Mask& inner) {
  std::vector<float> dark;
  for (std::size_t n = 0; n < inner.voxels.size(); ++n) {
    if (inner.voxels[n] != 0 && response.voxels[n] < 0.0F) dark.push_back(-response.voxels[n]);
  }
  return dark.empty() ? 0.0F : 1.4826F * QuantileOf(dark, 0.5);
}

/// None where voxels are too far apart for any of the radii.
Lines LinesIn(const volume::Grid<float>& image, const Mask& organ, const Mask& inner,
              int num_threads) {
  Lines lines{volume::Grid<float>(image.geometry), volume::Grid<float>(image.geometry)};
  for (const double radius_mm : kVesselRadiiMm) {
    const double sigma_mm = radius_mm / std::sqrt(2.0);
    if (sigma_mm < kLeastSigmaVoxels * image.geometry.spacing_mm.maxCoeff()) continue;
    const volume::Grid<float> response = LineResponse(image, organ, sigma_mm, num_threads);
    const float spread = SpreadOfDark(response, inner);
    if (spread <= 0.0F) continue;
    for (std::size_t n = 0; n < response.voxels.size(); ++n) {
      const float ratio = response.voxels[n] / spread;
      lines.bright.voxels[n] = std::max(lines.bright.voxels[n], ratio);
      lines.dark.voxels[n] = std::max(lines.dark.voxels[n], -ratio);
    }
  }
  return lines;
}

/// Lines that noise does not make, away from the surface of the organ.
Mask CertainOf(const volume::Grid<float>& line, const Mask& inner) {
  Mask certain(line.geometry);
  for (std::size_t n = 0; n < certain.voxels.size(); ++n) {
    certain.voxels[n] = inner.voxels[n] != 0 && line.voxels[n] > kCertainLine ? 1 : 0;
  }
  return certain;
}

/// The image less the organ around each voxel: contrast agent does not reach all parts alike.
volume::Grid<float> AboveSurroundings(const volume::Grid<float>& image, const Mask& organ,
                                      const Mask& lines, int num_threads) {
  volume::Grid<float> sum(image.geometry), weight(image.geometry);
  for (std::size_t n = 0; n < sum.voxels.size(); ++n) {
    if (organ.voxels[n] == 0 || lines.voxels[n] != 0) continue;
    sum.voxels[n] = image.voxels[n];
    weight.voxels[n] = 1.0F;
  }
  sum = Blurred(sum, kSurroundingsMm, num_threads);
  weight = Blurred(weight, kSurroundingsMm, num_threads);
  volume::Grid<float> out(image.geometry);
  for (std::size_t n = 0; n < out.voxels.size(); ++n) {
    if (organ.voxels[n] == 0 || weight.voxels[n] < kLeastWeight) continue;
    // Never below 0: vessels in a tumour are no brighter for it.
    const float around = std::max(sum.voxels[n] / weight.voxels[n], 0.0F);
    out.voxels[n] = image.voxels[n] - around;
  }
  return out;
}

/// Vessels brighter than the organ, and how much brighter the wider ones are.
struct BrightVessels {
  Mask mask;
  float contrast_hu = 0.0F;
};

/// @param line  How certain each voxel is on a line. @param blurred  HU above the organ.
/// @param certain  Where it is certain.
BrightVessels VesselsOn(const volume::Grid<float>& line, const volume::Grid<float>& blurred,
                        const Mask& organ, const Mask& certain) {
  BrightVessels out{.mask = Mask(organ.geometry)};
  std::vector<float> hu = ValuesIn(blurred, certain);
  if (hu.empty()) return out;
  out.contrast_hu = QuantileOf(hu, kWiderVessels);
  for (std::size_t n = 0; n < out.mask.voxels.size(); ++n) {
    const float part = line.voxels[n] > kCertainLine ? kThinPart : kHalf;
    const bool is_bright = blurred.voxels[n] > part * out.contrast_hu;
    out.mask.voxels[n] = organ.voxels[n] != 0 && is_bright ? 1 : 0;
  }
  const Components parts = ConnectedComponents(out.mask);
  std::vector<std::size_t> on_line(parts.num_voxels.size(), 0);
  for (std::size_t n = 0; n < certain.voxels.size(); ++n) {
    if (certain.voxels[n] != 0) ++on_line[static_cast<std::size_t>(parts.number.voxels[n])];
  }
  const double ml = organ.geometry.voxel_volume_mm3() / 1000.0;
  out.mask = Kept(parts, [&](std::int32_t number) {
    const auto at = static_cast<std::size_t>(number);
    return static_cast<double>(parts.num_voxels[at]) * ml > kLeastPartMl &&
           static_cast<double>(on_line[at]) * ml > kLeastLineMl;
  });
  return out;
}

/// Why there are no vessels; empty if there are.
std::string ReasonAgainst(const OrganVessels& found, double organ_ml) {
  const std::string volumes = Message(FixedText(found.bright_ml, 1), " ml of bright lines, ",
                                      FixedText(found.dark_ml, 1), " ml of dark ones");
  if (found.bright_ml < kLeastBrightMl) {
    return Message("no lines are brighter than the organ (", volumes,
                   "): a scan without contrast agent, or vessels as dense as the organ");
  }
  if (found.dark_ml > kMostDark * found.bright_ml) {
    return Message("dark lines are almost as frequent as bright ones (", volumes,
                   "), as from noise or in a scan without contrast agent");
  }
  if (found.vessel_ml > kMostOfOrgan * organ_ml) {
    return Message(FixedText(100.0 * found.vessel_ml / organ_ml, 0),
                   " % of the organ would be vessel; at most ", FixedText(100.0 * kMostOfOrgan, 0),
                   " % are possible: the organ is unevenly bright, or its label covers others");
  }
  return {};
}

/// The liver with its vessels, and soft tissue between its parts: bright vessels that whoever
/// labelled the liver did not count. Without lesions.
Mask LiverWithVessels(const volume::LabelMap& labels, int num_threads) {
  const volume::Label liver = volume::LabelOf("liver"), soft = volume::LabelOf("soft_tissue"),
                      vessel = volume::LabelOf("vessel");
  Mask region = MaskOf(labels, liver);
  Box box = BoundsOf(region);
  if (box.empty()) return region;
  const Eigen::Array3i margin = (kEnclosedMm / region.geometry.spacing_mm).ceil().cast<int>() + 1;
  box.low = (box.low - margin).max(0);
  box.high = (box.high + margin).min(region.geometry.size - 1);
  Mask closed(region.geometry);
  Paste(Closed(Cropped(region, box), kEnclosedMm, num_threads), box, closed);
  for (std::size_t n = 0; n < region.voxels.size(); ++n) {
    const volume::Label here = labels.voxels[n];
    if (closed.voxels[n] != 0 && (here == soft || here == vessel)) region.voxels[n] = 1;
  }
  return region;
}

}  // namespace

OrganVessels FindVesselsIn(const volume::CtVolume& whole_ct, const Mask& whole_organ,
                           int num_threads) {
  ACUS_REQUIRE(whole_organ.geometry.Matches(whole_ct.geometry),
               "vessels: the organ lies on another grid than the CT");
  OrganVessels found{.vessels = Mask(whole_ct.geometry), .reason = {}};
  Box box = BoundsOf(whole_organ);
  if (box.empty()) {
    found.reason = "the organ is empty";
    return found;
  }
  box.low = (box.low - kMarginVoxels).max(0);
  box.high = (box.high + kMarginVoxels).min(whole_ct.geometry.size - 1);
  const volume::CtVolume ct = Cropped(whole_ct, box);
  const Mask organ = Cropped(whole_organ, box);
  volume::Grid<float> image(ct.geometry);
  std::ranges::copy(ct.voxels, image.voxels.begin());
  std::vector<float> hu = ValuesIn(image, organ);
  const float median = QuantileOf(hu, 0.5);
  found.organ_hu = median;
  found.noise_hu = (median - QuantileOf(hu, 0.1587));  // Below: vessels are above.
  // What surrounds the organ is as dense as it: its surface is no edge.
  for (std::size_t n = 0; n < image.voxels.size(); ++n) {
    image.voxels[n] = organ.voxels[n] != 0 ? image.voxels[n] - median : 0.0F;
  }
  const Mask inner =
      WithoutDarkParts(image, Eroded(organ, kEdgeMm, num_threads), found.noise_hu, num_threads);
  const Lines lines = LinesIn(image, organ, inner, num_threads);
  const double blur_mm = std::max(kBlurMm, kBlurVoxels * ct.geometry.spacing_mm.maxCoeff());
  const Mask certain = CertainOf(lines.bright, inner);
  const volume::Grid<float> above = AboveSurroundings(image, organ, certain, num_threads);
  const BrightVessels bright =
      VesselsOn(lines.bright, Blurred(above, blur_mm, num_threads), organ, certain);
  found.vessel_hu = found.organ_hu + static_cast<double>(bright.contrast_hu);
  found.vessel_ml = Ml(bright.mask);
  found.bright_ml = Ml(certain);
  found.dark_ml = Ml(CertainOf(lines.dark, inner));
  found.reason = ReasonAgainst(found, Ml(organ));
  found.is_found = found.reason.empty();
  if (found.is_found) Paste(bright.mask, box, found.vessels);
  return found;
}

std::string AddLiverVessels(const volume::CtVolume& ct, volume::LabelMap& labels,
                            const RunContext& context) {
  context.Checkpoint("finding vessels of the liver", 0.0);
  ACUS_REQUIRE(std::ranges::find(labels.voxels, volume::LabelOf("liver")) != labels.voxels.end(),
               "--vessels: the labels have no liver; find it by --atlas, --import or a seed");
  const OrganVessels found =
      FindVesselsIn(ct, LiverWithVessels(labels, context.num_threads), context.num_threads);
  if (!found.is_found) {
    context.Warn(Message("vessels of the liver: none found: ", found.reason));
    return "Vessels of the liver: none.\n";
  }
  const volume::Label vessel = volume::LabelOf("vessel");
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    if (found.vessels.voxels[n] != 0) labels.voxels[n] = vessel;
  }
  labels.names[vessel] = "vessel";
  return Message("Vessels of the liver: ", FixedText(found.vessel_ml, 1), " ml at about ",
                 FixedText(found.vessel_hu, 0), " HU; liver ", FixedText(found.organ_hu, 0),
                 " HU, noise ", FixedText(found.noise_hu, 0), " HU.\n");
}

}  // namespace acus::segmentation
