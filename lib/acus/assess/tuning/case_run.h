// One run of one setting: the session through Simulation::Step and the images of the probe, with
// time and memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "acus/assess/tuning/measured.h"
#include "acus/assess/tuning/series.h"
#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::tuning {

/// The scene whose parameters are varied, and the part of the session.
struct SweptScene {
  std::filesystem::path scenario;           ///< acus-scenario file.
  std::vector<scenario::Override> changes;  ///< From the command line, for all settings.
  std::filesystem::path session;
  /// Seconds since the session began. Earlier samples are stepped, but neither timed nor compared.
  double from_s = 0.0;
  double to_s = 0.0;      ///< 0: to its end.
  int most_images = 100;  ///< Evenly spaced over that time, if the scenario's rate gives more.
};

/// The settings of one run.
struct RunSettings {
  std::vector<scenario::Override> changes;  ///< In addition to the scene's.
  double step_rate_hz = 0.0;                ///< 0: as recorded.
  std::uint64_t seed = 0;
};

struct CaseRun {
  Measured measured;  ///< All except errors, knob, setting and repetition.
  Series series;
};

/// The session up to `to_s`, read with the scenario's options. @throws InputError
session::Session ReadSessionOf(const SweptScene& scene, const scenario::Scenario& scenario,
                               const RunContext& context);

/// Median rate of the samples that drive the steps, needle or probe; 0 if there is none.
double RecordedRateHz(const session::Session& session);

/// The session as a tracker of another rate would have recorded it: the driving tool at k / rate_hz
/// since its first sample, interpolated between the recorded poses. @pre rate_hz > 0.
session::Session Resampled(const session::Session& session, double rate_hz);

/// The changes of a scenario by `seed`: it is added to the scenario's own seeds, of speckle and of
/// breath that varies. None if the scene has nothing random.
std::vector<scenario::Override> SeedChanges(const scenario::Scenario& scenario, std::uint64_t seed);

/// Runs a setting. The series has the same bits each time; times are of one thread.
/// @throws InputError if the scene does not allow the setting, or an input is not usable.
CaseRun RunCase(const SweptScene& scene, const RunSettings& settings, RunContext& context);

}  // namespace acus::tuning
