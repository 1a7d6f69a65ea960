#include "acus/data/session/column_csv.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/delimited_text.h"
#include "acus/base/core/error.h"
#include "acus/base/core/words.h"
#include "acus/base/math/statistics.h"
#include "acus/data/session/pose_csv.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kNoColumn = static_cast<std::size_t>(-1);
constexpr double kQuaternionTolerance = 0.02;
constexpr double kFarthestToolMm = 1e4;  ///< No tracker of tools sees farther.
constexpr double kNearestToolMm = 3.0;   ///< Coordinates below it are metres.

/// The file as rows of cells.
struct Rows {
  std::vector<std::vector<std::string>> cells;  ///< By line, also of empty ones.
  std::vector<bool> is_comment;                 ///< By line; names may stand in a comment.
  TableStyle style;
};

TableStyle StyleFrom(const std::string& delimiter, std::string_view text,
                     const std::string& label) {
  TableStyle style = StyleOf(text, label);
  if (delimiter == "auto") return style;
  const char separator = delimiter == "tab" ? '\t' : delimiter == "blanks" ? ' ' : delimiter[0];
  if (style.separator != separator) style = {.separator = separator, .has_decimal_comma = false};
  return style;
}

Rows RowsOf(const fs::path& path, const std::string& delimiter) {
  const std::string text = Utf8Text(ReadTextFile(path), path.string());
  Rows rows{.cells = {}, .is_comment = {}, .style = StyleFrom(delimiter, text, path.string())};
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = Trimmed(std::string_view(text).substr(begin, end - begin));
    rows.is_comment.push_back(line.starts_with('#') || line.starts_with('%'));
    if (rows.is_comment.back()) line = Trimmed(line.substr(1));
    SplitCells(line, rows.style.separator, rows.cells.emplace_back());
    begin = end + 1;
  }
  return rows;
}

/// mm per unit that the rows before the data declare in a cell after "Length Units".
std::optional<std::pair<std::string, double>> DeclaredUnit(const Rows& rows,
                                                           std::size_t first_row) {
  for (std::size_t row = 0; row < std::min(rows.cells.size(), first_row); ++row) {
    const auto& cells = rows.cells[row];
    for (std::size_t i = 0; i + 1 < cells.size(); ++i) {
      const std::string key = ParseColumnName(cells[i]).words;
      if (key != "length_units" && key != "length_unit") continue;
      const auto factor = UnitFactor(ParseColumnName(cells[i + 1]).words, "mm");
      if (factor) return std::pair(cells[i + 1], *factor);
    }
  }
  return {};
}

double MillimetresPerUnit(const Rows& rows, const json& mapping, const std::string& label,
                          const RunContext& context) {
  const double mapped = mapping.at("length_unit") == "m" ? 1000.0 : 1.0;
  const auto declared = DeclaredUnit(rows, mapping.at("first_row").get<std::size_t>() - 1);
  if (!declared || declared->second == mapped) return mapped;
  context.Warn(Message(label, ": its length units are ", declared->first,
                       ", as it says itself; the mapping says ",
                       mapping.at("length_unit").get<std::string>(), ". The file's are used"));
  return declared->second;
}

/// A tool of a tracker is neither many metres away, nor does it move within a millimetre.
void RequirePlausiblePlaces(const PoseStream& stream, const char* tool, double mm_per_unit,
                            const std::string& label) {
  std::vector<double> distance_mm;
  Eigen::AlignedBox3d box;
  for (const PoseSample& sample : stream) {
    if (!sample.valid) continue;
    distance_mm.push_back(sample.reference_from_tool.translation().norm());
    box.extend(sample.reference_from_tool.translation());
  }
  if (distance_mm.empty()) return;
  const double usual_mm = math::Median(distance_mm);
  const char* advice = "; check length_unit of the mapping, or give --as-it-is";
  ACUS_REQUIRE(usual_mm <= kFarthestToolMm, label, ": the ", tool, " is ", usual_mm / 1000.0,
               " m away: the file is probably in ", mm_per_unit == 1.0 ? "micrometres" : "mm",
               ", not in ", mm_per_unit == 1.0 ? "mm" : "metres", advice);
  const bool in_metres =
      box.max().cwiseAbs().cwiseMax(box.min().cwiseAbs()).maxCoeff() < kNearestToolMm &&
      box.diagonal().norm() > 1e-3 && mm_per_unit == 1.0;
  ACUS_REQUIRE(!in_metres, label, ": the ", tool, " stays within ", usual_mm,
               " mm of the origin: the file is probably in metres, not in mm", advice);
}

