// Breathing whose displacements are known exactly, in any patient whose cavity is known.
#pragma once

#include "acus/patient/phantom/anatomy/cavity.h"
#include "acus/physics/breathing/breath.h"

namespace acus::phantom {

/// From end expiration (level 0, nothing has moved) to end inspiration (level 1).
struct BreathingSettings {
  double diaphragm_mm = 20.0;  ///< Of the domes towards the feet. 10 to 50 in the living.
  double chest_mm = 5.0;       ///< Of the front of the chest, forwards; its sides go 0.8 as far.
  double hysteresis_mm =
      2.0;                ///< Half the width of the loop that tissue in the cavity runs through.
  double period_s = 4.0;  ///< Of the breath that goes with hysteresis_mm.
};

/// x = chest(slide(X)). Within the cavity, tissue flows for unit time along a steady velocity that
/// is tangent to the cavity's wall, towards the feet as `level` says and forwards as its rate says;
/// outside, slide is the identity. So tissue slides along the wall, and no gap opens: the wall maps
/// to itself. Lung moves less the higher and the farther in front it is, as in patients. Then all
/// moves forwards and aside with the chest, and with the abdominal wall by as much as keeps the
/// volume of organs below the diaphragm; the spine does not. Both parts are diffeomorphic for any
/// breath. A value; const access from any number of threads.
class BreathingMotion {
 public:
  /// @throws InputError if diaphragm_mm is outside [0, 80], chest_mm outside [0, 30], hysteresis_mm
  ///     outside [0, 20] or period_s outside [0.5, 60].
  BreathingMotion(Cavity cavity, const BreathingSettings& settings);

  bool InCavity(const Eigen::Vector3d& rest_mm) const noexcept {
    return cavity_.wall.LevelMm(rest_mm) < 0.0;
  }
  /// Where tissue that is at `rest_mm` at end expiration is now. CT space, mm.
  Eigen::Vector3d WorldMm(const Eigen::Vector3d& rest_mm, const breathing::Breath& breath) const {
    return WorldMm(rest_mm, breath, InCavity(rest_mm));
  }
  /// The same, going by one side of the wall also beyond it.
  Eigen::Vector3d WorldMm(const Eigen::Vector3d& rest_mm, const breathing::Breath& breath,
                          bool in_cavity) const noexcept;
  /// Its inverse, to 0.001 mm.
  Eigen::Vector3d RestMm(const Eigen::Vector3d& world_mm, const breathing::Breath& breath) const;

  /// The parts of the inverse: world to the place before the chest moved, then back along the flow.
  Eigen::Vector3d BeforeChestMm(const Eigen::Vector3d& world_mm,
                                const breathing::Breath& breath) const noexcept;
  /// Volume of tissue at a place before the chest moved, relative to what it is after.
  double ChestThinning(const Eigen::Vector3d& before_mm,
                       const breathing::Breath& breath) const noexcept {
    return 1.0 / BulgeAt(before_mm, breath.level).growth;
  }
  Eigen::Vector3d BeforeSlidingMm(const Eigen::Vector3d& slid_mm,
                                  const breathing::Breath& breath) const noexcept;

  const Cavity& cavity() const { return cavity_; }
  const BreathingSettings& settings() const { return settings_; }

 private:
  /// Velocity of the flow at a place, mm per unit time.
  Eigen::Vector3d Velocity(const Eigen::Vector3d& p, double down_mm,
                           double forward_mm) const noexcept;
  Eigen::Vector3d Flow(const Eigen::Vector3d& p, double down_mm, double forward_mm) const noexcept;
  /// Displacement by the motion of ribs and abdominal wall.
  struct Bulge {
    double aside_mm = 0.0;  ///< Away from the midline, along x.
    double forward_mm = 0.0;
    double growth = 1.0;  ///< Volume of tissue, relative to before.
  };
  Bulge BulgeAt(const Eigen::Vector3d& p, double level) const noexcept;
  /// How far below the band that moves as one.
  double BelowBandMm(double z_mm) const noexcept;
  double Rate(const breathing::Breath& breath) const noexcept;

  Cavity cavity_;
  BreathingSettings settings_;
};

}  // namespace acus::phantom
