#include "acus/imaging/ultrasound/beams/beam_input.h"

#include <cmath>

#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

template <typename Volume>
void CheckVolume(const Volume& volume, const char* what) {
  const volume::Geometry& geometry = volume.geometry;
  ACUS_REQUIRE((geometry.size > 0).all() && volume.voxels.size() == geometry.num_voxels() &&
                   volume.voxels.size() >= 4,
               what, ": ", geometry.size[0], " x ", geometry.size[1], " x ", geometry.size[2],
               " voxels by its geometry, ", volume.voxels.size(),
               " in memory; give a volume of at least 4 voxels");
  ACUS_REQUIRE(volume.voxels.size() < (std::size_t{1} << 30), what, ": ", volume.voxels.size(),
               " voxels are too many for imaging; the limit is 2^30. Crop or resample it");
  ACUS_REQUIRE((geometry.spacing_mm > 0.0).all() && geometry.index_from_ct().matrix().allFinite(),
               what, ": its spacing or direction cannot be inverted");
}

}  // namespace

const BeamTissue& CheckedBeamTissue(const BeamTissue& tissue, const char* model) {
  ACUS_REQUIRE(tissue.ct != nullptr || tissue.labels != nullptr, model,
               ": there is neither a CT nor a label map to image");
  ACUS_REQUIRE(tissue.acoustics != nullptr, model, ": no table of tissue acoustics is given");
  if (tissue.ct != nullptr) CheckVolume(*tissue.ct, "CT");
  if (tissue.labels != nullptr) CheckVolume(*tissue.labels, "labels");
  if (tissue.ct != nullptr && tissue.labels != nullptr) {
    ACUS_REQUIRE(tissue.ct->geometry.Matches(tissue.labels->geometry), model,
                 ": the CT and the label map have different grids; resample one to the other");
  }
  return tissue;
}

const acoustics::Probe& CheckedBeamProbe(const acoustics::Probe& probe) {
  constexpr int kMost = 4096;
  const bool flat = probe.kind == acoustics::ProbeKind::kLinear;
  ACUS_REQUIRE(probe.scan_lines >= 16 && probe.scan_lines <= kMost &&
                   probe.samples_per_line >= 16 && probe.samples_per_line <= 2 * kMost,
               "probe: ", probe.scan_lines, " lines of ", probe.samples_per_line,
               " samples; allowed is 16 to ", kMost, " lines of 16 to ", 2 * kMost);
  ACUS_REQUIRE(probe.depth_mm >= 1.0 && probe.depth_mm <= 500.0, "probe: depth ", probe.depth_mm,
               " mm; allowed is 1 to 500");
  ACUS_REQUIRE(flat ? probe.width_mm > 0.0 && probe.width_mm < 1000.0
                    : probe.radius_mm >= 0.0 && probe.radius_mm < 1000.0 &&
                          probe.field_of_view_rad > 0.0 && probe.field_of_view_rad < 3.0,
               "probe: width ", probe.width_mm, " mm, radius ", probe.radius_mm,
               " mm, field of view ", probe.field_of_view_rad,
               " rad; give a width (linear), or a radius and an angle of 0 to 3");
  ACUS_REQUIRE(probe.frequency_mhz > 0.0 && probe.frequency_mhz <= 100.0 &&
                   probe.fractional_bandwidth > 0.0 && probe.fractional_bandwidth <= 2.0,
               "probe: ", probe.frequency_mhz, " MHz with a fractional bandwidth of ",
               probe.fractional_bandwidth, "; allowed is above 0 to 100 and above 0 to 2");
  ACUS_REQUIRE(probe.dynamic_range_db > 0.0 && probe.dynamic_range_db <= 200.0 &&
                   std::isfinite(probe.gain_db) && std::isfinite(probe.tgc_db_per_cm),
               "probe: dynamic range ", probe.dynamic_range_db,
               " dB; allowed is above 0 to 200, with finite gains");
  ACUS_REQUIRE(probe.image_width_px >= 16 && probe.image_width_px <= kMost &&
                   probe.image_height_px >= 16 && probe.image_height_px <= kMost,
               "probe: image of ", probe.image_width_px, " x ", probe.image_height_px,
               " pixels; allowed is 16 to ", kMost, " each way");
  return probe;
}

}  // namespace acus::ultrasound
