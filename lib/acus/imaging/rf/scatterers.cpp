#include "acus/imaging/rf/scatterers.h"

#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::rf {

std::vector<Scatterer> ScatterersIn(const ScatteringRegion& region, std::uint64_t seed) {
  const Eigen::Vector2d size_mm = region.high_mm - region.low_mm;
  ACUS_REQUIRE(size_mm.allFinite() && size_mm.minCoeff() >= 0.0, "scatterers: the region is ",
               size_mm.x(), " x ", size_mm.y(), " mm; neither may be negative");
  const double count = size_mm.prod() * region.per_mm2;
  constexpr double kMost = 5e6;
  ACUS_REQUIRE(region.per_mm2 >= 0.0 && count <= kMost, "scatterers: ", region.per_mm2,
               " per mm^2 in the region make ", count, "; at most ", kMost,
               " are allowed: lower the density");
  std::vector<Scatterer> out(static_cast<std::size_t>(std::llround(count)));
  RandomStream random(seed, "rf scatterers");
  for (Scatterer& scatterer : out) {
    const double x = random.Uniform();
    const double y = random.Uniform();
    scatterer.position_mm = region.low_mm + Eigen::Vector2d(x, y).cwiseProduct(size_mm);
    scatterer.amplitude = 1.0 / std::sqrt(region.per_mm2);
  }
  return out;
}

}  // namespace acus::rf
