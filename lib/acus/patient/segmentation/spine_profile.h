// What lies beside the spinal canal, height by height: pedicles, the wings of the sacrum, the
// ilium.
#pragma once

#include <optional>
#include <vector>

#include "acus/patient/segmentation/spine/disc_planes.h"

namespace acus::segmentation {

/// Shares of bone, 0 to 1, in regions on both sides of the canal: that of the side with less.
/// Negative where the CT does not show the whole region.
struct BesideCanal {
  double pedicle = 0.0;  ///< Between canal and body, where the foramina are open at the discs.
  double wing = 0.0;     ///< Beside the body: psoas at lumbar heights, the wings of the sacrum.
  double ilium = 0.0;    ///< Behind and beside that.
};

/// What lies beside a canal at each step of its line, and straight on below the line's lower end.
class SpineProfile {
 public:
  SpineProfile(const CanalLine& line, const volume::LabelMap& tissues);

  /// @param step  Of the line; down to -kBelowSteps. Beyond both ends nothing is seen.
  BesideCanal At(int step) const;

  static constexpr int kBelowSteps = 30;

 private:
  std::vector<BesideCanal> at_;  ///< From -kBelowSteps.
};

/// Whether the foramina beside the canal are open at a disc, as they are at lumbar ones. At
/// thoracic discs the heads of ribs close them.
bool IsOpenAt(const SpineProfile& profile, const DiscPlane& disc);

/// Drops discs that part one vertebra in two, as the middle of a body does in thick slices: those
/// between pedicles, if the foramina at the discs next to them are open.
/// @param discs  From the feet to the head. @returns how many were dropped.
int DropDiscsWithinVertebrae(const SpineProfile& profile, std::vector<DiscPlane>& discs);

/// The place in `discs` (from the feet) of the disc that lies on the sacrum: the uppermost that
/// leans forward, with bone (the wings of the sacrum, and the ilium beside them) on both sides
/// below it. None if the CT does not show both wings.
std::optional<std::size_t> DiscOnSacrum(const SpineProfile& profile, const CanalLine& line,
                                        const std::vector<DiscPlane>& discs);

}  // namespace acus::segmentation
