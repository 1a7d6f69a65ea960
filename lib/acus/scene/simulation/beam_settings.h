// Settings of the models in beam space, `beams` and `aperture`, from a scenario.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>

#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/tissue_acoustics.h"
#include "acus/imaging/ultrasound/aperture/aperture_tissue.h"
#include "acus/scene/scenario/ultrasound_effect.h"

namespace acus::simulation {

struct BeamSettings {
  ultrasound::BeamOptions options;
  acoustics::TissueAcousticsTable acoustics;
  bool from_ct = false;
  bool from_labels = true;
  std::map<std::string, Eigen::Vector3d> fibres_in_ct;  ///< By tissue name, at rest.
};

struct ApertureSettings {
  ultrasound::ApertureOptions options;
  acoustics::TissueAcousticsTable acoustics;
  bool from_ct = true;
  bool from_labels = true;
  std::map<std::string, Eigen::Vector3d> fibres_in_ct;  ///< By tissue name, at rest.
  /// What all renderers of the scene share.
  std::shared_ptr<ultrasound::ApertureTissueStore> store =
      std::make_shared<ultrasound::ApertureTissueStore>();
};

/// @param labels  As below.
/// @throws InputError listing all problems of the table.
ApertureSettings ReadApertureSettings(const scenario::UltrasoundEffect& effect,
                                      const volume::LabelMap* labels);

/// @param labels  Gives the fibre directions of tissues without one in the scenario, if the table
///     says that they have fibres and an effect shows it; may be null.
/// @throws InputError listing all problems of the table.
BeamSettings ReadBeamSettings(const scenario::UltrasoundEffect& effect,
                              const volume::LabelMap* labels);

}  // namespace acus::simulation
