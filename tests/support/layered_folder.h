// The layered patient on disk, for tests that read scenarios.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/volume_io.h"
#include "support/layered_scene.h"

namespace acus::testing_support {

/// Writes ct.nrrd, labels.seg.nrrd and scene.json, of a scenario with this patient, a linear probe
/// and these effects (JSON). Presets come from the source tree from then on.
inline void WriteLayeredFolder(const std::filesystem::path& folder, const std::string& effects,
                               int image_rate_hz = 30) {
  const auto scene = LayeredScene(PlanOf(true, true, true, true), true);
  volume::WriteCt(folder / "ct.nrrd", *scene.ct);
  volume::WriteLabelMap(folder / "labels.seg.nrrd", *scene.labels);
  WriteTextFile(folder / "scene.json",
                Message(R"({"format": "acus-scenario/1", "name": "Layers",
      "patient": {"ct": "ct.nrrd", "labels": "labels.seg.nrrd",
        "ct_from_reference": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
      "probe": "probes/linear_l14.json", "effects": )",
                        effects, R"(, "image_rate_hz": )", image_rate_hz, "}"));
  setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
}

}  // namespace acus::testing_support
