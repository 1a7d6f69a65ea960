// Exports a study for other programs: folders and tables in the BIDS format.
#pragma once

#include <filesystem>

#include "acus/assess/study/study_data.h"

namespace acus::study {

/// Writes into an existing folder, after the Brain Imaging Data Structure for behaviour:
/// dataset_description.json, participants.tsv, task-TASK_beh.json with the units, and for each
/// trial sub-CODE/beh/sub-CODE_task-TASK_run-NN_beh.tsv (a column per metric) and, if the trial's
/// folder has events.csv, _events.tsv (onset, duration, trial_type, tissue, depth_mm,
/// force_axial_n). Underscores of codes are dropped: BIDS does not allow them in labels. Only with
/// consent.
/// @throws InputError if two codes differ in underscores only.
void WriteBids(const std::filesystem::path& folder, const Study& study,
               std::span<const TrialRecord> trials, const RunContext& context);

}  // namespace acus::study
