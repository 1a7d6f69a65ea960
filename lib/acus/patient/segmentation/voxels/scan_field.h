// What a scanner did not see: the padding of its slices, and the circle that it reconstructs.
#pragma once

#include <cstdint>
#include <optional>

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// A circle in the plane of the axial slices.
struct ScanCircle {
  Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();  ///< In-slice index times spacing.
  double radius_mm = 0.0;
};

/// Padding and field of view of a CT. Both are the same in all of its slices.
struct ScanField {
  /// The value of all corners of the slices, if they have one in common, HU.
  std::optional<std::int16_t> padding_hu;
  /// The edge of the reconstructed field, if the padding shows it: because all beyond a circle is
  /// padding, or because tissue ends at a circle without the blur that skin has.
  std::optional<ScanCircle> circle;
};

/// Looks at about 16 slices; the circle is found by random sample consensus, always the same.
ScanField FindScanField(const volume::CtVolume& ct);

/// 1 where the scanner saw nothing: beyond the circle, and padding at its edge. All 0 without a
/// circle.
Mask UnseenBy(const ScanField& field, const volume::CtVolume& ct);

/// The CT with air, -1024 HU, in place of padding that is denser than `body_threshold_hu`, or
/// nothing if there is none. Padding: what has exactly that value and reaches the border of its
/// axial slice.
std::optional<volume::CtVolume> WithoutDensePadding(const volume::CtVolume& ct,
                                                    const ScanField& field,
                                                    double body_threshold_hu, int num_threads);

}  // namespace acus::segmentation
