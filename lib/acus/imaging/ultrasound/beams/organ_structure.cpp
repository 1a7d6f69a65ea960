#include "acus/imaging/ultrasound/beams/organ_structure.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "acus/imaging/ultrasound/speckle/place_hash.h"

namespace acus::ultrasound {
namespace {

/// Depths below the surface of a label are counted in these steps.
constexpr double kDepthStepMm = 0.25;
constexpr int kDeepest = 255;

// Codes of voxels: 0 is nothing; then what changes zeta; then gains in steps.
constexpr std::uint8_t kCapsule = 1;
constexpr std::uint8_t kWall = 2;
constexpr std::uint8_t kEpiduralFat = 3;
constexpr std::uint8_t kDura = 4;
constexpr int kNoGain = 128;
constexpr double kDbPerCode = 0.25;

// Estimates: in units of zeta, half of the relative change of the impedance.
constexpr float kCapsuleZeta = 0.03F;
constexpr float kWallZeta = 0.04F;
/// Fat (1.38 MRayl) and dura (1.75 MRayl) in place of fluid (1.52 MRayl).
constexpr float kEpiduralFatZeta = -0.048F;
constexpr float kDuraZeta = 0.07F;

// Kidney: cortex 6.6 +- 1.9 mm thick (Glodny and others, BMC Urol. 2009); the rest are estimates.
constexpr double kCortexMm = 7.0;
constexpr double kParenchymaMm = 14.0;
/// A label that is nowhere deeper than this is parenchyma only.
constexpr double kLeastWithSinusMm = 16.0;
constexpr double kPyramidMm = 9.0;
constexpr double kPyramidDb = -4.0;
constexpr double kSinusLumpMm = 5.0;
constexpr double kSinusFatDb = 11.0;
constexpr double kPelvisDb = -8.0;
// Epidural fat and dura, by depth below the canal's wall.
constexpr double kFatMm = 2.0;
constexpr double kDuraMm = 3.2;

/// Lumps of a parenchyma: standard deviation and size.
struct Lumps {
  double db;
  double mm;
};
constexpr Lumps kLiverLumps{1.2, 4.0};
constexpr Lumps kSpleenLumps{0.6, 3.0};
constexpr Lumps kPancreasLumps{2.5, 4.0};

/// Smooth noise of mean 0.5, in [0, 1].
double NoiseAt(const Eigen::Vector3d& cell, std::uint32_t seed) {
  const Eigen::Array3d low = cell.array().floor();
  const Eigen::Array3d part = cell.array() - low;
  const Eigen::Array3d share = part * part * (3.0 - 2.0 * part);
  const Eigen::Array3i at = low.cast<int>();
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3i up(corner & 1, corner >> 1 & 1, corner >> 2);
    const auto is_up = up.cast<double>();
    const double weight = (is_up * share + (1.0 - is_up) * (1.0 - share)).prod();
    sum += weight * HashOfPlace(at[0] + up[0], at[1] + up[1], at[2] + up[2], seed) / 4294967296.0;
  }
  return sum;
}

std::uint8_t CodeOfDb(double db) {
  return static_cast<std::uint8_t>(
      std::clamp(std::lround(db / kDbPerCode) + kNoGain, long{kDura} + 1, 255L));
}

std::uint8_t CodeOfLumps(const Lumps& lumps, const Eigen::Vector3d& place_mm, std::uint32_t seed) {
  // The noise' standard deviation is 0.17.
  return CodeOfDb(lumps.db / 0.17 * (NoiseAt(place_mm / lumps.mm, seed) - 0.5));
}

}  // namespace

OrganStructure::OrganStructure(const volume::LabelMap& labels, std::uint64_t seed)
    : wall_mm_(labels.geometry.spacing_mm.maxCoeff() * 0.75),
      code_(labels.voxels.size(), std::uint8_t{0}) {
  gain_.fill(1.0F);
  for (int code = kDura + 1; code < 256; ++code) {
    gain_[static_cast<std::size_t>(code)] =
        static_cast<float>(std::pow(10.0, (code - kNoGain) * kDbPerCode / 20.0));
  }
  zeta_[kCapsule] = kCapsuleZeta;
  zeta_[kWall] = kWallZeta;
  zeta_[kEpiduralFat] = kEpiduralFatZeta;
  zeta_[kDura] = kDuraZeta;
  const auto kind_of = [](std::string_view name) {
    return name == "kidney"                                                 ? Kind::kKidney
           : name == "liver"                                                ? Kind::kLiver
           : name == "spleen"                                               ? Kind::kSpleen
           : name == "pancreas"                                             ? Kind::kPancreas
           : name == "gallbladder" || name == "bladder" || name == "vessel" ? Kind::kFluid
           : name == "spinal_canal"                                         ? Kind::kCanal
                                                                            : Kind::kNone;
  };
  bool any = false;
  for (const auto& [label, name] : labels.names) {
    kind_[label] = kind_of(name);
    within_[label] = name == "vessel" || name == "lesion";
    any = any || kind_[label] != Kind::kNone;
  }
  if (!any) return;
  MeasureDepths(labels);
  CodeVoxels(labels, static_cast<std::uint32_t>(seed * 0x9E3779B97F4A7C15ULL >> 32));
}

