#include "acus/base/math/point_text.h"

#include <charconv>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::math {

Eigen::Vector3d PointFromText(const std::string& text, const std::string& what) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  const char* at = text.data();
  const char* end = at + text.size();
  bool is_sound = true;
  for (int d = 0; d < 3 && is_sound; ++d) {
    const auto [rest, error] = std::from_chars(at, end, out[d]);
    is_sound = error == std::errc() && std::isfinite(out[d]) &&
               (d == 2 ? rest == end : rest != end && *rest == ',');
    at = rest + 1;
  }
  ACUS_REQUIRE(is_sound, what, ": '", text,
               "' is not a point; write x,y,z in mm, such as 1.5,-20,340");
  return out;
}

}  // namespace acus::math
