#include "acus/imaging/ultrasound/beams/speed_volume.h"

#include <algorithm>
#include <cmath>

#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/speckle/binomial_window.h"

namespace acus::ultrasound {
namespace {

/// Slower than any liquid: gas.
constexpr double kGasSpeedMPerS = 1000.0;
/// Codes below this one are bone's, coarser than those of soft tissue.
constexpr int kBoneCodes = 48;
constexpr double kLowestIndex = 0.32;
constexpr double kSoftIndex = 0.80;
constexpr double kBoneUnit = (kSoftIndex - kLowestIndex) / kBoneCodes;
constexpr double kSoftUnit = (1.0 - kSoftIndex) / 128;  // 1 has a code; up to 1.12.

std::uint8_t CodeOfIndex(double index) {
  const double code = index < kSoftIndex ? (index - kLowestIndex) / kBoneUnit
                                         : kBoneCodes + (index - kSoftIndex) / kSoftUnit;
  return static_cast<std::uint8_t>(std::clamp(std::lround(code), 0L, 255L));
}

std::uint8_t CodeOfSpeed(double speed_m_per_s) {
  return CodeOfIndex(
      speed_m_per_s < kGasSpeedMPerS ? 1.0 : acoustics::kScannerSpeedMPerS / speed_m_per_s);
}

}  // namespace

SpeedVolume::SpeedVolume(const BeamTissue& tissue, const BeamMaterials& materials) {
  for (int code = 0; code < 256; ++code) {
    const double index = code < kBoneCodes ? kLowestIndex + code * kBoneUnit
                                           : kSoftIndex + (code - kBoneCodes) * kSoftUnit;
    index_of_code_[static_cast<std::size_t>(code)] = static_cast<float>(index);
  }
  size_ = (tissue.labels != nullptr ? tissue.labels->geometry : tissue.ct->geometry).size;
  std::array<std::uint8_t, 256> of_label{};
  for (int label = 0; label < 256; ++label) {
    of_label[static_cast<std::size_t>(label)] = CodeOfSpeed(materials.SpeedAtLabel(label));
  }
  constexpr int kLowestHu = -1024;
  std::vector<std::uint8_t> of_hu;
  for (int hu = kLowestHu; hu < 3072; ++hu) of_hu.push_back(CodeOfSpeed(materials.SpeedAtHu(hu)));
  const auto code_at = [&](std::size_t n) {
    const int label = tissue.labels != nullptr ? tissue.labels->voxels[n] : 0;
    if (label != 0 || tissue.ct == nullptr) return of_label[static_cast<std::size_t>(label)];
    const int hu = tissue.ct->voxels[n] - kLowestHu;
    return of_hu[static_cast<std::size_t>(std::clamp(hu, 0, static_cast<int>(of_hu.size()) - 1))];
  };
  code_.resize(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2]);
  Smooth(code_at);
}

template <typename CodeAt>
void SpeedVolume::Smooth(const CodeAt& code_at) {
  const auto plane = static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
  std::array<std::vector<float>, 2 * kBinomialReach + 1> ring;
  for (auto& slice : ring) slice.resize(plane);
  std::vector<float> scratch;
  const auto read = [&](int k) {
    std::vector<float>& slice = ring[RingSlot(k)];
    const std::size_t first = plane * static_cast<std::size_t>(std::clamp(k, 0, size_[2] - 1));
    for (std::size_t n = 0; n < plane; ++n) slice[n] = index_of_code_[code_at(first + n)];
    SmoothSlice(slice, size_[0], size_[1], scratch);
  };
  for (int k = -kBinomialReach; k < kBinomialReach; ++k) read(k);
  std::vector<float> smooth(plane);
  for (int k = 0; k < size_[2]; ++k) {
    read(k + kBinomialReach);
    SmoothRing(
        k, [&](std::size_t slot) -> const auto& { return ring[slot]; }, smooth);
    std::uint8_t* out = code_.data() + plane * static_cast<std::size_t>(k);
    for (std::size_t n = 0; n < plane; ++n) out[n] = CodeOfIndex(smooth[n]);
  }
}

void SpeedVolume::SampleRow(const slicing::kernels::Lines& lines, float s, int lanes,
                            float* index) const {
  const std::array<std::ptrdiff_t, 3> stride{1, size_[0],
                                             static_cast<std::ptrdiff_t>(size_[0]) * size_[1]};
  for (int l = 0; l < lanes; ++l) {
    std::ptrdiff_t low = 0;
    std::array<float, 3> share{};
    std::array<std::ptrdiff_t, 3> next{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto last = static_cast<float>(size_[static_cast<Eigen::Index>(a)] - 1);
      const float at = std::min(std::max(lines.start[a][l] + s * lines.step[a][l], 0.0F), last);
      const int voxel = static_cast<int>(at);
      share[a] = at - static_cast<float>(voxel);
      next[a] = static_cast<float>(voxel) < last ? stride[a] : 0;
      low += voxel * stride[a];
    }
    const std::uint8_t* data = code_.data() + low;
    const auto along = [&](std::ptrdiff_t offset) {
      const float a = index_of_code_[data[offset]];
      return a + share[0] * (index_of_code_[data[offset + next[0]]] - a);
    };
    const auto plane = [&](std::ptrdiff_t offset) {
      const float a = along(offset);
      return a + share[1] * (along(offset + next[1]) - a);
    };
    const float near = plane(0);
    index[l] = near + share[2] * (plane(next[2]) - near);
  }
}

}  // namespace acus::ultrasound
