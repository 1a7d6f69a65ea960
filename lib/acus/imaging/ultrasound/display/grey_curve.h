// The compression curve of a display: from greys that are linear in dB to those of the screen.
#pragma once

#include <array>
#include <cstdint>

#include "acus/imaging/ultrasound/display/display_options.h"

namespace acus::ultrasound {

/// Grey, 0 to 1, of a level that lies u of the dynamic range above its foot; 0 and 1 at the ends
/// except for the power, whose foot is 10^(-exponent range / 20), and which is cut off there.
///   log: u (Kaplan and Ma, J. Acoust. Soc. Am. 95:1396, 1994);
///   power: (amplitude over that of white)^exponent;
///   sigmoid: the SIGMOID function of DICOM PS3.3 C.11.2.1.3, stretched to 0 ... 1.
double GreyOfLevel(GreyCurve curve, double parameter, double dynamic_range_db, double u);

/// The same for the 256 greys of the logarithm.
/// @throws InputError if the parameter is not above 0 or the range not above 0.
std::array<std::uint8_t, 256> GreyTable(GreyCurve curve, double parameter, double dynamic_range_db);

}  // namespace acus::ultrasound
