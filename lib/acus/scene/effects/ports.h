// The ports of a scene: what comes from outside, and what its stages write.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/physics/breathing/breath.h"
#include "acus/physics/breathing/motion_field.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "acus/physics/forces/models/force_model.h"
#include "acus/physics/forces/path/needle_sample.h"
#include "acus/physics/forces/probe/probe_sample.h"
#include "acus/scene/effects/port.h"

namespace acus::effects::ports {

/// A file that a stage reads; only its place goes through the port.
using FilePort = Port<std::filesystem::path>;

// What the session gives.
inline constexpr Port<Eigen::Isometry3d> kNeedlePoses{"needle poses"};
inline constexpr Port<Eigen::Isometry3d> kProbePoses{"probe poses"};
inline constexpr Port<breathing::Breath> kSessionBreath{"session's breath"};
/// Force in N of the thumb on the plunger of a syringe; zero where the session has none.
inline constexpr Port<double> kPlungerForce{"plunger force"};

// What the patient gives.
inline constexpr Port<volume::CtVolume> kCt{"ct"};
inline constexpr Port<volume::LabelMap> kLabels{"labels"};
inline constexpr FilePort kMesh{"mesh"};
inline constexpr FilePort kCorridor{"corridor"};

// Presets and other files.
inline constexpr Port<forces::NeedleProperties> kNeedlePreset{"needle preset"};
inline constexpr Port<acoustics::Probe> kProbePreset{"probe preset"};
inline constexpr FilePort kMotion{"motion"};
inline constexpr FilePort kBreathSignal{"breath signal"};
inline constexpr FilePort kForceTable{"force table"};
inline constexpr FilePort kMeasuredForce{"measured force"};
inline constexpr FilePort kNeedleElasticity{"needle's elasticity"};
inline constexpr FilePort kProbeForceTable{"probe's force table"};
inline constexpr FilePort kTissueElasticity{"tissue's elasticity"};
inline constexpr FilePort kTissueForceTable{"tissue's force table"};
inline constexpr FilePort kAcoustics{"acoustics"};

/// How the patient breathes; for image stages that read kBreath.
inline constexpr Port<breathing::MotionField> kMotionField{"motion field"};

// What stages at every sample write.
inline constexpr Port<breathing::Breath> kBreath{"breath"};
/// Written by any number of stages: see StepStage::RestInCtMm.
inline constexpr Port<void> kTissueMotion{"tissue motion"};
/// The same in images only: tools do not feel it.
inline constexpr Port<void> kSwelling{"swelling"};
/// The same: see StepStage::ForceIn and EchoChangeDbIn.
inline constexpr Port<void> kAddedForce{"added force"};
inline constexpr Port<void> kEcho{"echo"};
inline constexpr Port<breathing::ToolAtRest> kNeedle{"needle"};
inline constexpr Port<volume::Label> kTissue{"tissue"};
inline constexpr Port<void> kContact{"contact"};
inline constexpr Port<forces::NeedleForce> kForce{"force"};
inline constexpr Port<void> kShape{"shape"};
inline constexpr Port<forces::ProbeForce> kProbeForce{"probe force"};

// What stages at every image write.
inline constexpr Port<Eigen::Isometry3d> kProbe{"probe"};
inline constexpr Port<slicing::RestMap> kRestMap{"rest map"};
inline constexpr Port<image::GrayImage> kCtImage{"CT image"};
inline constexpr Port<image::GrayImage> kBMode{"B-mode image"};

}  // namespace acus::effects::ports
