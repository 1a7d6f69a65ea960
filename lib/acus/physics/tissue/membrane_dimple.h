// How a membrane resists a tip that presses it in far: by being stretched.
#pragma once

namespace acus::tissue {

/// A dimple h (1 - r^2/a^2)^2 in a plane elastic sheet that reaches beyond it. Its stretching
/// energy, least over the displacements along the sheet (Foeppl and von Karman), is (8 pi / 63) E t
/// h^4 / a^2, whatever Poisson's ratio. A kernel of radius a with the same weights moves by w = 3/5
/// h. docs/models/tissue_membranes.md
struct MembraneDimple {
  double stretching_n_per_mm = 0.0;  ///< E t; 0: no membrane.
  double radius_mm = 1.0;            ///< a.

  /// Force along the dimple's axis, d(energy)/dw, N, for the displacement w of the kernel; 0 for
  /// w <= 0.
  double ForceN(double moved_mm) const noexcept;
  /// d(force)/dw, N/mm.
  double SlopeNPerMm(double moved_mm) const noexcept;

  /// How much deeper than its kernel a point under a force is, over that force, mm/N. Of a plate
  /// that is bent this is `linear_mm_per_n`; a sheet that is stretched far has a dimple
  /// h (1 - (r/a)^(2/3)) with h = (3 F a^2 / (pi E t))^(1/3) (Schwerin 1929), 0.58 h deeper. The
  /// smaller one counts, with a smooth transition.
  double NearFieldMmPerN(double linear_mm_per_n, double force_n) const noexcept;
};

/// The radius for which the energy of sheet and ground together is least, mm: the ground resists a
/// dimple by w^2 k a / 2, with k = `ground_mpa` (its stiffness over the radius); between
/// `least_mm` and kWidestDimpleMm.
inline constexpr double kWidestDimpleMm = 18.0;
double DimpleRadiusMm(double stretching_n_per_mm, double ground_mpa, double moved_mm,
                      double least_mm) noexcept;

}  // namespace acus::tissue
