#include "acus/imaging/ultrasound/columns/fibre_streaks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/imaging/ultrasound/beams/beam_interface.h"
#include "acus/imaging/ultrasound/speckle/place_hash.h"

namespace acus::ultrasound {
namespace {

constexpr double kFascicleMm = 2.0;
constexpr double kFascicleLengthMm = 25.0;
/// Half thickness of a sheet, in units of the noise, and how it mirrors.
constexpr float kThickness = 0.05F;
constexpr double kLobeDeg = 15.0;
constexpr double kDiffuseShare = 0.1;
/// Intensity between sheets, and what a sheet that faces the beam adds: with them the mean in dB
/// across the fibres is 0 (measured over 13 million places).
constexpr float kBetween = 0.06584F;
constexpr float kSheet = 1000.0F * kBetween;

float UniformAt(int x, int y, int z, std::uint32_t seed) {
  return static_cast<float>(HashOfPlace(x, y, z, seed) >> 8) * (1.0F / 16777216.0F);
}

}  // namespace

double FibreIntensity(double cosine) {
  return std::pow(10.0, -2.0 * cosine * cosine);
}

FibreStreaks::FibreStreaks(const BeamTissue& tissue, std::uint64_t seed)
    : seed_(static_cast<std::uint32_t>(seed * 0x9E3779B97F4A7C15ULL >> 32)),
      size_(tissue.labels->geometry.size),
      spacing_mm_(tissue.labels->geometry.spacing_mm.cast<float>()) {
  const volume::LabelMap& labels = *tissue.labels;
  std::array<std::uint8_t, 256> code_of{};
  for (const auto& [label, name] : labels.names) {
    const auto found = tissue.fibres_in_ct.find(name);
    if (found == tissue.fibres_in_ct.end() || fibres_.size() == 255) continue;
    const Eigen::Vector3d along =
        (labels.geometry.direction.transpose() * found->second).normalized();
    const Eigen::Vector3d first = along.unitOrthogonal();
    Eigen::Matrix3d cells;
    cells.row(0) = first.transpose() / kFascicleMm;
    cells.row(1) = along.cross(first).transpose() / kFascicleMm;
    cells.row(2) = along.transpose() / kFascicleLengthMm;
    const Eigen::Matrix3d from_index = cells * labels.geometry.spacing_mm.matrix().asDiagonal();
    fibres_.push_back({from_index.cast<float>(), along.cast<float>()});
    code_of[label] = static_cast<std::uint8_t>(fibres_.size());
  }
  if (fibres_.empty()) return;
  code_.reserve(labels.voxels.size());
  for (const volume::Label label : labels.voxels) code_.push_back(code_of[label]);
}

FibreStreaks::Sheet FibreStreaks::SheetAt(const Eigen::Vector3f& cell) const {
  const Eigen::Array3f low = cell.array().floor();
  const Eigen::Array3f part = cell.array() - low;
  const Eigen::Array3f share = part * part * (3.0F - 2.0F * part);
  const Eigen::Array3f share_slope = 6.0F * part * (1.0F - part);
  const Eigen::Array3i at = low.cast<int>();
  Sheet sheet{.noise = 0.0F, .slope = Eigen::Vector3f::Zero()};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3i up(corner & 1, corner >> 1 & 1, corner >> 2);
    const float random = UniformAt(at[0] + up[0], at[1] + up[1], at[2] + up[2], seed_);
    const auto is_up = up.cast<float>();
    const Eigen::Array3f weight = is_up * share + (1.0F - is_up) * (1.0F - share);
    const Eigen::Array3f rise = (2.0F * is_up - 1.0F) * share_slope;
    sheet.noise += random * weight.prod();
    sheet.slope +=
        random * Eigen::Vector3f(rise[0] * weight[1] * weight[2], weight[0] * rise[1] * weight[2],
                                 weight[0] * weight[1] * rise[2]);
  }
  return sheet;
}

void FibreStreaks::ApplyRow(const slicing::kernels::Lines& lines, float s, int lanes,
                            float* intensity) const {
  for (int l = 0; l < lanes; ++l) {
    Eigen::Vector3f index;
    Eigen::Vector3f step;
    for (int a = 0; a < 3; ++a) {
      step[a] = lines.step[a][l];
      index[a] = lines.start[a][l] + s * step[a];
    }
    const Eigen::Array3f nearest = (index.array() + 0.5F).floor();
    if ((nearest < 0.0F).any() || (nearest >= size_.cast<float>()).any()) continue;
    const Eigen::Array3i voxel = nearest.cast<int>();
    const auto at = (static_cast<std::size_t>(voxel[2]) * static_cast<std::size_t>(size_[1]) +
                     static_cast<std::size_t>(voxel[1])) *
                        static_cast<std::size_t>(size_[0]) +
                    static_cast<std::size_t>(voxel[0]);
    if (code_[at] == 0) continue;
    const Fibre& fibre = fibres_[code_[at] - 1U];
    const Eigen::Vector3f beam = (step.array() * spacing_mm_).matrix().normalized();
    const float cosine = beam.dot(fibre.along);
    const auto across = static_cast<float>(FibreIntensity(double{cosine}));
    const Sheet sheet = SheetAt(fibre.cells_from_index * index);
    // Sheets lie where the noise passes its middle, across its slope.
    const float off = (sheet.noise - 0.5F) * (1.0F / kThickness);
    const Eigen::Vector3f normal =
        (fibre.cells_from_index.transpose() * sheet.slope).array() / spacing_mm_;
    const double facing =
        double{std::abs(beam.dot(normal))} / std::max(1e-9, double{normal.norm()});
    const auto lobe =
        static_cast<float>(MirrorLobe(std::min(1.0, facing), kLobeDeg, kDiffuseShare));
    // They mirror: they fade as the square of what single fibres send back.
    intensity[l] *= across * (kBetween + across * kSheet * lobe / (1.0F + off * off));
  }
}

}  // namespace acus::ultrasound
