// The range of the force on the needle over patients whose tissue is softer or stiffer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/base/report/svg_plot.h"
#include "acus/data/session/session.h"
#include "acus/run/replay/run_metrics.h"
#include "acus/run/replay/step_log.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/effect_plan.h"

namespace acus::replay {

/// Forces of other patients along the motion of one session. The hand's motion is the recorded one
/// in all of them: what a hand would do otherwise in stiffer tissue is not in it.
struct PatientRange {
  struct Patient {
    std::uint64_t seed = 0;       ///< /patient/stiffness/seed that replays this patient.
    std::vector<Metric> metrics;  ///< Those of the force on the needle.
  };
  std::vector<Patient> patients;  ///< By ascending seed.
  /// Quantiles over the patients of the force along the needle at each step, N.
  std::vector<double> p5_n, median_n, p95_n;
};

/// Runs the steps of `session` for scenario.patient.num_others other patients: those of the seeds
/// from 1 on, without the scenario's own. Nothing is rendered for them.
/// @throws InputError as simulation::LoadScene.
PatientRange RangeOverPatients(const scenario::Scenario& scenario, const session::Session& session,
                               const simulation::AvailableInputs& available,
                               const RunContext& context);

/// other_patients.csv: the metrics of each patient. other_patients_range.csv: the quantiles at each
/// step of `log`. @throws IoError if a file cannot be written.
void WriteRange(const std::filesystem::path& folder, const PatientRange& range, const StepLog& log);

/// For the report: the force of this patient over the band of the others, by time.
report::Plot RangePlot(const PatientRange& range, const StepLog& log);

/// "largest axial force" in N by patients: this one, and quantiles of the others.
struct RangeTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};
RangeTable TableOf(const PatientRange& range, const std::vector<Metric>& of_this);

}  // namespace acus::replay
