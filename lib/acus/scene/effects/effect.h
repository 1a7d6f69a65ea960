// The interface of an effect, a physical process or an image that a scenario may name. Schema,
// plan, loader, steps, logs, reports, live sessions and sweeps use effects through this interface
// only.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/scene/effects/knob.h"
#include "acus/scene/effects/port.h"
#include "acus/scene/effects/stage.h"

namespace acus::effects {

/// How a path among an effect's settings is looked for.
enum class PathKind {
  kFile,    ///< Relative to the scenario file.
  kPreset,  ///< Also among the installed configs.
};

/// A path among an effect's settings. If a stage reads the port, the file has to be there.
struct PathSetting {
  std::string key;  ///< Key in the settings: "centrelines".
  PathKind kind = PathKind::kFile;
  PortRef port;
};

/// A stage, as the plan sees it.
struct StageDeclaration {
  std::string_view name;  ///< "pulse"; of static storage.
  std::vector<PortRef> reads;
  std::vector<PortRef> writes;
  /// Read where the scene has it, and done without elsewhere.
  std::vector<PortRef> optional_reads = {};
  /// True: there for the effect's own sake. False: only if another stage reads what it writes.
  bool is_goal = true;
};

/// When a stage at every image renders.
struct ImageTiming {
  /// Per second of session time; 0: at all moments of the scene's images.
  double rate_hz = 0.0;
  /// True: over the whole session at that rate. False: at moments of the scene's images, as many of
  /// them as come nearest to the rate.
  bool has_own_moments = false;
  bool is_live = true;  ///< False: in replays only.
};

/// A number that the effect's stage writes down at every sample.
struct Column {
  std::string name;   ///< With its unit: "radius_mm".
  std::string title;  ///< Title of the plot in reports.
  std::string unit;
  /// If not empty, the column is a count, and each time that it rises is an event of this name,
  /// "loss_of_resistance": in events.csv, the report and the markups.
  std::string event = {};
  bool over_depth = false;  ///< Reports also plot it over the depth of the needle.
};

/// A number that a session is judged by.
struct MeasuredValue {
  std::string name;  ///< "largest injection pressure"; goals of exercises refer to it.
  std::string unit;  ///< Empty for a count.
  double value = 0.0;
};

/// What an effect measures over a session, in a replay or while a live session runs.
class EffectMeter {
 public:
  virtual ~EffectMeter() = default;
  /// Each step in turn. @param columns  Those of the effect.
  virtual void Add(double session_s, std::span<const double> columns) = 0;
  /// As far as the session has come; also rows of the metrics of a run.
  virtual std::vector<MeasuredValue> Values() const = 0;
  /// Sentences for the effect's part of a report.
  virtual std::vector<std::string> Findings() const { return {}; }
};

/// What an effect has loaded for a scene. Const from then on; shared by all threads.
class LoadedEffect {
 public:
  virtual ~LoadedEffect() = default;
  /// Null if the effect has no such stage.
  virtual const StepStage* step() const { return nullptr; }
  /// A new one for each caller; null if the effect has no such stage. Must outlive neither this nor
  /// the scene.
  /// @param scene  Constant values: patient, presets, ports::kMotionField.
  /// @param context  Has the number of threads that it may use.
  /// @throws InputError if a setting does not fit the patient.
  virtual std::unique_ptr<ImageStage> NewImageStage(const PortValues& /*scene*/,
                                                    const RunContext& /*context*/) const {
    return nullptr;
  }
  /// A new one for each session; null if the effect measures nothing.
  virtual std::unique_ptr<EffectMeter> NewMeter() const { return nullptr; }
};

/// A kind of effect. One object for each, of static storage.
class Effect {
 public:
  virtual ~Effect() = default;

  /// Key among the scenario's effects: "pulsating_vessels". Also names its log files.
  virtual std::string_view key() const = 0;
  /// "Pulsating vessels": heads its part of a report.
  virtual std::string_view title() const = 0;
  /// Its part of the scenario's schema. The "description" is its line in the reference.
  virtual nlohmann::json Schema() const = 0;
  virtual std::vector<PathSetting> Paths() const { return {}; }
  /// Finds the files that Paths() cannot name, those within lists, from the scenario's folder.
  /// @param settings  May be without what is optional. @throws InputError if one is not there.
  virtual void ResolveFiles(nlohmann::json& /*settings*/,
                            const std::filesystem::path& /*folder*/) const {}
  /// Checks conditions that the schema cannot express; the settings are complete.
  /// @param where  Names the place in error messages. @throws InputError if they do not fit.
  virtual void Check(const nlohmann::json& /*settings*/, const std::string& /*where*/) const {}

  /// At every sample, and at every image. Nothing if the settings call for no such stage.
  virtual std::optional<StageDeclaration> StepStageOf(const nlohmann::json& /*settings*/) const {
    return std::nullopt;
  }
  virtual std::optional<StageDeclaration> ImageStageOf(const nlohmann::json& /*settings*/) const {
    return std::nullopt;
  }
  virtual ImageTiming TimingOf(const nlohmann::json& /*settings*/) const { return {}; }
  /// What the stage at every sample logs; at most kMaxColumns for all effects of a scene together.
  virtual std::vector<Column> Columns() const { return {}; }
  virtual std::vector<Knob> Knobs() const { return {}; }

  /// @param settings  As the schema checked and completed them; paths are absolute.
  /// @param scene  Holds what the stages read of the patient and of presets.
  /// @throws InputError if a file is not readable or a setting does not fit the patient.
  virtual std::unique_ptr<const LoadedEffect> Load(const nlohmann::json& settings,
                                                   const PortValues& scene,
                                                   RunContext& context) const = 0;
};

/// Number of columns that all effects of a scene together may log in a step.
inline constexpr std::size_t kMaxColumns = 32;

}  // namespace acus::effects
