#include <algorithm>
#include <optional>
#include <sstream>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/breathing/recorded_breath.h"

namespace acus::breathing {
namespace {

constexpr std::size_t kFewestSamples = 16;
constexpr double kLargestGap = 5.0;  ///< Times the median step.

/// Numbers in columns, and the rate that a comment states.
struct PlainColumns {
  std::vector<std::vector<double>> rows;
  double rate_hz = 0.0;
};

double RateInComment(const std::string& line) {
  const auto key = line.find("Sampling Rate (Hz)");
  if (key == std::string::npos) return 0.0;
  const auto value = line.find_first_of("0123456789", key);
  return value == std::string::npos ? 0.0 : std::atof(line.c_str() + value);
}

std::vector<double> NumbersOf(std::string line, const std::string& where) {
  std::ranges::replace(line, ',', ' ');
  std::istringstream in(line);
  std::vector<double> numbers;
  for (std::string word; in >> word;) {
    const auto value = ParseFinite(word);
    ACUS_REQUIRE(value, where, ": '", word, "' is not a finite number");
    numbers.push_back(*value);
  }
  return numbers;
}

PlainColumns ReadPlainColumns(const std::filesystem::path& path, const std::string& text) {
  PlainColumns out;
  std::istringstream in(text);
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.starts_with('#')) {
      out.rate_hz = std::max(out.rate_hz, RateInComment(line));
      continue;
    }
    auto row = NumbersOf(line, Message(path.string(), ":", number));
    if (row.empty()) continue;
    ACUS_REQUIRE(out.rows.empty() || row.size() == out.rows.front().size(), path.string(), ":",
                 number, ": ", row.size(), " numbers in this row, ", out.rows.front().size(),
                 " in those before");
    out.rows.push_back(std::move(row));
  }
  return out;
}

/// True if the first line with content begins like a name.
bool HasHeader(const std::string& text) {
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    return std::isalpha(static_cast<unsigned char>(line[first])) != 0;
  }
  return false;
}

BreathSignal FromPlainColumns(const std::filesystem::path& path, const std::string& text,
                              const SignalFileOptions& options) {
  const PlainColumns columns = ReadPlainColumns(path, text);
  const double rate_hz = options.rate_hz > 0.0 ? options.rate_hz : columns.rate_hz;
  ACUS_REQUIRE(rate_hz > 0.0 && rate_hz <= 1e6, path.string(),
               ": no times and no sampling rate; give the rate in Hz, or a CSV with a column "
               "time_s");
  ACUS_REQUIRE(!columns.rows.empty(), path.string(), ": no numbers");
  std::size_t column = 0;
  if (!options.column.empty()) {
    const auto& name = options.column;
    const auto number = ParseNumber<std::size_t>(name);
    ACUS_REQUIRE(number && *number < columns.rows.front().size(), path.string(), ": no column '",
                 name, "'; the file has no header, so columns are 0 to ",
                 columns.rows.front().size() - 1);
    column = *number;
  }
  BreathSignal out{.start_s = 0.0, .step_s = 1.0 / rate_hz, .level = {}};
  for (const auto& row : columns.rows) out.level.push_back(row[column]);
  return out;
}

/// Where the column of the signal is, if the caller names none.
std::string SignalColumn(const CsvTable& table, const std::string& asked) {
  if (!asked.empty()) return asked;
  const auto found =
      std::ranges::find_if(table.columns(), [](const auto& name) { return name != "time_s"; });
  ACUS_REQUIRE(found != table.columns().end(), table.path().string(),
               ": only a column time_s, and no signal");
  return *found;
}

BreathSignal FromCsv(const std::filesystem::path& path, const SignalFileOptions& options) {
  const CsvTable table(path);
  const auto level = table.Numbers(SignalColumn(table, options.column));
  ACUS_REQUIRE(level.size() >= kFewestSamples, path.string(), ": ", level.size(),
               " samples; at least ", kFewestSamples, " are needed");
  if (!table.Has("time_s")) {
    ACUS_REQUIRE(options.rate_hz > 0.0, path.string(),
                 ": no column time_s; give the sampling rate in Hz");
    return {.start_s = 0.0, .step_s = 1.0 / options.rate_hz, .level = level};
  }
  const auto time_s = table.Numbers("time_s");
  std::vector<double> steps_s;
  for (std::size_t n = 1; n < time_s.size(); ++n) {
    steps_s.push_back(time_s[n] - time_s[n - 1]);
    ACUS_REQUIRE(steps_s.back() > 0.0, table.Where(n), ": time ", time_s[n],
                 " s is not later than ", time_s[n - 1], " s before it");
  }
  const double step_s = math::Median(steps_s);
  for (std::size_t n = 0; n < steps_s.size(); ++n) {
    ACUS_REQUIRE(steps_s[n] <= kLargestGap * step_s, table.Where(n + 1), ": a gap of ", steps_s[n],
                 " s where the samples are ", step_s,
                 " s apart; use the part before or after it, or fill it");
  }
  // To equal steps, linearly.
  BreathSignal out{.start_s = time_s.front(), .step_s = step_s, .level = {}};
  std::size_t n = 0;
  for (double t = time_s.front(); t <= time_s.back();
       t = time_s.front() + step_s * static_cast<double>(out.level.size())) {
    while (n + 2 < time_s.size() && time_s[n + 1] <= t) ++n;
    const double share = (t - time_s[n]) / (time_s[n + 1] - time_s[n]);
    out.level.push_back(level[n] + share * (level[n + 1] - level[n]));
  }
  return out;
}

}  // namespace

BreathSignal ReadBreathSignal(const std::filesystem::path& path, const SignalFileOptions& options) {
  ACUS_REQUIRE(options.rate_hz >= 0.0, path.string(), ": sampling rate ", options.rate_hz,
               " Hz; it must be above 0");
  const std::string text = ReadTextFile(path);
  BreathSignal signal =
      HasHeader(text) ? FromCsv(path, options) : FromPlainColumns(path, text, options);
  ACUS_REQUIRE(signal.level.size() >= kFewestSamples, path.string(), ": ", signal.level.size(),
               " samples; at least ", kFewestSamples, " are needed");
  const auto [low, high] = std::ranges::minmax(signal.level);
  ACUS_REQUIRE(high > low, path.string(), ": the signal is ", low,
               " throughout: no breathing. Was the sensor connected?");
  return signal;
}

}  // namespace acus::breathing
