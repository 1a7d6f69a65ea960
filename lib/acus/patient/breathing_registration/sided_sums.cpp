#include "acus/patient/breathing_registration/sided_sums.h"

namespace acus::breathing_registration {

SidedSums::SidedSums(const Eigen::Array3i& size, int num_scales) {
  Eigen::Array3i cubes = size;
  for (int n = 0; n < num_scales; ++n) {
    cubes = (cubes + 1) / 2;
    Scale scale{.size = cubes, .sums = {}};
    for (auto& sums : scale.sums) {
      sums.assign(CubeAt(cubes, cubes - 1) + 1, Numbers::Zero());
    }
    scales_.push_back(std::move(scale));
  }
}

void SidedSums::Add(const Eigen::Array3i& node, Side side, const Numbers& numbers) {
  scales_[0].sums[SideIndex(side)][CubeAt(scales_[0].size, node / 2)] += numbers;
}

void SidedSums::Finish() {
  for (std::size_t n = 1; n < scales_.size(); ++n) {
    const Scale& fine = scales_[n - 1];
    for (std::size_t side = 0; side < 2; ++side) {
      for (int k = 0; k < fine.size[2]; ++k) {
        for (int j = 0; j < fine.size[1]; ++j) {
          for (int i = 0; i < fine.size[0]; ++i) {
            scales_[n].sums[side][CubeAt(scales_[n].size, {i / 2, j / 2, k / 2})] +=
                fine.sums[side][CubeAt(fine.size, {i, j, k})];
          }
        }
      }
    }
  }
}

SidedSums::Numbers SidedSums::At(const Eigen::Vector3f& at, Side side, int scale) const noexcept {
  const Scale& s = scales_[static_cast<std::size_t>(scale)];
  Numbers out = Numbers::Zero();
  AroundCubes(s.size, at, 2 << scale, [&](std::size_t cube, float weight) {
    out += weight * s.sums[SideIndex(side)][cube];
  });
  return out;
}

}  // namespace acus::breathing_registration
