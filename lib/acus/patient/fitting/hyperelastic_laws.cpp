#include "acus/patient/fitting/hyperelastic_laws.h"

#include <algorithm>
#include <cmath>

namespace acus::fitting {
namespace {

constexpr double kLargestExponent = 200.0;
constexpr const char* kMu[] = {"mu_mpa"};
constexpr const char* kYeohNames[] = {"c1_mpa", "c2_mpa", "c3_mpa"};
constexpr const char* kFungNames[] = {"mu_mpa", "b"};

/// dW/dI1 at e = I1 - 3.
double Slope(HyperelasticLaw law, std::span<const double> p, double e) noexcept {
  switch (law) {
    case HyperelasticLaw::kNeoHookean:
      return 0.5 * p[0];
    case HyperelasticLaw::kYeoh:
      return p[0] + (2.0 * p[1] + 3.0 * p[2] * e) * e;
    case HyperelasticLaw::kFung:
      return 0.5 * p[0] * std::exp(std::min(p[1] * e, kLargestExponent));
  }
  return 0.0;
}

}  // namespace

std::string_view NameOf(HyperelasticLaw law) noexcept {
  switch (law) {
    case HyperelasticLaw::kNeoHookean:
      return "neo_hookean";
    case HyperelasticLaw::kYeoh:
      return "yeoh";
    case HyperelasticLaw::kFung:
      return "fung";
  }
  return "";
}

std::span<const char* const> ParametersOf(HyperelasticLaw law) noexcept {
  switch (law) {
    case HyperelasticLaw::kNeoHookean:
      return kMu;
    case HyperelasticLaw::kYeoh:
      return kYeohNames;
    case HyperelasticLaw::kFung:
      return kFungNames;
  }
  return {};
}

namespace {

double StressMpa(HyperelasticLaw law, std::span<const double> parameters, double stretch) noexcept {
  const double invariant = stretch * stretch + 2.0 / stretch;
  return 2.0 * (stretch - 1.0 / (stretch * stretch)) * Slope(law, parameters, invariant - 3.0);
}

}  // namespace

double NominalStressMpa(HyperelasticLaw law, std::span<const double> parameters,
                        double stretch) noexcept {
  return stretch > 1.0 ? StressMpa(law, parameters, stretch) : 0.0;
}

double CompressiveStressMpa(HyperelasticLaw law, std::span<const double> parameters,
                            double stretch) noexcept {
  return stretch < 1.0 ? -StressMpa(law, parameters, stretch) : 0.0;
}

}  // namespace acus::fitting
