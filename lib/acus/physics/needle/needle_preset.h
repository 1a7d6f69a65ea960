// What a needle is: configs/needles, for every model that takes one.
#pragma once

#include <filesystem>
#include <string>

#include "acus/physics/needle/curved_path.h"
#include "acus/physics/needle/rod.h"
#include "acus/physics/needle/tube.h"

namespace acus::needle {

struct NeedleProperties {
  std::string name;
  int gauge = 0;
  double length_mm = 0.0;
  Tube beam;
  BevelTip bevel = {};          ///< Curvature 0: goes straight.
  double graduation_mm = 10.0;  ///< Distance of the marks on the shaft, from the tip on; 0: none.
};

/// Reads configs/needles/*.json (format acus-needle/1). @throws InputError
NeedleProperties ReadNeedle(const std::filesystem::path& path);

/// The shaft as a straight rod.
RodProperties RodOf(const NeedleProperties& needle);

}  // namespace acus::needle
