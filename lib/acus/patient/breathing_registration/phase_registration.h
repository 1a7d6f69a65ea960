// Deformable registration of the phases of a 4D CT to its reference, with organs that slide.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/breathing_registration/level_image.h"
#include "acus/patient/breathing_registration/sliding_grid.h"

namespace acus::breathing_registration {

struct RegistrationSettings {
  /// Of the finest grid; each coarser one has twice the last's. 0: 2 mm, or the longest side of a
  /// voxel if that is more: a finer grid costs time and says nothing.
  double spacing_mm = 0.0;
  int levels = 3;
  int iterations = 6;          ///< Linearisations on each grid.
  int solver_iterations = 25;  ///< Conjugate gradients in each.
  /// What strain costs against one standard deviation of noise; four times as much on each coarser
  /// grid.
  double smoothness = 1.0;
  double noise = 20.0;  ///< Difference of contrast (HU of soft tissue) that says nothing.
};

/// Where tissue is, and the wall that it slides along. Places in CT space, mm.
struct Tissue {
  std::function<bool(const Eigen::Vector3d&)> is_tissue;
  /// Signed distance to the wall, < 0 in the cavity; empty: nothing slides.
  std::function<double(const Eigen::Vector3d&)> wall_mm;
};

/// Displacements of tissue from the reference to one phase.
class PhaseField {
 public:
  PhaseField(std::shared_ptr<const SlidingGrid> grid, SlidingGrid::Field displacement_voxels)
      : grid_(std::move(grid)), displacement_(std::move(displacement_voxels)) {}

  /// mm in CT space, of tissue on that side of the wall. @param rest_mm  In the reference.
  Eigen::Vector3d DisplacementMm(const Eigen::Vector3d& rest_mm, Side side) const;

  /// (x, y, z) in CT space at each of other nodes, i fastest, mm: for breathing::MotionPhase. Each
  /// node goes by the tissue on its side of the wall; beyond the tissue as the nearest of it.
  std::vector<float> OnNodes(const volume::Geometry& nodes, const Tissue& tissue,
                             int num_threads) const;

  const volume::Geometry& nodes() const { return grid_->geometry(); }
  const SlidingGrid& grid() const { return *grid_; }
  const SlidingGrid::Field& displacement_voxels() const { return displacement_; }

 private:
  std::shared_ptr<const SlidingGrid> grid_;
  SlidingGrid::Field displacement_;
};

/// What is left of the difference between reference and phase, in units of contrast.
struct Residual {
  double before = 0.0;  ///< Root mean square over the tissue.
  double after = 0.0;
};

/// Minimises, over displacements u on a grid, coarse to fine,
///
///   sum |I(X + u) - R(X)|^2 / (2 noise^2) + smoothness / 2 * sum over neighbours |u - u'|^2
///
/// by Gauss-Newton steps, with the second sum as in SlidingGrid. Robust: differences far above the
/// noise count less (Geman & McClure). The same bits for any number of threads.
class PhaseRegistration {
 public:
  /// @throws InputError for settings that are out of range, or if there is no tissue.
  PhaseRegistration(const volume::CtVolume& reference, const Tissue& tissue,
                    const RegistrationSettings& settings, const RunContext& context);

  /// @param start  The field of a neighbour in time; null: nothing has moved.
  /// @throws InputError if the phase lies on another grid than the reference.
  PhaseField Register(const volume::CtVolume& phase, const PhaseField* start,
                      const RunContext& context, Residual* residual = nullptr) const;

  /// I(X + u) - R(X) on the finest grid, in units of contrast; 0 where there is no tissue.
  /// @param field  Null: nothing has moved.
  volume::Grid<float> Difference(const volume::CtVolume& phase, const PhaseField* field,
                                 int num_threads) const;

 private:
  struct Level {
    std::shared_ptr<const SlidingGrid> grid;
    std::shared_ptr<const ModelImage> reference;
    std::vector<float> trust;  ///< Of each node: less at the wall, where voxels hold both sides.
  };
  volume::Grid<float> Difference(const ModelImage& phase, const PhaseField* field) const;
  SlidingGrid::Field Refine(const Level& level, const ModelImage& phase, SlidingGrid::Field u,
                            int num_threads) const;

  RegistrationSettings settings_;
  volume::Geometry ct_;
  std::vector<Level> levels_;  ///< Finest first.
};

}  // namespace acus::breathing_registration
