#include "acus/base/math/between_patients.h"

#include <cmath>

#include "acus/base/core/random.h"

namespace acus::math {

double PatientFactor(double geometric_sd, std::uint64_t seed, std::uint64_t tissue) {
  if (seed == 0 || !(geometric_sd > 1.0)) return 1.0;
  const double z = RandomStream(seed, "stiffness between patients", tissue).Normal();
  return std::exp(z * std::log(geometric_sd));
}

}  // namespace acus::math
