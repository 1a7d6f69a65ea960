#include "acus/imaging/ultrasound/display/grey_curve.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::ultrasound {

double GreyOfLevel(GreyCurve curve, double parameter, double dynamic_range_db, double u) {
  const double level = std::clamp(u, 0.0, 1.0);
  if (curve == GreyCurve::kPower) {
    return level > 0.0 ? std::pow(10.0, parameter * (level - 1.0) * dynamic_range_db / 20.0) : 0.0;
  }
  if (curve == GreyCurve::kSigmoid) {
    const auto sigmoid = [&](double x) {
      return 1.0 / (1.0 + std::exp(-4.0 * (x - 0.5) / parameter));
    };
    return (sigmoid(level) - sigmoid(0.0)) / (sigmoid(1.0) - sigmoid(0.0));
  }
  return level;
}

std::array<std::uint8_t, 256> GreyTable(GreyCurve curve, double parameter,
                                        double dynamic_range_db) {
  ACUS_REQUIRE(parameter > 0.0 && std::isfinite(parameter) && dynamic_range_db > 0.0,
               "display: a curve with the parameter ", parameter, " over ", dynamic_range_db,
               " dB; both must be above 0");
  std::array<std::uint8_t, 256> table;
  for (std::size_t n = 0; n < table.size(); ++n) {
    const double u = static_cast<double>(n) / 255.0;
    table[n] = static_cast<std::uint8_t>(
        std::lround(255.0 * GreyOfLevel(curve, parameter, dynamic_range_db, u)));
  }
  return table;
}

}  // namespace acus::ultrasound
