#include "acus/imaging/volume_rendering/maximum_projection.h"

#include "acus/base/core/error.h"

namespace acus::volume_rendering {

TransferFunction ShownIn(const HuWindow& window) {
  constexpr double kLowest = TransferFunction::kLowestHu;
  constexpr double kHighest = kLowest + TransferFunction::kCount - 1;
  ACUS_REQUIRE(
      window.low_hu >= kLowest && window.high_hu <= kHighest && window.low_hu < window.high_hu,
      "view: a window from ", window.low_hu, " to ", window.high_hu,
      " HU; the low end must be below the high end, and both within ", kLowest, " to ", kHighest,
      " HU");
  const Eigen::Array3f white = Eigen::Array3f::Ones();
  return TransferFunction({{window.low_hu - 1.0, 0.0, white}, {window.high_hu, 1.0, white}});
}

}  // namespace acus::volume_rendering
