#include "acus/run/launcher/patient_image.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/data/volume/volume_io.h"

namespace acus::launcher {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastMm = 120.0;
constexpr double kBlackHu = -160.0;
constexpr double kWhiteHu = 340.0;
constexpr double kRingMm = 4.0;

/// Nearest voxel; air outside the CT.
double HuAt(const volume::CtVolume& ct, const Eigen::Vector3d& index) {
  const Eigen::Array3i voxel = index.array().round().cast<int>();
  if (!ct.geometry.Contains(voxel[0], voxel[1], voxel[2])) return kBlackHu;
  return ct.At(voxel[0], voxel[1], voxel[2]);
}

Eigen::Vector3d PointOf(const transforms::Landmarks& points, const char* name) {
  const auto found = std::ranges::find(points.names, name);
  ACUS_REQUIRE(found != points.names.end(), points.source, ": has no point \"", name, '"');
  return points.points_mm.col(found - points.names.begin());
}

}  // namespace

image::ColourImage PathImage(const volume::CtVolume& ct, const Eigen::Vector3d& entry_in_ct_mm,
                             const Eigen::Vector3d& target_in_ct_mm, int side_px) {
  const Eigen::Vector3d path = target_in_ct_mm - entry_in_ct_mm;
  const double length_mm = path.norm();
  ACUS_REQUIRE(length_mm > 1e-3, "entry and target are the same point");
  const Eigen::Vector3d down = path / length_mm;
  // Beside the path: along the patient where the path is across it, so that the slice is axial.
  const Eigen::Vector3d aside = (std::abs(down.z()) < 0.9 ? down.cross(Eigen::Vector3d::UnitZ())
                                                          : down.cross(Eigen::Vector3d::UnitX()))
                                    .normalized();
  const double mm_per_px = std::max(kLeastMm, 1.25 * length_mm) / side_px;
  const Eigen::Vector3d middle = entry_in_ct_mm + 0.55 * path;
  const Eigen::Affine3d index_from_ct = ct.geometry.index_from_ct();
  image::ColourImage slice;
  slice.Resize(side_px, side_px);
  for (int row = 0; row < side_px; ++row) {
    for (int column = 0; column < side_px; ++column) {
      const double right_mm = mm_per_px * (column - 0.5 * (side_px - 1));
      const double down_mm = mm_per_px * (row - 0.5 * (side_px - 1));
      const Eigen::Vector3d at = middle + right_mm * aside + down_mm * down;
      const double grey = (HuAt(ct, index_from_ct * at) - kBlackHu) / (kWhiteHu - kBlackHu);
      Eigen::Array3d colour = Eigen::Array3d::Constant(std::clamp(grey, 0.0, 1.0));
      const double from_entry_mm = (at - entry_in_ct_mm).dot(down);
      const double from_target_mm = (at - target_in_ct_mm).norm();
      if (std::abs(from_target_mm - kRingMm) < mm_per_px) {
        colour = {0.98, 0.82, 0.31};
      } else if (std::abs(right_mm) < 0.6 * mm_per_px && from_entry_mm < length_mm - kRingMm) {
        colour = {0.47, 0.84, 0.89};
      }
      for (int k = 0; k < 3; ++k) {
        slice.rgb[static_cast<std::size_t>(3 * (row * side_px + column) + k)] =
            static_cast<std::uint8_t>(std::lround(255.0 * colour[k]));
      }
    }
  }
  return slice;
}

image::ColourImage ImageOf(const fs::path& workplace, int side_px, const RunContext& context) {
  const nlohmann::json scenario = config::ReadJson(workplace / "scenario.json");
  const auto patient = scenario.value("patient", nlohmann::json::object());
  const std::string ct = patient.value("ct", "");
  const std::string path = patient.value("corridor", "");
  ACUS_REQUIRE(!ct.empty() && !path.empty(), (workplace / "scenario.json").string(),
               ": /patient names no ct or no corridor");
  const auto points = transforms::ReadLandmarks(workplace / path);
  return PathImage(volume::ReadCt(workplace / ct, patient.value("dicom_series", ""), context),
                   PointOf(points, "entry"), PointOf(points, "target"), side_px);
}

}  // namespace acus::launcher
