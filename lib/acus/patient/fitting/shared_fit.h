// Build-up and relaxation of a whole recording: what all its phases share. A part of FitMechanical.
#pragma once

#include <span>
#include <vector>

#include "acus/patient/fitting/curve_phases.h"
#include "acus/patient/fitting/mechanical_model.h"
#include "acus/patient/fitting/profile_fit.h"
#include "acus/patient/fitting/series_fit.h"

namespace acus::fitting {

/// Parameters of the shared part, in this order; lengths and times as logarithms, a later time as
/// its ratio to the one before, a later share as that of what those before leave.
enum Shared {
  kBuildupIn,
  kBuildupOut,
  kFirstShare,
  kSecondShare,
  kLogTau,
  kLogRatio,
  kThirdShare,
  kThirdLogRatio,
  kNumShared
};

void SetShared(std::span<const double> p, MechanicalModel& model);

/// What a recording with these phases has to say; the rest is held.
std::vector<SeriesParameter> SharedParameters(bool has_hold, bool has_out, int branches);

/// The recording, thinned phase by phase.
struct PhaseSamples {
  ForceCurve all;  ///< Force without offset and drift.
  SampleRange in;
  SampleRange hold;
  SampleRange out;
};

/// @param model  gives offset and drift.
PhaseSamples ThinPhases(const ForceCurve& curve, const CurvePhases& phases,
                        const MechanicalModel& model, double step_s);

/// The strain of the mechanical model, by sample.
std::vector<ContactStrain> Strains(const MechanicalModel& model, const ForceCurve& samples);

/// Samples of `range` inside the tissue at which all of the contact is strained in its direction.
StrainedRows RowsOf(const ForceCurve& samples, const std::vector<ContactStrain>& strain,
                    const SampleRange& range, bool inwards, double surface_mm);

/// The rows of the insertion or retraction when `model` goes through the thinned recording.
StrainedRows PhaseRows(const MechanicalModel& model, const ForceCurve& curve,
                       const CurvePhases& phases, bool inwards, double step_s);

/// Everything from the end of the insertion to the begin of the retraction (or the end).
SampleRange HoldRange(const CurvePhases& phases);

/// Fits the shared part; the profiles follow from it by linear least squares, events stay as they
/// are.
class SharedFit {
 public:
  SharedFit(const PhaseSamples& samples, MechanicalModel start);

  /// Predicts all samples, with profiles fitted to these shared parameters.
  void Predict(std::span<const double> p, std::span<double> predicted);

  SeriesFit Run(const std::vector<SeriesParameter>& parameters, bool weight_is_information);

  /// Weights each phase by what remains in it, and how many independent samples that is. Without
  /// it every phase has the same weight.
  void WeighByResidual(std::span<const double> p);

  const MechanicalModel& model() const { return model_; }

 private:
  void FitProfiles(const std::vector<ContactStrain>& strain);
  void FitOne(const StrainedRows& rows, ResistanceProfile& profile) const;

  const PhaseSamples& samples_;
  MechanicalModel model_;
  std::vector<double> weight_;
};

}  // namespace acus::fitting
