// What a patient's breath does at a moment: all that motion models need.
#pragma once

namespace acus::breathing {

struct Breath {
  double cycle = 0.0;        ///< How far through the breath, [0, 1): 0 and 1 are end inspiration.
  double level = 1.0;        ///< The signal: by convention 1 at end inspiration, 0 at expiration,
                             ///< of a normal breath; deeper ones go beyond. Recorded signals keep
                             ///< their own unit.
  double level_per_s = 0.0;  ///< Its derivative.
};

}  // namespace acus::breathing
