// The folders that acus-phantom writes: a synthetic patient, or a scene on another patient.
#pragma once

#include <filesystem>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/phantom/anatomy/phantom_config.h"
#include "acus/patient/phantom/planning/scene_request.h"

namespace acus::phantom {

/// Makes a patient from `config` and context.seed and writes ct.nrrd, labels.seg.nrrd, truth.json,
/// markers_ct.csv, markers_mannequin.csv, target_ct.csv, corridor_ct.csv, force_curves/, sessions/,
/// demonstration/ and provenance.json, as one folder, whole or not at all. Returns a summary for
/// people.
/// @throws NoAnswerError if no path leads to the target.
std::string WritePatient(const std::filesystem::path& folder, const PhantomConfig& config,
                         const RunContext& context);

/// Makes markers, target and one session on the label map of any patient: the same files without
/// CT, labels and force curves. Returns a summary for people.
/// @throws InputError if `request` names what the map lacks. @throws NoAnswerError if no path is
///     free.
std::string WriteScene(const std::filesystem::path& folder, const volume::LabelMap& labels,
                       const PhantomConfig& config, const RunContext& context,
                       const SceneRequest& request = {});

}  // namespace acus::phantom
