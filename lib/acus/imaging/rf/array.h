// Arrays of elements in the image plane.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "acus/imaging/acoustics/probe.h"

namespace acus::rf {

/// Place of one element, in the probe's plane: x lateral, y depth, mm. The middle of the face is
/// the origin.
struct Element {
  Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::UnitY();  ///< Unit, into the tissue.
};

struct Array {
  std::vector<Element> elements;
  double element_width_mm = 0.0;
};

/// Linear and phased: a row; curvilinear: an arc with radius_mm. The pitch is that of the probe,
/// or the length of the face over the number of elements.
/// @param element_width_mm  Active width; 0: the pitch (no kerf).
/// @throws InputError if the width is negative, not finite or larger than the pitch.
Array ArrayOf(const acoustics::Probe& probe, double element_width_mm);

/// Amplitude that an element radiates towards a place, or receives from it, at one frequency: a
/// strip of width w in a soft baffle, cos(a) * sin(u) / u with u = pi w f sin(a) / c (Selfridge,
/// Kino & Khuri-Yakub, Appl. Phys. Lett. 37, 1980). 0 behind the face.
/// @param cos_angle  Of the angle a between the element's normal and the direction.
double Directivity(double element_width_mm, double frequency_mhz, double sound_speed_mm_per_us,
                   double cos_angle);

}  // namespace acus::rf
