// From exact anatomy to what a scanner gives: CT with partial volume, blur and noise, and labels.
#pragma once

#include <array>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"
#include "acus/patient/phantom/anatomy/anatomy.h"

namespace acus::phantom {

struct ScannerSettings {
  std::array<double, kNumMaterials> hu{};  ///< By Material.
  int supersampling = 2;  ///< Points per axis in voxels that hold more than one material; 1 to 8.
  double psf_sigma_mm = 0.5;  ///< Of the Gaussian point-spread function; 0 = none.
  double noise_sd_hu = 10.0;  ///< Standard deviation in the image; 0 = none.
};

struct Scan {
  volume::CtVolume ct;
  volume::LabelMap labels;  ///< Exact at every voxel's centre.
};

/// CT: mean HU of the materials in each voxel, blurred, plus noise whose grain is about two voxels
/// wide in the slice. Depends on context.seed, not on context.num_threads.
Scan RenderScan(const Anatomy& anatomy, const volume::Geometry& geometry,
                const ScannerSettings& settings, const RunContext& context);

}  // namespace acus::phantom
