// report.html of a run: forces, images, events, metrics, effect plan, provenance.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "acus/base/core/provenance.h"
#include "acus/run/replay/image_log.h"
#include "acus/run/replay/patient_range.h"
#include "acus/run/replay/run_metrics.h"
#include "acus/run/replay/step_log.h"
#include "acus/run/training/assessment.h"

namespace acus::replay {

struct ReportContent {
  std::string title;
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<std::string> warnings;
  std::vector<Metric> metrics;
  std::optional<PatientRange> others;              ///< If other patients were run.
  std::optional<training::Assessment> assessment;  ///< If there was an exercise.
  std::vector<WrittenFilm> films;
  std::vector<WrittenPng> images;
  simulation::StageTimes times;  ///< Costs of the stages of the scene's plan.
};

/// Writes report.html and the plots of the forces, forces.svg and probe_forces.svg, into `folder`.
void WriteReport(const std::filesystem::path& folder, const ReportContent& content,
                 const StepLog& log, const simulation::Scene& scene, const Provenance& provenance);

}  // namespace acus::replay
