// The part of a patient that a frame may show, as the ultrasound model reads it.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/scene/frame_registration/frame_similarity.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/beam_settings.h"

namespace acus::frame_registration {

struct FramePatient {
  std::optional<volume::CtVolume> ct;
  std::optional<volume::LabelMap> labels;
  simulation::ApertureSettings settings;

  /// References into this.
  SimulatedTissue tissue() const;
};

/// Reads the inputs of the scenario's ultrasound, and keeps the part within `margin_mm` of the
/// field of view at the start.
/// @param background  Tissue of unlabelled voxels, also beyond the map; empty: outside the body.
/// @throws InputError if the scenario has no ultrasound of the model `aperture`, a file is missing
///     or broken, or nothing of the patient lies in the field of view.
FramePatient ReadFramePatient(const scenario::Scenario& scenario, const std::string& background,
                              const acoustics::Probe& probe, const Eigen::Isometry3d& start,
                              double margin_mm, RunContext& context);

/// The same part of labels. @throws InputError as above.
volume::LabelMap LabelsAround(const volume::LabelMap& labels, const Eigen::AlignedBox3d& box_mm,
                              const std::string& background);

/// The field of view of a probe at a pose, grown by a margin, along the axes of CT (LPS).
Eigen::AlignedBox3d FieldOfViewBox(const acoustics::Probe& probe,
                                   const Eigen::Isometry3d& ct_from_probe, double margin_mm);

}  // namespace acus::frame_registration
