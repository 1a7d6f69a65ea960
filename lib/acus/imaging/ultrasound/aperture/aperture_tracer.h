// Follows scan lines through the acoustic volume: what they lose, what scatters, where interfaces
// are.
#pragma once

#include <vector>

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/ultrasound/aperture/aperture_field.h"
#include "acus/imaging/ultrasound/aperture/aperture_options.h"
#include "acus/imaging/ultrasound/beams/acoustic_volume.h"
#include "acus/imaging/ultrasound/beams/beam_filter.h"
#include "acus/imaging/ultrasound/beams/beam_path.h"

namespace acus::ultrasound {

/// One plane of the slice, on the rows of tissue.
struct AperturePlane {
  BeamPath path;
  double weight = 1.0;  ///< The sum over planes is 1.
};

/// Tissue is looked up on rows that are as far apart as half a voxel, coarser than the samples.
class ApertureTracer {
 public:
  static constexpr int kLanesPerBlock = 64;

  /// Where a line passes through an interface.
  struct Crossing {
    float row;   ///< Place, in rows of tissue; not whole.
    float lead;  ///< Rows by which its smoothed slope begins before it.
    int line;
    float weight;            ///< Of its plane.
    float reflection;        ///< Fresnel's at normal incidence, with its sign.
    Eigen::Vector3f index;   ///< Of the tissue at rest, voxels.
    Eigen::Vector3f step;    ///< To the next row, voxels.
    Eigen::Vector3f across;  ///< To a line beside, voxels.
  };

  /// Amplitudes that come back of what arrives at an interface, with the weight of its plane.
  struct SurfaceEcho {
    float mirror = 0.0F;
    float rough = 0.0F;  ///< Before the roughness of the surface takes from it.
  };

  /// Keeps references to all of them.
  /// @param grid  Rows of tissue.
  /// @param fine_per_row  Samples of the image between two rows, which `filter` counts in.
  ApertureTracer(const AcousticVolume& volume, const ApertureOptions& options,
                 const BeamFilter& filter, const acoustics::ScanGrid& grid,
                 const Eigen::Array3d& spacing_mm, int fine_per_row, double wavelength_mm);

  int blocks() const { return static_cast<int>(work_.size()); }

  /// Fills 64 lines of the field's losses and of scatter2(). Blocks are independent.
  void TraceBlock(const std::vector<AperturePlane>& planes, int block, ApertureField& field);

  /// No echo is stronger than this times its reflection and weight: an oblique surface lies in the
  /// pulse for a part of the beam's width only, and its echo is raised by this at most.
  static constexpr double kMostObliqueGain = 6.0;

  SurfaceEcho EchoOf(const Crossing& at) const;

  const std::vector<Crossing>& crossings(int block) const {
    return work_[static_cast<std::size_t>(block)].crossings;
  }
  /// Square of the speckle's amplitude at a row, by line.
  const float* scatter2(int row) const { return scatter2_.row(row); }
  float* scatter2(int row) { return scatter2_.row(row); }
  /// By line: 1 where the face touches gel or skin, 0 where it looks into air.
  const std::vector<float>& contact() const { return contact_; }
  /// The same over the width of a few elements, which radiate together.
  const std::vector<float>& SmoothContact();

 private:
  /// State of the lines of a block in one plane.
  struct PlaneState {
    alignas(64) float previous[kLanesPerBlock];
    alignas(64) float start[kLanesPerBlock];
    alignas(64) float moment[kLanesPerBlock];
    int quiet_until[kLanesPerBlock];  ///< Interfaces above are gel and skin.
    bool dry[kLanesPerBlock];         ///< Nothing but air so far.
  };
  struct Work {
    alignas(64) float zeta[kLanesPerBlock];
    alignas(64) float nepers[kLanesPerBlock];
    alignas(64) float scatter[kLanesPerBlock];
    alignas(64) float seen[kLanesPerBlock];
    alignas(64) float run[kLanesPerBlock];
    alignas(64) float place[kLanesPerBlock];
    std::vector<PlaneState> planes;
    std::vector<Crossing> crossings;
  };
  /// One row of a block in one plane.
  struct Pass {
    const AperturePlane& plane;
    PlaneState& state;
    int block;
    int first;  ///< Line that is lane 0.
    int lanes;
    bool first_plane;
    double weight_so_far;  ///< Of this plane and those before it.
  };

  void TraceRow(const Pass& pass, int k, ApertureField& field);
  void MeetSkin(Work& work, const Pass& pass, int k);
  void AddCrossings(const Pass& pass, int k, ApertureField& field);

  const AcousticVolume& volume_;
  const ApertureOptions& options_;
  const BeamFilter& filter_;
  const acoustics::ScanGrid& grid_;
  Eigen::Array3d spacing_mm_;
  int fine_per_row_;
  double wave_number_per_mm_;
  int gel_rows_;
  int skin_rows_;
  float min_run_;        ///< Of zeta, over one interface.
  float strong_nepers_;  ///< Two-way, per mm, of bone and gas.
  slicing::BeamImage scatter2_;
  std::vector<float> contact_;
  std::vector<float> smooth_contact_;
  std::vector<Work> work_;
};

}  // namespace acus::ultrasound
