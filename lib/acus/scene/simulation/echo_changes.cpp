#include "acus/scene/simulation/echo_changes.h"

#include <algorithm>
#include <cmath>

namespace acus::simulation {
namespace {

/// A place of the probe's plane along the beam that reaches it.
struct BeamPoint {
  Eigen::Vector2d direction = Eigen::Vector2d::UnitY();
  double depth_mm = 0.0;
  bool in_field = false;
};

BeamPoint BeamTo(const acoustics::Probe& probe, const Eigen::Vector2d& place_mm) noexcept {
  if (probe.kind == acoustics::ProbeKind::kLinear) {
    const bool is_below_face = std::abs(place_mm.x()) <= 0.5 * probe.width_mm;
    return {Eigen::Vector2d::UnitY(), place_mm.y(), is_below_face && place_mm.y() >= 0.0};
  }
  // Beams of a curved face come from its centre, those of a phased one from the middle of the face.
  const double radius_mm = probe.kind == acoustics::ProbeKind::kCurvilinear ? probe.radius_mm : 0.0;
  const Eigen::Vector2d from_centre_mm = place_mm + radius_mm * Eigen::Vector2d::UnitY();
  const double distance_mm = from_centre_mm.norm();
  if (distance_mm <= radius_mm) return {};
  const double angle_rad = std::atan2(from_centre_mm.x(), from_centre_mm.y());
  return {from_centre_mm / distance_mm, distance_mm - radius_mm,
          std::abs(angle_rad) <= 0.5 * probe.field_of_view_rad};
}

}  // namespace

void ChangeEchoes(const Scene& scene, const Snapshot& snapshot, const acoustics::Probe& probe,
                  const image::ImageGeometry& geometry, image::GrayImage& image) noexcept {
  if (snapshot.memory == nullptr || !scene.listed.ChangesEchoNow(*snapshot.memory)) return;
  const Eigen::Affine3d probe_from_image = geometry.probe_from_image();
  const double grey_per_db = 255.0 / probe.dynamic_range_db;
  for (int row = 0; row < geometry.height_px; ++row) {
    for (int column = 0; column < geometry.width_px; ++column) {
      const Eigen::Vector3d in_probe_mm = probe_from_image * Eigen::Vector3d(column, row, 0.0);
      const BeamPoint beam = BeamTo(probe, in_probe_mm.head<2>());
      if (!beam.in_field || beam.depth_mm > probe.depth_mm) continue;
      const effects::EchoPlace place{
          .place_in_ct_mm = snapshot.ct_from_probe * in_probe_mm,
          .beam_in_ct = snapshot.ct_from_probe.linear() *
                        Eigen::Vector3d(beam.direction.x(), beam.direction.y(), 0.0),
          .depth_mm = beam.depth_mm,
          .frequency_mhz = probe.frequency_mhz};
      const double change_db = scene.listed.EchoChangeDb(*snapshot.memory, place);
      if (change_db == 0.0 || std::isnan(change_db)) continue;
      std::uint8_t& pixel =
          image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(geometry.width_px) +
                       static_cast<std::size_t>(column)];
      pixel = static_cast<std::uint8_t>(
          std::clamp(std::round(pixel + grey_per_db * change_db), 0.0, 255.0));
    }
  }
}

}  // namespace acus::simulation
