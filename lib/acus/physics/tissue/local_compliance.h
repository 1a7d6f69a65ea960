// What a mesh cannot resolve around a needle: the displacement between the needle's surface and the
// distance at which the finite elements take over.
//
// A force on a point of a mesh of linear elements moves it as if the force were spread over a
// radius that grows with the element, so forces on a needle would fall without end as the mesh is
// refined. The missing part has a closed form, as for a well in a reservoir grid (Peaceman 1978,
// SPE Journal 18(3):183-194): the solution between two radii of a line load in an infinite solid,
// and of a rigid sphere at the tip. Added to the diagonal, it makes forces independent of the mesh.
#pragma once

#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/tissue/contact_system.h"

namespace acus::tissue {

/// The radius that the mesh does resolve around a line of points, over the edge of its elements.
/// Found with a rigid wire in a round tube, for which forces are known (tests/physics/
/// tissue_contact_test.cpp), as a mean over where the wire runs through the elements and with the
/// averaged dilatation that acus-mesh uses. Plain linear tetrahedra are too stiff across.
inline constexpr double kAxialRadiusShare = 0.43;
inline constexpr double kLateralRadiusShare = 0.33;

/// A piece of shaft that stands for `length_mm` of line: Kelvin's line load along the needle (anti-
/// plane shear) and across it (plane strain), between radii r and R = share * edge:
///   axial   ln(R/r) / (2 pi G L)
///   lateral (3 - 4 nu) ln(R/r) / (8 pi G (1 - nu) L)
/// The logarithms are at least 0.2, so that several points in one element keep A positive definite.
LocalCompliance ShaftCompliance(const mechanics::ElasticTissue& tissue, double element_mm,
                                double radius_mm, double length_mm);

/// Around the tip, linear elasticity would give strains of many times 1. Tissue strained that far
/// is stiff and moves with the tip as one lump, up to about the distance where the linear solution
/// has a shear strain of 1. Under a force F that is
///   sqrt(F / (4 pi G)) inside the tissue, sqrt(F / (2 pi G)) on the surface,
/// but at least the needle's radius and at most kLargestLumpMm.
inline constexpr double kLargestLumpMm = 10.0;
double LumpRadiusMm(const mechanics::ElasticTissue& tissue, double force_n, bool on_surface,
                    double needle_radius_mm);

/// A rigid sphere of radius r inside the tissue moves by SphereMobility / r under 1 N; a flat-ended
/// punch on the surface (Boussinesq) by PunchMobility / r. mm^2/N:
///   (5 - 6 nu) / (24 pi G (1 - nu)),  (1 - nu) / (4 G).
double SphereMobilityMm2PerN(const mechanics::ElasticTissue& tissue);
double PunchMobilityMm2PerN(const mechanics::ElasticTissue& tissue);

/// A kernel moves as much as a rigid sphere of 1 / 1.85 its radius.
inline constexpr double kKernelOverSphere = 1.85;

/// The tip's displacement is the mean over a kernel of nodes (tip_kernel.h) with the same radius in
/// any mesh: of a lump, but at least kLeastKernelMm, and of what elements of this size can carry.
inline constexpr double kLeastKernelMm = 7.4;
double KernelRadiusMm(double element_mm, double lump_radius_mm);

/// What the kernel is too wide for, 1/mm: 1/r of the lump less 1/r of the sphere that moves as the
/// kernel does; never less than 2 % of the lump's part.
double NearFieldPerMm(double kernel_radius_mm, double lump_radius_mm);

}  // namespace acus::tissue
