// A named number that a session is judged by.
#pragma once

#include <string>

namespace acus::training {

struct Metric {
  std::string name;
  std::string unit;  ///< Empty for a count.
  double value = 0.0;
};

}  // namespace acus::training
