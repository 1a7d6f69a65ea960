// Vessels, bile ducts and a lesion put into a CT whose liver shows none.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"
#include "acus/patient/phantom/anatomy/duct_tree.h"

namespace acus::phantom {

struct LiverDuctSettings {
  double vessel_mm = 10.0;   ///< Diameter of the vessel's root; 0: no vessels.
  double duct_mm = 7.0;      ///< Of the bile duct's root; 0: none.
  double thinnest_mm = 1.8;  ///< Diameter below which a branch does not fork.
  double margin_mm = 2.0;    ///< To the liver's border, other structures in it, and each other.
  std::array<double, 3> lesion_mm = {16.0, 16.0, 16.0};  ///< Diameters along LPS axes; 0: none.
  std::optional<Eigen::Vector3d> lesion_at_mm;           ///< Its centre, LPS; else at random.
  std::optional<Eigen::Vector3d> root_at_mm;             ///< Near where both trees begin, LPS.
  double vessel_hu = 150.0;
  double duct_hu = 10.0;
  double lesion_hu = 62.0;
};

struct Lesion {
  Eigen::Vector3d centre_mm;
  Eigen::Array3d radius_mm;
};

struct LiverDucts {
  volume::CtVolume ct;
  volume::LabelMap labels;
  std::vector<DuctSegment> vessels, ducts;
  std::optional<Lesion> lesion;
};

/// Grows the trees where the label map says liver, and puts them into labels (vessel, gallbladder,
/// lesion) and CT. A voxel of which the share c lies in a structure becomes
///   HU + c (requested HU - mean HU of the CT over the voxels that lie in it whole),
/// so that noise and texture stay, and that mean is the one requested.
/// @throws InputError if the labels lie on another grid or hold no liver, a setting is out of
///     range, or the place of the lesion is not in the liver by margin and radius.
/// @throws NoAnswerError if a root or the lesion fits nowhere.
LiverDucts PutDuctsIntoLiver(const volume::CtVolume& ct, const volume::LabelMap& labels,
                             const LiverDuctSettings& settings, const RunContext& context);

/// Writes ct.nrrd, labels.seg.nrrd, ducts.csv (tree, segment, parent, from and to in CT space LPS
/// mm, radius_mm), ducts.json (settings, lesion) and provenance.json into a new folder, whole or
/// not at all.
void WriteLiverDucts(const std::filesystem::path& folder, const LiverDucts& ducts,
                     const LiverDuctSettings& settings, const RunContext& context);

/// What was put in, for people.
std::string LiverDuctsText(const LiverDucts& ducts);

}  // namespace acus::phantom