/// The names of the columns: cells of the header rows, joined by "/"; the second of the same name
/// ends with "#2".
std::vector<std::string> NamesOf(const std::vector<std::vector<std::string>>& lines,
                                 const std::vector<std::size_t>& rows, const std::string& label) {
  std::vector<std::string> names;
  for (const std::size_t row : rows) {
    ACUS_REQUIRE(row >= 1 && row <= lines.size(), label, ": has no row ", row,
                 ", which the mapping names as header");
    const auto& cells = lines[row - 1];
    names.resize(std::max(names.size(), cells.size()));
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (!cells[i].empty()) names[i] += (names[i].empty() ? "" : "/") + cells[i];
    }
  }
  const std::vector<std::string> plain = names;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto before =
        std::count(plain.begin(), plain.begin() + static_cast<std::ptrdiff_t>(i), plain[i]);
    if (before > 0) names[i] += Message("#", before + 1);
  }
  return names;
}

/// By its name, or its number from 1.
std::size_t ColumnOf(const json& wanted, const std::vector<std::string>& names,
                     const std::string& label) {
  if (wanted.is_number_integer()) {
    const auto number = wanted.get<std::size_t>();
    ACUS_REQUIRE(number >= 1 && number <= names.size(), label, ": has ", names.size(),
                 " columns, the mapping requires column ", number);
    return number - 1;
  }
  auto bare = wanted.get<std::string>();
  if (bare.starts_with('#') || bare.starts_with('%')) bare.erase(0, 1);  // As in names of headers.
  const auto found = std::ranges::find(names, bare);
  if (found == names.end()) {
    std::string all;
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    throw InputError(Message(label, ": has no column '", wanted.get<std::string>(),
                             "'; change the mapping (--columns); there are: ", all));
  }
  return static_cast<std::size_t>(found - names.begin());
}

struct ToolColumns {
  std::array<std::size_t, 3> position{};
  std::array<std::size_t, 4> rotation{};  ///< w, x, y, z.
  std::size_t status = kNoColumn;
  std::vector<std::string> valid;
};

ToolColumns ToolOf(const json& tool, const std::vector<std::string>& names,
                   const std::string& label) {
  ToolColumns out;
  for (std::size_t i = 0; i < 3; ++i) out.position[i] = ColumnOf(tool["position"][i], names, label);
  for (std::size_t i = 0; i < 4; ++i) out.rotation[i] = ColumnOf(tool["rotation"][i], names, label);
  if (tool.contains("status")) out.status = ColumnOf(tool["status"], names, label);
  out.valid = tool.at("valid").get<std::vector<std::string>>();
  return out;
}

std::optional<double> NumberAt(const std::vector<std::string>& cells, std::size_t column,
                               bool has_decimal_comma) {
  if (column >= cells.size()) return {};
  return NumberInCell(cells[column], has_decimal_comma);
}

/// Nothing if the tool was not seen.
std::optional<Eigen::Isometry3d> PoseAtRow(const std::vector<std::string>& cells,
                                           const ToolColumns& tool, double mm_per_unit,
                                           bool has_decimal_comma) {
  if (tool.status != kNoColumn &&
      (tool.status >= cells.size() || std::ranges::count(tool.valid, cells[tool.status]) == 0)) {
    return {};
  }
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < 7; ++i) {
    const std::size_t column = i < 3 ? tool.position[i] : tool.rotation[i - 3];
    const auto value = NumberAt(cells, column, has_decimal_comma);
    if (!value) return {};
    values[i] = *value;
  }
  const Eigen::Vector3d position_mm =
      mm_per_unit * Eigen::Vector3d(values[0], values[1], values[2]);
  const Eigen::Quaterniond rotation(values[3], values[4], values[5], values[6]);
  const bool is_pose = position_mm.cwiseAbs().maxCoeff() <= kMaxCoordinateMm &&
                       std::abs(rotation.norm() - 1.0) <= kQuaternionTolerance;
  if (!is_pose) return {};
  return Eigen::Isometry3d(Eigen::Translation3d(position_mm) * rotation.normalized());
}

