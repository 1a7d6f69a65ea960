// A named number for the assessment of a session.
#pragma once

#include <string>

namespace acus::training {

struct Metric {
  std::string name;
  std::string unit;  ///< Empty for a count.
  double value = 0.0;
};

}  // namespace acus::training
