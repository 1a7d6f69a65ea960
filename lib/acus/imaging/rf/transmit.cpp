#include "acus/imaging/rf/transmit.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::rf {

TransmitTiming::TransmitTiming(const Array& array, const Transmit& transmit,
                               double sound_speed_mm_per_us)
    : transmit_(transmit), sound_speed_mm_per_us_(sound_speed_mm_per_us) {
  ACUS_REQUIRE(std::abs(transmit.angle_rad) < 1.57, "transmission: the angle is ",
               transmit.angle_rad, " rad; it must be within 1.57 of 0");
  direction_ = {std::sin(transmit.angle_rad), std::cos(transmit.angle_rad)};
  if (transmit.focus_mm) {
    ACUS_REQUIRE(transmit.focus_mm->allFinite() && transmit.focus_mm->y() > 0.0,
                 "transmission: the focus is at a depth of ", transmit.focus_mm->y(),
                 " mm; it must be in front of the face, above 0");
    direction_ = transmit.focus_mm->normalized();
  }
  element_us_.reserve(array.elements.size());
  for (const Element& element : array.elements) {
    const double path_mm = transmit.focus_mm ? -(*transmit.focus_mm - element.position_mm).norm()
                                             : direction_.dot(element.position_mm);
    element_us_.push_back(path_mm / sound_speed_mm_per_us);
  }
  const double first_us = *std::ranges::min_element(element_us_);
  for (double& time_us : element_us_) time_us -= first_us;
  offset_us_ = -first_us;
}

double TransmitTiming::ArrivalUs(const Eigen::Vector2d& place_mm) const {
  if (!transmit_.focus_mm) return offset_us_ + direction_.dot(place_mm) / sound_speed_mm_per_us_;
  const Eigen::Vector2d from_focus = place_mm - *transmit_.focus_mm;
  return offset_us_ +
         std::copysign(from_focus.norm(), direction_.dot(from_focus)) / sound_speed_mm_per_us_;
}

}  // namespace acus::rf
