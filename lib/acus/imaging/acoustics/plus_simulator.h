// PLUS configurations of its ultrasound simulator: probe and tissues from the XML file.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/acoustics/tissue_acoustics.h"

namespace acus::acoustics {

/// One SpatialModel that has a surface.
struct PlusSurface {
  std::string tissue;          ///< As in the acoustic table.
  volume::Label label = 0;     ///< The standard label of that name, else 128 + place in the file.
  std::string object_frame;    ///< ObjectCoordinateFrame, such as "Reference" or "NeedleTip".
  std::filesystem::path file;  ///< As written, relative to the configuration.
  Eigen::Matrix4d object_from_model = Eigen::Matrix4d::Identity();
};

struct PlusSimulator {
  Probe probe;
  TissueAcousticsTable acoustics;  ///< The model without a surface is also "outside".
  std::string reference_frame;     ///< ReferenceCoordinateFrame: that of tissue.
  std::vector<PlusSurface> surfaces;
};

/// By the extension .xml.
bool IsPlusConfiguration(const std::filesystem::path& path);

/// Reads the first ScanConversion and all SpatialModel elements. PLUS's names become names of
/// tissues in lower case with '_' ("GelBlock" -> "gelblock", "Soft tissue" -> "soft_tissue").
/// Impedance is density times speed; the backscattered share per mm is the share of the loss
/// alpha f that PLUS's BackscatterDiffuseReflectionCoefficient sends back.
/// @throws InputError naming file, element, attribute and what is allowed, if the file is not a
/// PLUS
///     configuration or has no ScanConversion or no SpatialModel.
PlusSimulator ReadPlusSimulator(const std::filesystem::path& path);

/// The probe alone: the file need not have spatial models. @throws InputError as above.
Probe ReadPlusProbe(const std::filesystem::path& path);

}  // namespace acus::acoustics