void Append(PoseStream& stream, std::int64_t time_ns,
            const std::optional<Eigen::Isometry3d>& pose) {
  PoseSample sample{.time_ns = time_ns, .reference_from_tool = {}, .valid = pose.has_value()};
  if (pose) sample.reference_from_tool = transforms::Pose(*pose);
  if (!pose && !stream.empty()) sample.reference_from_tool = stream.back().reference_from_tool;
  stream.push_back(sample);
}

}  // namespace

Session ReadColumnCsv(const fs::path& path, const fs::path& columns, bool as_it_is,
                      const RunContext& context) {
  return ReadMappedCsv(path, config::ReadConfig(columns, "acus-columns"), as_it_is, context);
}

Session ReadMappedCsv(const fs::path& path, const json& mapping, bool as_it_is,
                      const RunContext& context) {
  const std::string label = path.string();
  const Rows rows = RowsOf(path, mapping.at("delimiter"));
  const bool decimal_comma = rows.style.has_decimal_comma;
  const auto names =
      NamesOf(rows.cells, mapping.at("header_rows").get<std::vector<std::size_t>>(), label);
  const double mm_per_unit = MillimetresPerUnit(rows, mapping, label, context);
  const json& time = mapping.at("time");
  const std::size_t time_column = ColumnOf(time.at("column"), names, label);
  const double s_per_unit = 1.0 / time.at("units_per_s").get<double>();
  Session session;
  session.name = path.stem().string();
  session.reference_frame = mapping.at("reference_frame");
  std::vector<std::pair<PoseStream*, ToolColumns>> tools;
  for (const json& tool : mapping.at("tools")) {
    PoseStream& stream = tool.at("tool") == "needle" ? session.needle : session.probe;
    tools.emplace_back(&stream, ToolOf(tool, names, label));
  }
  std::optional<std::int64_t> last_ns;
  std::size_t num_repeated = 0;
  for (std::size_t row = mapping.at("first_row").get<std::size_t>() - 1; row < rows.cells.size();
       ++row) {
    const auto& cells = rows.cells[row];
    if (rows.is_comment[row] || std::ranges::all_of(cells, &std::string::empty)) continue;
    const auto units = NumberAt(cells, time_column, decimal_comma);
    ACUS_REQUIRE(units && std::abs(*units * s_per_unit) <= kMaxTimeS, label, ":", row + 1,
                 ": has no time in column '", names[time_column], "'");
    const auto time_ns = static_cast<std::int64_t>(std::llround(*units * s_per_unit * 1e9));
    ACUS_REQUIRE(!last_ns || time_ns >= *last_ns, label, ":", row + 1,
                 ": its time does not increase; does column '", names[time_column],
                 "' hold the time?");
    if (last_ns == time_ns) {
      ++num_repeated;
      continue;
    }
    last_ns = time_ns;
    for (auto& [stream, tool] : tools) {
      Append(*stream, time_ns, PoseAtRow(cells, tool, mm_per_unit, decimal_comma));
    }
  }
  ACUS_REQUIRE(last_ns, label, ": has no rows of data from row ",
               mapping.at("first_row").get<int>(), " on");
  ACUS_REQUIRE(num_repeated == 0 || session.needle.size() + session.probe.size() > tools.size(),
               label, ": all rows have one time; does column '", names[time_column],
               "' hold the time?");
  if (num_repeated > 0) {
    context.Warn(Message(label, ": ", Counted(num_repeated, "row# with the time of the row before"),
                         " omitted; the first of each is kept"));
  }
  for (auto& [stream, tool] : tools) {
    const char* name = stream == &session.needle ? "needle" : "probe";
    ACUS_REQUIRE(std::ranges::any_of(*stream, &PoseSample::valid), label, ": the ", name,
                 " was never seen: no row has numbers of a pose (quaternion of length 1) in the "
                 "columns of the mapping");
    if (!as_it_is) RequirePlausiblePlaces(*stream, name, mm_per_unit, label);
  }
  return session;
}

}  // namespace acus::session
