// Incompressible hyperelastic laws in uniaxial tension and compression: nominal stress by stretch,
// closed forms.
#pragma once

#include <span>
#include <string_view>

namespace acus::fitting {

/// Energies by the first invariant I1, in MPa:
///   neo_hookean  W = mu/2 (I1 - 3)
///   yeoh         W = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3     (Yeoh 1993)
///   fung         W = mu/(2 b) (exp(b (I1 - 3)) - 1)                  (Demiray 1972)
enum class HyperelasticLaw { kNeoHookean, kYeoh, kFung };
inline constexpr HyperelasticLaw kHyperelasticLaws[] = {
    HyperelasticLaw::kNeoHookean, HyperelasticLaw::kYeoh, HyperelasticLaw::kFung};

/// "neo_hookean", "yeoh", "fung".
std::string_view NameOf(HyperelasticLaw law) noexcept;

/// Names of the law's parameters in order: mu_mpa; c1_mpa, c2_mpa, c3_mpa; mu_mpa, b.
std::span<const char* const> ParametersOf(HyperelasticLaw law) noexcept;

/// Force per undeformed area in uniaxial tension of an incompressible specimen, MPa:
///   P = 2 (lambda - lambda^-2) dW/dI1,  I1 = lambda^2 + 2 / lambda.
/// A slack specimen, lambda <= 1, carries nothing. The exponent of fung is held at 200 so that the
/// result is finite.
double NominalStressMpa(HyperelasticLaw law, std::span<const double> parameters,
                        double stretch) noexcept;

/// The same in compression, as a pressure > 0; 0 from a stretch of 1 on. @param stretch  > 0.
double CompressiveStressMpa(HyperelasticLaw law, std::span<const double> parameters,
                            double stretch) noexcept;

}  // namespace acus::fitting
