// How tissue moves around a needle, by two formulas and the needle's force: no mesh, no state.
//
// Alamilla-2021 eq. 13 (before the skin is punctured) and eq. 14 (after). What the paper prints,
// what it must mean, and what is done here: docs/models/tissue_functions_and_springs.md.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "acus/physics/tissue/tissue_load.h"

namespace acus::tissue {

/// Young's modulus of the tissue at rest at a place of CT space, MPa; <= 0 outside the body,
/// infinite where nothing moves (bone).
using ModulusAt = std::function<double(const Eigen::Vector3d& rest_in_ct_mm)>;

/// g of the paper, 1 - 3 t^2 + 2 t^3: from 1 at t = 0 to 0 at t = 1, level at both ends. 1 below 0,
/// 0 beyond 1.
double Fade(double t) noexcept;

/// g(2 - t) of the paper, which is (1 - t)^2 (5 - 2 t): from 5 at t = 0 to 0 at t = 1, steep at the
/// shaft. 0 beyond 1.
double ShaftFade(double t) noexcept;

struct DisplacementFunctionSettings {
  double influence_radius_mm = 20.0;  ///< R_max: nothing moves farther from the needle.

  /// The length that eq. 13 and 14 lack below the tip, where they print force / E, an area. 0: 4 pi
  /// R_max / 5, for which the mean displacement in the ball of R_max is that of a point force in
  /// incompressible tissue (Kelvin), less what it is at R_max, where here nothing moves.
  double tip_length_mm = 0.0;

  /// Half the length over which the zone along the shaft goes over into the zone below the tip;
  /// more where they differ much, so that tissue does not fold. 0: a step, as printed.
  double transition_mm = 3.0;

  /// 1/E is interpolated linearly between points so far apart, so that the field has no step where
  /// the tissue changes; twice the largest displacement if that is more, so that it does not fold.
  /// 0: E at the point, as printed.
  double modulus_blend_mm = 2.0;

  /// At the shaft, g(2 - t) is 5; divided by 5 the tissue there moves as the formula's factor says.
  bool shaft_factor_at_axis = true;

  /// Displacements above this share of R_max are held to it: beyond 0.66 the field folds.
  double largest_share = 0.6;

  /// The formulas to the letter: a length of 1 mm, steps, five times the tip's way at the shaft.
  static DisplacementFunctionSettings AsPrinted();
};

/// Const after construction; any number of threads may ask it at once, if ModulusAt allows that.
class DisplacementFunctions {
 public:
  /// @throws InputError for a length or share that is not positive (blend, transition: negative).
  DisplacementFunctions(const DisplacementFunctionSettings& settings, ModulusAt modulus);

  /// All of a load that the formulas need, prepared once for many points.
  struct Prepared {
    bool active = false;
    bool pierced = false;
    Eigen::Vector3d entry_in_ct_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();
    double depth_mm = 0.0;                  ///< z_max: of the tip, along the axis.
    double entry_compliance_per_mpa = 0.0;  ///< 1/E where the needle touched the skin.
    double shaft_mm = 0.0;                  ///< Before puncture: at the shaft, for any E.
    double shaft_mpa_mm = 0.0;              ///< After: at the shaft, times E. Signed.
    double tip_mpa_mm = 0.0;                ///< Just below the tip, times E.
    double half_transition_mm = 0.0;
    double blend_mm = 0.0;
  };
  Prepared Prepare(const TissueLoad& load) const;

  /// Where the tissue that was at this place at rest has moved, relative to it, mm in CT space;
  /// along the needle's axis. Continuous, zero beyond R_max of the needle in the body. Allocates
  /// nothing.
  Eigen::Vector3d DisplacementMm(const Prepared& prepared,
                                 const Eigen::Vector3d& rest_in_ct_mm) const noexcept;

  /// Both in one: for a few points.
  Eigen::Vector3d DisplacementMm(const TissueLoad& load,
                                 const Eigen::Vector3d& rest_in_ct_mm) const {
    return DisplacementMm(Prepare(load), rest_in_ct_mm);
  }

  const DisplacementFunctionSettings& settings() const { return settings_; }

 private:
  double ComplianceAt(const Prepared& prepared, const Eigen::Vector3d& rest_mm) const noexcept;
  double CompliancePoint(const Prepared& prepared, const Eigen::Vector3d& rest_mm) const noexcept;

  DisplacementFunctionSettings settings_;
  ModulusAt modulus_;
};

/// The displacement field of one renderer thread. Keeps a reference to the functions.
class DisplacementFunctionsField {
 public:
  explicit DisplacementFunctionsField(const DisplacementFunctions& functions)
      : functions_(&functions) {}

  void Update(const TissueLoad& load) { prepared_ = functions_->Prepare(load); }
  Eigen::Vector3d DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
    return functions_->DisplacementMm(prepared_, rest_in_ct_mm);
  }

 private:
  const DisplacementFunctions* functions_;
  DisplacementFunctions::Prepared prepared_;
};

}  // namespace acus::tissue
