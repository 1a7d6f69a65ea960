// What a live session records besides poses: the patient's breath and what the user ordered.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "acus/base/core/run_context.h"

namespace acus::session {

enum class BreathStatus : std::uint8_t {
  kBreathing,  ///< As the belt, or whoever breathes, says.
  kHeld,       ///< On command; slowing down and picking up again included.
  kPredicted,  ///< The belt's readings are late: continued from the last ones.
  kLost,       ///< They have been gone for too long: held where it was.
};

/// The word of breathing.csv: "BREATHING", "HELD", ...
std::string_view NameOf(BreathStatus status);

/// The breath at a moment, in terms of a normal one.
struct BreathSample {
  std::int64_t time_ns = 0;
  double cycle = 0.0;        ///< [0, 1): 0 at end inspiration.
  double level = 1.0;        ///< 1 at end inspiration, 0 at end expiration; deeper ones go beyond.
  double level_per_s = 0.0;  ///< Its rate.
  BreathStatus status = BreathStatus::kBreathing;
};

/// In order of time (strictly increasing).
using BreathStream = std::vector<BreathSample>;

/// The sample at a time: that of the recording if there is one, else between its neighbours; before
/// the first and after the last, that one. @pre stream is not empty.
BreathSample BreathAt(const BreathStream& stream, std::int64_t time_ns);

/// What the user can order in a live session.
enum class CommandKind : std::uint8_t {
  kHoldBreath,
  kBreatheOn,
  kFreezeImage,
  kRunImage,
  kMarkTarget,
  kSwapHands,
  kGain,   ///< value: dB.
  kDepth,  ///< value: mm.
  kView,   ///< value: number of the view.
  kPauseForces,
  kResumeForces,
  kPlunger,  ///< value: force of the thumb on the plunger of a syringe, N; below 0: pulls.
};

/// No thumb presses harder.
inline constexpr double kMostPlungerN = 100.0;

/// The word of commands.csv: "hold_breath", ...
std::string_view NameOf(CommandKind kind);

struct Command {
  std::int64_t time_ns = 0;  ///< Of the step that took it.
  CommandKind kind = CommandKind::kMarkTarget;
  double value = 0.0;
};

inline constexpr std::string_view kBreathHeader = "time_s,cycle,level,level_per_s,status";
inline constexpr std::string_view kCommandHeader = "time_s,value,command";

/// Appends one row with its line end. @throws InputError if a number is not finite.
void AppendBreathRow(std::string& text, const BreathSample& sample);
void AppendCommandRow(std::string& text, const Command& command);

/// Strict, except for a last line that is cut off. Commands may come at the same time.
/// @throws InputError at file:row.
BreathStream ReadBreathCsv(const std::filesystem::path& path, const RunContext& context);
std::vector<Command> ReadCommandsCsv(const std::filesystem::path& path, const RunContext& context);

}  // namespace acus::session
