// Liquid and air that pass through a needle, one behind the other: the account of both in a step.
#pragma once

namespace acus::fluid {

/// Volumes that one end of a lumen takes in or gives off in a step.
struct Passage {
  double liquid_ml = 0.0;
  double gas_volume_ml = 0.0;  ///< Of air, as it is compressed.
  double air_ml = 0.0;         ///< The same air at atmospheric pressure.
};

struct LumenContent {
  double volume_ml = 0.0;
  double liquid_ml = 0.0;
  double air_ml = 0.0;  ///< At atmospheric pressure.

  /// What leaves at the other end: air first where liquid pushes it, liquid first where air does. A
  /// bubble between two columns of liquid leaves before them.
  Passage Push(const Passage& entering) noexcept;
};

}  // namespace acus::fluid