void OrganStructure::MeasureDepths(const volume::LabelMap& labels) {
  const Eigen::Array3i& size = labels.geometry.size;
  const std::ptrdiff_t row = size[0];
  const std::ptrdiff_t slice = row * size[1];
  struct Step {
    int i;
    int j;
    int k;
    std::ptrdiff_t offset;
    int length;
  };
  // Half of the places around a voxel; the other half lies opposite.
  std::vector<Step> steps;
  for (int k = -1; k <= 0; ++k) {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        if (9 * k + 3 * j + i >= 0) continue;
        const Eigen::Array3d step = Eigen::Array3d(i, j, k) * labels.geometry.spacing_mm;
        const auto length = static_cast<int>(std::lround(step.matrix().norm() / kDepthStepMm));
        steps.push_back({i, j, k, k * slice + j * row + i, std::max(1, length)});
      }
    }
  }
  const auto pass = [&](int sign) {
    const auto count = static_cast<std::ptrdiff_t>(code_.size());
    for (std::ptrdiff_t n = 0; n < count; ++n) {
      const std::ptrdiff_t voxel = sign > 0 ? n : count - 1 - n;
      const volume::Label label = labels.voxels[static_cast<std::size_t>(voxel)];
      if (kind_[label] == Kind::kNone) continue;
      const auto x = static_cast<int>(voxel % row);
      const auto y = static_cast<int>(voxel / row % size[1]);
      const auto z = static_cast<int>(voxel / slice);
      int least = sign > 0 ? kDeepest : code_[static_cast<std::size_t>(voxel)];
      for (const Step& step : steps) {
        const int i = x + sign * step.i;
        const int j = y + sign * step.j;
        const int k = z + sign * step.k;
        // The end of the CT is no surface.
        if (i < 0 || j < 0 || k < 0 || i >= size[0] || j >= size[1] || k >= size[2]) continue;
        const auto there = static_cast<std::size_t>(voxel + sign * step.offset);
        const volume::Label other = labels.voxels[there];
        if (other != label && within_[other] && !within_[label]) continue;
        least = std::min(least, other == label ? code_[there] + step.length : step.length / 2);
      }
      code_[static_cast<std::size_t>(voxel)] = static_cast<std::uint8_t>(least);
    }
  };
  pass(1);
  pass(-1);
}

void OrganStructure::CodeVoxels(const volume::LabelMap& labels, std::uint32_t seed) {
  std::array<int, 256> most{};
  for (std::size_t n = 0; n < code_.size(); ++n) {
    most[labels.voxels[n]] = std::max<int>(most[labels.voxels[n]], code_[n]);
  }
  const Eigen::Array3i& size = labels.geometry.size;
  std::size_t n = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i, ++n) {
        const volume::Label label = labels.voxels[n];
        if (kind_[label] == Kind::kNone) continue;
        const Eigen::Vector3d place_mm = Eigen::Array3d(i, j, k) * labels.geometry.spacing_mm;
        code_[n] = CodeOf(kind_[label], kDepthStepMm * code_[n], kDepthStepMm * most[label],
                          place_mm, seed);
      }
    }
  }
}

std::uint8_t OrganStructure::CodeOf(Kind kind, double depth_mm, double most_mm,
                                    const Eigen::Vector3d& place_mm, std::uint32_t seed) const {
  const bool outermost = depth_mm <= wall_mm_;
  switch (kind) {
    case Kind::kKidney: {
      if (outermost) return kCapsule;
      if (depth_mm < kCortexMm) return 0;
      const bool has_sinus = most_mm >= kLeastWithSinusMm;
      if (has_sinus && depth_mm > kParenchymaMm) {
        const bool fat = NoiseAt(place_mm / kSinusLumpMm, seed + 1) > 0.35;
        return CodeOfDb(fat ? kSinusFatDb : kPelvisDb);
      }
      return NoiseAt(place_mm / kPyramidMm, seed + 2) > 0.5 ? CodeOfDb(kPyramidDb) : 0;
    }
    case Kind::kLiver:
      return outermost ? kCapsule : CodeOfLumps(kLiverLumps, place_mm, seed + 3);
    case Kind::kSpleen:
      return outermost ? kCapsule : CodeOfLumps(kSpleenLumps, place_mm, seed + 4);
    case Kind::kPancreas:
      return CodeOfLumps(kPancreasLumps, place_mm, seed + 5);
    case Kind::kFluid:
      return outermost ? kWall : 0;
    case Kind::kCanal:
      return depth_mm < kFatMm ? kEpiduralFat : depth_mm < kDuraMm ? kDura : 0;
    case Kind::kNone:
      break;
  }
  return 0;
}

}  // namespace acus::ultrasound
