// The transfer function of Fortmeier-2016, section 2.3: from HU to the parameters of algorithm 1.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace acus::forces {

/// What algorithm 1 takes at a node of the path.
struct SpringParameters {
  double a1_n_per_mm = 0.0;        ///< Of the cut (eq. 4).
  double a2_n_per_mm2 = 0.0;       ///< The same, quadratic.
  double cutting_n = 0.0;          ///< f_cut.
  double shaft_n_per_mm2 = 0.0;    ///< k per mm of path.
  double friction_n_per_mm = 0.0;  ///< R per mm of path.
};

/// Linear between its rows, constant beyond the ends.
struct HuSprings {
  struct Row {
    double hu = 0.0;
    SpringParameters at;
  };
  std::vector<Row> rows;  ///< Rising; none: parameters are those of the tissues.

  /// @pre there are rows.
  SpringParameters At(double hu) const noexcept;
  void Scale(double ratio);
};

/// From the block "hu_springs" of a checked document of the format acus-forces/1.
/// @throws InputError naming the row, if HU do not rise or a cut has no stiffness.
HuSprings HuSpringsFromJson(const nlohmann::json& rows, const std::string& where);

}  // namespace acus::forces
