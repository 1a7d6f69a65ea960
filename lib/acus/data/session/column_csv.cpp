#include "acus/data/session/column_csv.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/data/session/csv_rows.h"
#include "acus/data/session/pose_csv.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kNoColumn = static_cast<std::size_t>(-1);
constexpr double kQuaternionTolerance = 0.02;

std::string TrimmedCell(std::string text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_blank(text.back())) text.pop_back();
  text.erase(text.begin(), std::ranges::find_if_not(text, is_blank));
  return text;
}

/// Cells of a line; quotes may hold the delimiter.
std::vector<std::string> CellsOf(const std::string& line, char delimiter) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == delimiter && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  for (std::string& cell : cells) cell = TrimmedCell(cell);
  return cells;
}

std::vector<std::vector<std::string>> LinesOf(const fs::path& path, char delimiter) {
  const std::string text = ReadTextFile(path);
  std::vector<std::vector<std::string>> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(CellsOf(text.substr(begin, end - begin), delimiter));
    begin = end + 1;
  }
  return lines;
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
  const auto found = std::ranges::find(names, wanted.get<std::string>());
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

std::optional<double> NumberAt(const std::vector<std::string>& cells, std::size_t column) {
  return column < cells.size() ? ParseFinite(cells[column]) : std::nullopt;
}

/// Nothing if the tool was not seen.
std::optional<Eigen::Isometry3d> PoseAtRow(const std::vector<std::string>& cells,
                                           const ToolColumns& tool, double mm_per_unit) {
  if (tool.status != kNoColumn &&
      (tool.status >= cells.size() || std::ranges::count(tool.valid, cells[tool.status]) == 0)) {
    return {};
  }
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < 7; ++i) {
    const auto value = NumberAt(cells, i < 3 ? tool.position[i] : tool.rotation[i - 3]);
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

Session ReadColumnCsv(const fs::path& path, const fs::path& columns) {
  const json mapping = config::ReadConfig(columns, "acus-columns");
  const std::string label = path.string();
  const std::string delimiter = mapping.at("delimiter");
  const auto lines = LinesOf(path, delimiter == "tab" ? '\t' : delimiter.front());
  const auto names =
      NamesOf(lines, mapping.at("header_rows").get<std::vector<std::size_t>>(), label);
  const double mm_per_unit = mapping.at("length_unit") == "m" ? 1000.0 : 1.0;
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
  for (std::size_t row = mapping.at("first_row").get<std::size_t>() - 1; row < lines.size();
       ++row) {
    const auto& cells = lines[row];
    if (cells.size() == 1 && cells.front().empty()) continue;
    const auto units = NumberAt(cells, time_column);
    ACUS_REQUIRE(units && std::abs(*units * s_per_unit) <= kMaxTimeS, label, ":", row + 1,
                 ": has no time in column '", names[time_column], "'");
    const auto time_ns = static_cast<std::int64_t>(std::llround(*units * s_per_unit * 1e9));
    ACUS_REQUIRE(!last_ns || time_ns > *last_ns, label, ":", row + 1,
                 ": its time does not increase; does column '", names[time_column],
                 "' hold the time?");
    last_ns = time_ns;
    for (auto& [stream, tool] : tools)
      Append(*stream, time_ns, PoseAtRow(cells, tool, mm_per_unit));
  }
  ACUS_REQUIRE(last_ns, label, ": has no rows of data from row ",
               mapping.at("first_row").get<int>(), " on");
  for (auto& [stream, tool] : tools) {
    ACUS_REQUIRE(std::ranges::any_of(*stream, &PoseSample::valid), label, ": the ",
                 stream == &session.needle ? "needle" : "probe",
                 " was never seen: no row has numbers of a pose (quaternion of length 1) in the "
                 "columns of the mapping");
  }
  return session;
}

}  // namespace acus::session
