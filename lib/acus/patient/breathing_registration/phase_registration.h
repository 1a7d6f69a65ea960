// Deformable registration of the phases of a 4D CT to its reference, with organs that slide.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/breathing_registration/entered_tissue.h"
#include "acus/patient/breathing_registration/error_bound.h"
#include "acus/patient/breathing_registration/level_image.h"
#include "acus/patient/breathing_registration/lung_density.h"
#include "acus/patient/breathing_registration/sliding_grid.h"

namespace acus::breathing_registration {

struct RegistrationSettings {
  /// Spacing of the finest grid; each coarser one has twice the last's. 0: DefaultSpacingMm.
  double spacing_mm = 0.0;
  int levels = 3;
  int iterations = 6;          ///< Linearisations on each grid.
  int solver_iterations = 25;  ///< Conjugate gradients in each.
  /// What strain costs against one standard deviation of noise; four times as much on each coarser
  /// grid.
  double smoothness = 0.3;
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
  PhaseField(std::shared_ptr<const SlidingGrid> grid, SlidingGrid::Field displacement_voxels,
             ErrorBound bound)
      : grid_(std::move(grid)),
        displacement_(std::move(displacement_voxels)),
        bound_(std::move(bound)) {}

  /// mm in CT space, of tissue on that side of the wall. @param rest_mm  In the reference.
  Eigen::Vector3d DisplacementMm(const Eigen::Vector3d& rest_mm, Side side) const;

  /// What the error of DisplacementMm does not exceed at 95 of 100 places: see ErrorBound.
  double BoundMm(const Eigen::Vector3d& rest_mm, Side side) const;
  /// The images show no match there.
  bool IsUnseen(const Eigen::Vector3d& rest_mm, Side side) const;
  /// Share of all tissue without a match in the images.
  double unseen_share() const { return bound_.unseen_share(); }

  /// The bound at each of other nodes, i fastest, mm; 0 where there is no tissue.
  std::vector<float> BoundOnNodes(const volume::Geometry& nodes, const Tissue& tissue,
                                  int num_threads) const;

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
  ErrorBound bound_;
};

/// 2 mm, or the longest side of a voxel if that is more, or what leaves 1.3 million nodes in the
/// tissue: ten phases then take about a minute on two cores.
double DefaultSpacingMm(const volume::Geometry& ct, const Tissue& tissue, int num_threads);

/// What remains of the difference between reference and phase, in units of contrast.
struct Residual {
  double before = 0.0;  ///< Root mean square over the tissue.
  double after = 0.0;
};

/// Minimises, over displacements u on a grid, coarse to fine,
///
///   sum |I(X + u) - R(X)|^2 / (2 noise^2) + smoothness / 2 * sum over neighbours |u - u'|^2
///
/// by Gauss-Newton steps, with the second sum as in SlidingGrid. Lung in R is as dense as it is in
/// I (LungDensity). Robust: differences far above the noise count less (Geman & McClure). What came
/// in over the border of the volume is matched to nothing (EnteredTissue); before any motion is
/// known, what is near the border is not, either. The same bits for any number of threads.
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
    float outlier = 1.0F;        ///< Difference that counts little, in units of noise.
    std::vector<float> wall_mm;  ///< Distance of each node to the wall.
    std::vector<float> trust;    ///< Of each node: less at the wall, where voxels hold both sides.
  };
  /// What one node sees: the linearised difference of the images. Nothing: all zero.
  struct Match {
    Eigen::Vector3f gradient = Eigen::Vector3f::Zero();  ///< Per voxel, in units of noise.
    float residual = 0.0F;                               ///< In units of noise.
    float root_weight = 0.0F;                            ///< 0: nothing is seen.
  };
  volume::Grid<float> Difference(const ModelImage& phase, const PhaseField* field) const;
  Match MatchOf(const Level& level, int node, const Eigen::Vector3f& u, const ModelImage& phase,
                const EnteredTissue& entered, const LungDensity& density) const;
  ErrorBound BoundOf(const ModelImage& phase, const SlidingGrid::Field& u,
                     const SlidingGrid::Field& coarser, int num_threads) const;
  SlidingGrid::Field Refine(const Level& level, const ModelImage& phase, SlidingGrid::Field u,
                            bool motion_known, int num_threads) const;

  RegistrationSettings settings_;
  volume::Geometry ct_;
  std::vector<Level> levels_;  ///< Finest first.
};

}  // namespace acus::breathing_registration
