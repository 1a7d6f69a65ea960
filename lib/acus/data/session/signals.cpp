#include "acus/data/session/signals.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/counted.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/data/session/csv_rows.h"
#include "acus/data/session/pose_csv.h"

namespace acus::session {
namespace {

// In the order of the enumerations. No word begins another: a cut-off line must not pass for one.
constexpr std::array<std::string_view, 4> kBreathWords = {"BREATHING", "HELD", "PREDICTED", "LOST"};
constexpr std::array<std::string_view, 12> kCommandWords = {
    "hold_breath", "breathe_on", "freeze_image", "run_image",    "mark_target",   "swap_hands",
    "gain_db",     "depth_mm",   "view",         "pause_forces", "resume_forces", "plunger_n"};
constexpr std::array<std::string_view, 5> kBreathColumns = {"time_s", "cycle", "level",
                                                            "level_per_s", "status"};
constexpr std::array<std::string_view, 3> kCommandColumns = {"time_s", "value", "command"};
constexpr double kMostLevel = 1e6;  // No breath is a million normal ones.

}  // namespace

std::string_view NameOf(BreathStatus status) {
  return kBreathWords[static_cast<std::size_t>(status)];
}

std::string_view NameOf(CommandKind kind) {
  return kCommandWords[static_cast<std::size_t>(kind)];
}

BreathSample BreathAt(const BreathStream& stream, std::int64_t time_ns) {
  ACUS_ASSERT(!stream.empty());
  const auto after = std::ranges::lower_bound(stream, time_ns, {}, &BreathSample::time_ns);
  if (after == stream.end()) return stream.back();
  if (after == stream.begin() || after->time_ns == time_ns) return *after;
  const BreathSample& a = *(after - 1);
  const BreathSample& b = *after;
  const double share =
      static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
  // The cycle goes round at 1.
  const double turn = b.cycle - a.cycle;
  const double cycle = a.cycle + share * (turn - std::round(turn));
  return {.time_ns = time_ns,
          .cycle = cycle - std::floor(cycle),
          .level = a.level + share * (b.level - a.level),
          .level_per_s = a.level_per_s + share * (b.level_per_s - a.level_per_s),
          .status = b.status};
}

void AppendBreathRow(std::string& text, const BreathSample& sample) {
  text += SecondsText(sample.time_ns);
  for (const double value : {sample.cycle, sample.level, sample.level_per_s}) {
    text += ',';
    text += NumberText(value);
  }
  text += ',';
  text += NameOf(sample.status);
  text += '\n';
}

void AppendCommandRow(std::string& text, const Command& command) {
  text += SecondsText(command.time_ns) + ',' + NumberText(command.value) + ',';
  text += NameOf(command.kind);
  text += '\n';
}

BreathStream ReadBreathCsv(const std::filesystem::path& path, const RunContext& context) {
  CsvRows rows(path, kBreathColumns, kBreathWords, context);
  BreathStream stream;
  stream.reserve(rows.size() / 60);
  std::size_t num_repeated = 0;
  while (rows.Next()) {
    const BreathSample sample{.time_ns = rows.TimeNs(0),
                              .cycle = rows.Number(1),
                              .level = rows.Number(2),
                              .level_per_s = rows.Number(3),
                              .status = static_cast<BreathStatus>(rows.Word())};
    ACUS_REQUIRE(sample.cycle >= 0.0 && sample.cycle < 1.0, rows.Where(), ": cycle is ",
                 sample.cycle, "; it must be at least 0 and less than 1");
    ACUS_REQUIRE(std::abs(sample.level) <= kMostLevel && std::abs(sample.level_per_s) <= kMostLevel,
                 rows.Where(), ": level and level_per_s must lie within +-", kMostLevel);
    if (rows.IsRepeated()) {
      ++num_repeated;
    } else {
      stream.push_back(sample);
    }
  }
  if (num_repeated > 0) {
    context.Warn(Message(path.string(), ": ",
                         Counted(num_repeated, "row# with the time stamp of the row before"),
                         " omitted; the first of each is kept"));
  }
  return stream;
}

std::vector<Command> ReadCommandsCsv(const std::filesystem::path& path, const RunContext& context) {
  CsvRows rows(path, kCommandColumns, kCommandWords, context);
  std::vector<Command> commands;
  while (rows.Next()) {
    const auto time_ns = NanosecondsFromText(rows.Cell(0));
    ACUS_REQUIRE(time_ns.has_value(), rows.Where(), ": time_s is '", rows.Cell(0),
                 "'; a finite number of seconds within +-", kMaxTimeS, " is needed");
    ACUS_REQUIRE(commands.empty() || *time_ns >= commands.back().time_ns, rows.Where(),
                 ": time_s is ", rows.Cell(0), ", before the command above; sort the rows");
    const Command command{*time_ns, static_cast<CommandKind>(rows.Word()), rows.Number(1)};
    ACUS_REQUIRE(command.kind != CommandKind::kPlunger || std::abs(command.value) <= kMostPlungerN,
                 rows.Where(), ": the plunger's force is ", command.value, " N; allowed: -",
                 kMostPlungerN, " to ", kMostPlungerN);
    commands.push_back(command);
  }
  return commands;
}

}  // namespace acus::session
