#include "acus/run/live/start_on_skin.h"

#include "acus/run/training/situation.h"

namespace acus::live {

Eigen::Isometry3d OnSkin(const Eigen::Isometry3d& reference_from_probe,
                         const training::LabelAtPoint& label_at) {
  constexpr double kPressMm = 1.0;
  const auto gap_mm = training::GapToSkinMm(transforms::Pose(reference_from_probe), label_at);
  if (!gap_mm || *gap_mm <= 0.0) return reference_from_probe;
  return reference_from_probe * Eigen::Translation3d(0.0, *gap_mm + kPressMm, 0.0);
}

}  // namespace acus::live
