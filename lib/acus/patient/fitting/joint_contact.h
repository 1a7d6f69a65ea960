// Build-up and relaxation that several recordings share. A part of FitJoint.
#pragma once

#include <span>

#include "acus/patient/fitting/joint_fit.h"

namespace acus::fitting {

/// Fits the build-up travels and the relaxation of `model` to the holds and the first 4 mm of the
/// withdrawals of all recordings at once, each phase of each recording with the same weight, its
/// profiles held. Medians of the recordings' own are no law that any of them follows: the mean
/// force after a reversal is. Starts from what the model has, keeps its number of relaxing
/// branches, and leaves it as it is if the fit does not converge or no recording has a hold.
void FitJointContact(std::span<const JointRecording> recordings, MechanicalModel& model);

}  // namespace acus::fitting
