#include "acus/patient/breathing_registration/patient_tissue.h"

#include "acus/patient/phantom/anatomy/cavity.h"

namespace acus::breathing_registration {

Tissue TissueOf(const volume::CtVolume& ct, const std::filesystem::path& labels, bool sliding,
                RunContext& context) {
  const auto map =
      std::make_shared<const volume::LabelMap>(segmentation::TissuesOf(ct, labels, context));
  Tissue tissue;
  const Eigen::Affine3d index_from_ct = map->geometry.index_from_ct();
  tissue.is_tissue = [map, index_from_ct](const Eigen::Vector3d& p) {
    const Eigen::Array3i n = (index_from_ct * p).array().round().cast<int>();
    return map->geometry.Contains(n[0], n[1], n[2]) && map->At(n[0], n[1], n[2]) != 0;
  };
  if (!sliding) return tissue;
  try {
    const auto cavity = std::make_shared<const phantom::Cavity>(phantom::FindCavity(*map, context));
    tissue.wall_mm = [cavity](const Eigen::Vector3d& p) { return cavity->wall.LevelMm(p); };
  } catch (const InputError& error) {
    throw InputError(
        Message(error.what(),
                ". Without it nothing can slide: give labels with --labels, or register "
                "with --no-sliding"));
  }
  return tissue;
}

}  // namespace acus::breathing_registration
