// Points on a command line.
#pragma once

#include <Eigen/Core>
#include <string>

namespace acus::math {

/// "x,y,z" as a point. @throws InputError naming `what` if the text is not three finite numbers.
Eigen::Vector3d PointFromText(const std::string& text, const std::string& what);

}  // namespace acus::math
