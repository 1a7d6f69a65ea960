// Tables of tissue acoustics in the form that the inner loops of the beam renderer read.
#pragma once

#include <array>
#include <bitset>
#include <vector>

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/ultrasound/beams/beam_kernels.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"

namespace acus::ultrasound {

/// Fibres of one label: what the beam loses along them, and how the texture stretches.
struct FibreLabel {
  int label = 0;
  Eigen::Vector3d direction_in_ct = Eigen::Vector3d::UnitX();  ///< Unit, at rest.
  /// Along the fibres, one grain of the speckle, and its dual: distance along the fibres in grains
  /// is dual.dot(place in the lattice).
  Eigen::Vector3d grain_in_lattice = Eigen::Vector3d::UnitX();
  Eigen::Vector3d dual_in_lattice = Eigen::Vector3d::UnitX();
  double extra_nepers_per_sample = 0.0;  ///< Along minus across, two-way.
  double ratio = 1.0;
};

/// By label and by Hounsfield unit, for one probe and one step between samples.
class BeamMaterials {
 public:
  /// @throws InputError if a label has no entry, or the table has too many knots over HU.
  BeamMaterials(const BeamTissue& tissue, const BeamOptions& options, const acoustics::Probe& probe,
                double step_mm);

  kernels::LabelTables label_tables() const {
    return {log_impedance_.data(), decay_.data(), scatter_.data()};
  }
  const kernels::TissueCurves& hu_curves() const { return curves_; }
  double SpeedAtLabel(int label) const { return speed_[static_cast<std::size_t>(label)]; }
  double SpeedAtHu(double hu) const;
  /// Largest amplitude of the speckle, over all labels and Hounsfield units.
  float MostScatter() const;
  const std::vector<FibreLabel>& fibres() const { return fibres_; }
  /// Turns the directions of all fibres into the lattice of the speckle.
  void TurnFibres(const Eigen::Matrix3d& lattice_from_ct, double grain_mm);

 private:
  struct Values;
  double StepMm(const acoustics::TissueAcoustics& tissue) const;
  Values ValuesOf(const acoustics::TissueAcoustics& tissue) const;
  void MakeCurves(const acoustics::TissueAcousticsTable& table);

  double frequency_mhz_;
  double step_mm_;
  double pulse_mm_;  ///< Length over which a pulse gathers intensity.
  bool time_of_flight_;
  bool attenuation_;
  bool speckle_;
  alignas(64) std::array<float, 256> log_impedance_{};
  alignas(64) std::array<float, 256> decay_{};
  alignas(64) std::array<float, 256> scatter_{};
  std::array<double, 256> speed_{};
  kernels::TissueCurves curves_;
  std::vector<double> hu_;
  std::vector<double> speed_at_hu_;
  std::vector<FibreLabel> fibres_;
};

}  // namespace acus::ultrasound
