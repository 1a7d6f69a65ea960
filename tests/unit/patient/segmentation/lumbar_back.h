// The back of a synthetic lumbar patient: exact anatomy, its CT, and the tissues found in that.
#pragma once

#include <utility>

#include "acus/patient/phantom/anatomy/imaging.h"
#include "acus/patient/phantom/anatomy/phantom_config.h"
#include "acus/patient/segmentation/patient_segmentation.h"

namespace acus::segmentation {

struct LumbarBack {
  phantom::Anatomy anatomy;
  phantom::Scan scan;  ///< With exact labels.
  volume::LabelMap found;
};

inline LumbarBack MakeLumbarBack(std::uint64_t seed) {
  auto config = phantom::ReadPhantomConfig(ACUS_SOURCE_DIR "/configs/phantoms/lumbar.json");
  config.grid.origin_mm = Eigen::Vector3d(-75, -60, -108);
  config.grid.size = {151, 146, 116};
  RunContext context;
  context.seed = seed;
  context.num_threads = 2;
  phantom::Anatomy anatomy(config.body, seed);
  phantom::Scan scan = phantom::RenderScan(anatomy, config.grid, config.scanner, context);
  const auto settings =
      ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
  volume::LabelMap found = FindTissues(scan.ct, settings.tissues, context).labels;
  return {std::move(anatomy), std::move(scan), std::move(found)};
}

}  // namespace acus::segmentation
