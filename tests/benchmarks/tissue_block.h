// A block of layered tissue that is meshed exactly at any element size: what tissue models are
// compared on.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "acus/base/core/provenance.h"
#include "acus/data/mesh/tetra_mesh.h"
#include "acus/data/volume/volume.h"
#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"

namespace acus::benchmarks {

/// From the top down: skin 4 mm, fat 16, muscle 16, liver to the bottom, which is held. The skin is
/// the plane z = 0 and tissue is below it (z < 0); x and y reach from -160 to 160 mm, z to -200.
/// CT space (LPS) as far as models know.
struct TissueBlock {
  static constexpr double kHalfWidthMm = 160.0;
  static constexpr double kDepthMm = 200.0;
  static constexpr double kFineHalfWidthMm = 12.0;  ///< Elements have the wanted size so far out
  static constexpr double kFineDepthMm = 56.0;      ///< and so far down, and grow from there.

  /// Label at a place; 0 above the skin and beyond the sides.
  static volume::Label TissueAt(const Eigen::Vector3d& x_mm);

  /// Bricks with edges of `element_mm` around the z axis, that grow by half from one to the next
  /// outside the fine part, each cut into six tetrahedra. All interfaces are faces. The nodes of
  /// the bottom are fixed.
  /// @param one_tissue  Not 0: the whole block is of it.
  /// @pre kFineHalfWidthMm is a multiple of element_mm.
  static mesh::TetraMesh Mesh(double element_mm, volume::Label one_tissue = 0);
};

/// Force table, needle and elastic constants of the presets.
struct TissueBlockTables {
  forces::ForceTable forces;
  forces::NeedleProperties needle;
  mechanics::ElasticityTable elasticity;

  /// @throws InputError if a preset cannot be found or read; adds them to the provenance.
  static TissueBlockTables FromPresets(Provenance& provenance);
};

/// Displacement into an elastic half space, mm, at a place of its surface, by a uniform pressure
/// (1 N in all) on the square |x|, |y| <= half_mm (Love 1929, Phil. Trans. R. Soc. A 228:377-420).
double SquarePressureMmPerN(const mechanics::ElasticTissue& tissue, double half_mm, double x_mm,
                            double y_mm);

}  // namespace acus::benchmarks
