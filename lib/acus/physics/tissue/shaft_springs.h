// What holds a needle's shaft in soft tissue, without a mesh.
#pragma once

namespace acus::tissue {

/// Force per mm of shaft and mm of displacement, for a shear modulus of 1 MPa; times the modulus:
/// N/mm^2.
struct ShaftStiffness {
  double along = 0.0;
  double across = 0.0;
};

/// A rigid rod in the middle of a cylinder of tissue that is held at its outside: moved along
/// itself (shear between two cylinders), 2 pi / ln(R/a), and across (incompressible; the same
/// equations as slow flow around a rod in a pipe), 4 pi / (ln(R/a) - (R^2 - a^2) / (R^2 + a^2)).
/// @pre 0 < shaft_radius_mm < outer_radius_mm
ShaftStiffness ShaftInCylinder(double shaft_radius_mm, double outer_radius_mm) noexcept;

}  // namespace acus::tissue
