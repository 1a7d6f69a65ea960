// Follows scan lines down through the tissue: what arrives, what comes back.
#pragma once

#include <optional>
#include <vector>

#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/beams/beam_filter.h"
#include "acus/imaging/ultrasound/beams/beam_interface.h"
#include "acus/imaging/ultrasound/beams/beam_kernels.h"
#include "acus/imaging/ultrasound/beams/beam_march.h"
#include "acus/imaging/ultrasound/beams/beam_materials.h"
#include "acus/imaging/ultrasound/beams/beam_needle.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"
#include "acus/imaging/ultrasound/beams/beam_path.h"

namespace acus::ultrasound {

/// Half the logarithm of 1 MRayl: gas and most lung are below, all soft tissue above.
inline constexpr float kAirLogImpedance = 0.0F;

/// One elevation plane and its share of the slice.
struct ElevationPlane {
  BeamPath path;
  double weight = 1.0;          ///< Of interfaces; all sum up to 1.
  double speckle_weight = 1.0;  ///< The squares sum up to 1.
};

/// With E the amplitude that arrives, two-way, from 1 at the face (0 against air):
///   echo = E * (reflection of an interface that lies here) + E * backscatter * noise,
///   E    = E * (1 - R^2) behind an interface, and * exp(-2 alpha step) at each sample.
class BeamTracer {
 public:
  static constexpr int kLanesPerBlock = 64;

  /// Keeps references to all of them. @throws InputError if the volumes do not fit each other.
  BeamTracer(const BeamTissue& tissue, const BeamOptions& options, const BeamMaterials& materials,
             const BeamFilter& filter, const acoustics::ScanGrid& grid,
             const Eigen::Matrix3d& lattice_from_index);

  int blocks() const { return static_cast<int>(work_.size()); }

  /// Fills lanes [64 * block, 64 * block + 64) of `out` (without margins). Blocks are independent.
  void TraceBlock(const std::vector<ElevationPlane>& planes, const BeamNeedle& needle, int block,
                  ComplexBeams& out);

 private:
  /// An echo of an interface or the needle, put in when the speckle is complete.
  struct Echo {
    int sample;
    int lane;
    float amplitude;
  };
  /// Earlier samples are kept, for interfaces that are known only when they have been passed.
  static constexpr int kRing = 16;
  static constexpr int kStrongest = 4;
  struct Strong {
    float place = 0.0F;
    float reflection = 0.0F;
  };
  struct Work {
    alignas(64) float value[kRing][kLanesPerBlock];  ///< HU, where there are no labels.
    alignas(64) std::int32_t label[kRing][kLanesPerBlock];
    alignas(64) float energy[kRing][kLanesPerBlock];
    alignas(64) float log_impedance[kLanesPerBlock];
    alignas(64) float decay[kLanesPerBlock];
    alignas(64) float scatter[kLanesPerBlock];
    alignas(64) float of_hu[3][kLanesPerBlock];
    alignas(64) float previous[kLanesPerBlock];
    alignas(64) float start[kLanesPerBlock];
    alignas(64) float moment[kLanesPerBlock];
    alignas(64) float run[kLanesPerBlock];
    alignas(64) float place[kLanesPerBlock];
    alignas(64) float lattice[6][kLanesPerBlock];
    alignas(64) float speed_ratio[kLanesPerBlock];
    BeamMarch march;
    int quiet_until[kLanesPerBlock];                   ///< Interfaces above are gel and skin.
    bool dry[kLanesPerBlock];                          ///< Nothing but air so far.
    alignas(64) std::int32_t outside[kLanesPerBlock];  ///< Not 0: the sample is not in the volume.
    alignas(64) std::int32_t entered[kLanesPerBlock];  ///< Not 0: one before was.
    bool all_entered;  ///< No line is outside, and none was before it entered.
    Strong strong[kLanesPerBlock][kStrongest];
    int strong_count[kLanesPerBlock];
    std::vector<Echo> echoes;
  };
  /// One block of one plane.
  struct Pass {
    Work& work;
    const BeamPath& path;
    ComplexBeams& out;
    const NeedleMark* mark;
    const NeedleMark* last_mark;
    double ring_samples;
    int first;  ///< Lane of the image that is lane 0 of the block.
    int lanes;
    double weight;
    double speckle_weight;
    bool add;  ///< To what other planes have left.
    // The current sample: where the lines are at s.
    slicing::kernels::Lines voxels{};
    slicing::kernels::Lines lattice{};
    float s = 0.0F;
  };
  /// Where a line passes through an interface, in the tissue at rest.
  struct Crossing {
    int k;  ///< Sample at which it is known.
    int lane;
    double place;            ///< Sample number.
    Eigen::Vector3d index;   ///< Voxel indices.
    Eigen::Vector3d step;    ///< Along the line, voxels per sample.
    Eigen::Vector3d across;  ///< To the neighbouring line, voxels.
    double first_speed;      ///< m/s, on this side and the other.
    double second_speed;
    float first;  ///< Label, or Hounsfield unit.
    float second;
  };

  void TracePlane(Pass& pass);
  void PlaceSample(Pass& pass, int k) const;
  /// @return whether a line is outside the volume.
  bool SampleTissue(Pass& pass, int k);
  /// Air in place of what was not scanned. @return whether there is any.
  bool FillOutside(Work& work, int k) const;
  void EndOfScan(Work& work, int k) const;
  void GoOn(Pass& pass, int k) const;
  void MeetSkin(Work& work, int k) const;
  void FollowFibres(Pass& pass, int k) const;
  void AnswerInterfaces(Pass& pass, int k);
  void AnswerInterface(Pass& pass, int k, int lane);
  Crossing CrossingAt(const Pass& pass, int k, int lane) const;
  /// Echo of an interface whose step of zeta is `change`; moves its place to the smooth surface.
  InterfaceEcho EchoOf(double change, Crossing& at) const;
  void RingBehind(Pass& pass, double place, double spacing, int lane, double amplitude,
                  double decay) const;
  void Reverberate(Pass& pass, double place, int lane, double amplitude, double reflection) const;
  void AnswerNeedle(Pass& pass, int k);
  void AnswerMark(Pass& pass, int k, const NeedleMark& mark) const;
  void AddEcho(Pass& pass, double place, int lane, double amplitude) const;
  void PutEchoes(Pass& pass) const;

  const BeamTissue& tissue_;
  const BeamOptions& options_;
  const BeamMaterials& materials_;
  const BeamFilter& filter_;
  const acoustics::ScanGrid& grid_;
  SurfaceNormals normals_;
  std::optional<slicing::CtSampler> sampler_;
  slicing::kernels::Voxels ct_{};
  kernels::LabelVoxels labels_{};
  Eigen::Matrix3f lattice_from_index_;
  Eigen::Array3d spacing_mm_;
  bool marched_;  ///< Lines are followed sample by sample.
  bool fibres_;
  double strong_transmission_ = 0.0;
  int gel_samples_ = 0;
  int skin_samples_ = 0;
  float min_step_ = 0.0F;
  float min_run_ = 0.0F;
  std::vector<Work> work_;
};

}  // namespace acus::ultrasound
