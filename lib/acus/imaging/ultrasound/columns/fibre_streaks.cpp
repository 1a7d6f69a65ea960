#include "acus/imaging/ultrasound/columns/fibre_streaks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::ultrasound {

// With between and sheet, the mean in dB is 0: of muscle across its fibres (measured over 13
// million places), of fat at any angle.
const FibreStreaks::Law FibreStreaks::kMuscle{.across_mm = 2.0,
                                              .along_mm = 25.0,
                                              .fibre_nepers = 2.0 * std::numbers::ln10,
                                              .half_thickness = 0.05,
                                              .between = 0.06584,
                                              .sheet = 65.84,
                                              .lobe_deg = 15.0,
                                              .diffuse_share = 0.1};
const FibreStreaks::Law FibreStreaks::kFat{.across_mm = 6.0,
                                           .along_mm = 6.0,
                                           .fibre_nepers = 0.0,
                                           .half_thickness = 0.03,
                                           .between = 0.532,
                                           .sheet = 53.2,
                                           .lobe_deg = 20.0,
                                           .diffuse_share = 0.1};

const FibreStreaks::Law FibreStreaks::kSoft{.across_mm = 3.0,
                                            .along_mm = 15.0,
                                            .fibre_nepers = 0.0,
                                            .half_thickness = 0.05,
                                            .between = 0.332,
                                            .sheet = 33.2,
                                            .lobe_deg = 15.0,
                                            .diffuse_share = 0.1};

double FibreIntensity(double cosine) {
  return std::pow(10.0, -2.0 * cosine * cosine);
}

FibreStreaks::FibreStreaks(const BeamTissue& tissue, std::uint64_t seed)
    : seed_(static_cast<std::uint32_t>(seed * 0x9E3779B97F4A7C15ULL >> 32)),
      size_(tissue.labels->geometry.size),
      spacing_mm_(tissue.labels->geometry.spacing_mm) {
  const volume::LabelMap& labels = *tissue.labels;
  std::array<std::uint8_t, 256> code_of{};
  for (const auto& [label, name] : labels.names) {
    const auto found = tissue.fibres_in_ct.find(name);
    if (sheets_.size() == 255) break;
    if (found != tissue.fibres_in_ct.end()) {
      Add(kMuscle, (labels.geometry.direction.transpose() * found->second).normalized());
    } else if (name == "fat") {
      Add(kFat, Eigen::Vector3d::UnitX());
    } else if (name == "soft_tissue") {
      // Head to foot, as most muscles of the trunk.
      Add(kSoft, labels.geometry.direction.transpose() * Eigen::Vector3d::UnitZ());
    } else {
      continue;
    }
    code_of[label] = static_cast<std::uint8_t>(sheets_.size());
  }
  if (sheets_.empty()) return;
  ACUS_REQUIRE(labels.voxels.size() < (std::size_t{1} << 31), "fibres: the label map has ",
               labels.voxels.size(), " voxels; allowed are less than 2^31");
  codes_.assign(labels.voxels.size() / 4 + 1, 0);
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    codes_[n / 4] |= std::uint32_t{code_of[labels.voxels[n]]} << 8 * (n % 4);
  }
}

void FibreStreaks::Add(const Law& law, const Eigen::Vector3d& along_in_voxels) {
  const Eigen::Vector3d first = along_in_voxels.unitOrthogonal();
  Eigen::Matrix3d cells;
  cells.row(0) = first.transpose() / law.across_mm;
  cells.row(1) = along_in_voxels.cross(first).transpose() / law.across_mm;
  cells.row(2) = along_in_voxels.transpose() / law.along_mm;
  const double width = std::tan(law.lobe_deg * std::numbers::pi / 180.0);
  kernels::SheetRow row{};
  using ByRow = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
  Eigen::Map<ByRow>(row.cells) = (cells * spacing_mm_.matrix().asDiagonal()).eval().cast<float>();
  Eigen::Map<ByRow>(row.normals) = cells.transpose().eval().cast<float>();
  Eigen::Map<Eigen::Vector3f>(row.along) = along_in_voxels.cast<float>();
  Eigen::Map<Eigen::Array3f>(row.spacing_mm) = spacing_mm_.cast<float>();
  row.seed = seed_;
  row.fibre_nepers = static_cast<float>(law.fibre_nepers);
  row.per_thickness = static_cast<float>(1.0 / law.half_thickness);
  row.between = static_cast<float>(law.between);
  row.sheet = static_cast<float>(law.sheet);
  row.per_lobe = static_cast<float>(0.5 / (width * width));
  row.diffuse_share = static_cast<float>(law.diffuse_share);
  row.code = static_cast<float>(sheets_.size() + 1);
  sheets_.push_back(row);
}

void FibreStreaks::ApplyRow(const slicing::kernels::Lines& lines, float s, int lanes,
                            float* intensity) const {
  alignas(64) std::array<float, kMostLanes> which;
  const int whole = slicing::kernels::RoundUp(lanes);
  const kernels::CodedVoxels voxels{
      .words = codes_.data(),
      .size = {static_cast<float>(size_[0]), static_cast<float>(size_[1]),
               static_cast<float>(size_[2])},
      .row_voxels = size_[0],
      .slice_voxels = size_[0] * size_[1]};
  if (!kernels::CodeRow(voxels, lines, s, whole, which.data())) return;
  for (std::size_t n = 0; n < sheets_.size(); ++n) {
    kernels::SheetRow row = sheets_[n];
    row.lines = lines;
    row.s = s;
    row.which = which.data();
    kernels::SheetIntensityRow(row, whole, intensity);
  }
}

}  // namespace acus::ultrasound
