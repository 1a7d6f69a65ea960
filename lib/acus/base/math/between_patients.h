// How much stiffer the tissue of one patient is than that of the median patient.
#pragma once

#include <cstdint>

namespace acus::math {

/// exp(z ln(geometric_sd)) with z standard normal, drawn by (seed, tissue): the median is 1, and
/// 68 % of patients lie between 1 / geometric_sd and geometric_sd. Forces and moduli of a tissue
/// have the same z. 1 for seed 0, the median patient, and for geometric_sd <= 1.
/// @param tissue  Number of its label.
double PatientFactor(double geometric_sd, std::uint64_t seed, std::uint64_t tissue);

}  // namespace acus::math
