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

/// Whose knobs are turned, over which part of which session.
struct SweptScene {
  std::filesystem::path scenario;           ///< acus-scenario file.
  std::vector<scenario::Override> changes;  ///< Of the command line, for all settings.
  std::filesystem::path session;
  /// Seconds since the session began. What is before is played, but neither timed nor compared.
  double from_s = 0.0;
  double to_s = 0.0;      ///< 0: to its end.
  int most_images = 100;  ///< Evenly over that time, if the scenario's rate makes more.
};

/// How one setting is run.
struct RunSettings {
  std::vector<scenario::Override> changes;  ///< On top of the scene's.
  double step_rate_hz = 0.0;                ///< 0: as recorded.
  std::uint64_t seed = 0;
};

struct CaseRun {
  Measured measured;  ///< All but the errors, knob, setting and repetition.
  Series series;
};

/// The session up to `to_s`, as the scenario says to read it. @throws InputError
session::Session ReadSessionOf(const SweptScene& scene, const scenario::Scenario& scenario,
                               const RunContext& context);

/// Samples per second of what steps go by, needle or probe: the median; 0 if there is none.
double RecordedRateHz(const session::Session& session);

/// The session as a tracker of another rate would have recorded it: the tool that steps go by at
/// k / rate_hz since its first sample, between the recorded poses. @pre rate_hz > 0.
session::Session Resampled(const session::Session& session, double rate_hz);

/// What `seed` changes in a scenario: it is added to the scenario's own seeds, of speckle and of
/// breath that varies. None if nothing in it is random.
std::vector<scenario::Override> SeedChanges(const scenario::Scenario& scenario, std::uint64_t seed);

/// Runs a setting. The series is the same bits each time; times are of one thread.
/// @throws InputError if the setting does not fit the scene, or an input is not usable.
CaseRun RunCase(const SweptScene& scene, const RunSettings& settings, RunContext& context);

}  // namespace acus::tuning
