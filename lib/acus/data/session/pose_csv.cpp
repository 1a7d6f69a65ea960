#include "acus/data/session/pose_csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <span>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/data/session/csv_rows.h"

namespace acus::session {
namespace {

constexpr std::array<std::string_view, 9> kColumns = {"time_s", "x_mm", "y_mm", "z_mm",  "qw",
                                                      "qx",     "qy",   "qz",   "status"};
constexpr double kNormTolerance = 1e-3;
constexpr std::int64_t kNsPerS = 1'000'000'000;

/// OK first: its index says that a row is valid.
constexpr std::array<std::string_view, 2> kStatus = {"OK", "INVALID"};

transforms::Pose PoseOf(const CsvRows& rows) {
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = ParseFinite(rows.Cell(i + 1));
    ACUS_REQUIRE(value.has_value(), rows.Where(), ": ", kColumns[i + 1], " is '", rows.Cell(i + 1),
                 "'; a finite number is needed (a tool that was not seen has status INVALID)");
    values[i] = *value;
    ACUS_REQUIRE(i >= 3 || std::abs(values[i]) <= kMaxCoordinateMm, rows.Where(), ": ",
                 kColumns[i + 1], " is ", rows.Cell(i + 1), "; it must lie within +-",
                 kMaxCoordinateMm, " mm");
  }
  const Eigen::Quaterniond rotation(values[3], values[4], values[5], values[6]);
  const double norm = rotation.norm();
  ACUS_REQUIRE(std::abs(norm - 1.0) <= kNormTolerance, rows.Where(),
               ": the quaternion (qw,qx,qy,qz) has norm ", norm, "; it must be 1 to within ",
               kNormTolerance);
  return {rotation, Eigen::Vector3d(values[0], values[1], values[2])};
}

bool HasMissingCell(const CsvRows& rows) {
  for (std::size_t i = 1; i + 1 < kColumns.size(); ++i) {
    if (rows.Cell(i).empty()) return true;
  }
  return false;
}

void FillLeadingInvalid(PoseStream& stream, const std::string& name, const RunContext& context) {
  const auto first_good = std::ranges::find(stream, true, &PoseSample::valid);
  if (first_good == stream.end()) {
    context.Warn(Message(name, ": the tool was never seen: all samples are INVALID"));
    return;
  }
  for (auto sample = stream.begin(); sample != first_good; ++sample) {
    sample->reference_from_tool = first_good->reference_from_tool;
  }
}

}  // namespace

PoseStream ReadPoseCsv(const std::filesystem::path& path, const RunContext& context) {
  CsvRows rows(path, kColumns, kStatus, context);
  PoseStream stream;
  stream.reserve(rows.size() / 80);
  std::size_t num_repeated = 0;
  std::size_t num_empty = 0;
  while (rows.Next()) {
    PoseSample sample{rows.TimeNs(0), transforms::Pose(), kStatus[rows.Word()] == "OK"};
    if (rows.IsRepeated()) {
      ++num_repeated;
      continue;
    }
    if (sample.valid && HasMissingCell(rows)) {
      sample.valid = false;
      ++num_empty;
    }
    if (sample.valid) {
      sample.reference_from_tool = PoseOf(rows);
    } else if (!stream.empty()) {
      sample.reference_from_tool = stream.back().reference_from_tool;
    }
    stream.push_back(sample);
  }
  if (num_repeated > 0) {
    context.Warn(Message(path.string(), ": ",
                         Counted(num_repeated, "row# with the time stamp of the row before"),
                         " omitted; the first of each is kept"));
  }
  if (num_empty > 0) {
    context.Warn(Message(path.string(), ": ", Counted(num_empty, "row# with empty cells"),
                         " taken as INVALID: the tool was not seen"));
  }
  ACUS_REQUIRE(!stream.empty(), path.string(),
               ": has no samples; record again, or take the stream out "
               "of session.json");
  FillLeadingInvalid(stream, path.string(), context);
  return stream;
}

void AppendPoseRow(std::string& text, const PoseSample& sample) {
  const Eigen::Vector3d p = sample.reference_from_tool.translation();
  const Eigen::Quaterniond& q = sample.reference_from_tool.quaternion();
  text += SecondsText(sample.time_ns);
  for (const double value : {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()}) {
    text += ',';
    text += NumberText(value);
  }
  text += sample.valid ? ",OK\n" : ",INVALID\n";
}

void WritePoseCsv(const std::filesystem::path& path, const PoseStream& stream) {
  std::string text = std::string(kPoseHeader) + '\n';
  text.reserve(stream.size() * 160);
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const PoseSample& sample = stream[i];
    ACUS_REQUIRE(i == 0 || sample.time_ns > stream[i - 1].time_ns, path.filename().string(),
                 ": sample ", i, " is at ", SecondsText(sample.time_ns),
                 " s, not later than the one ", "before it; time must increase");
    const Eigen::Vector3d p = sample.reference_from_tool.translation();
    const Eigen::Quaterniond& q = sample.reference_from_tool.quaternion();
    ACUS_REQUIRE(
        p.allFinite() && q.coeffs().allFinite() && p.cwiseAbs().maxCoeff() <= kMaxCoordinateMm,
        path.filename().string(), ": sample ", i, ": the pose is not finite, or more than ",
        kMaxCoordinateMm, " mm away");
    AppendPoseRow(text, sample);
  }
  WriteAll(path, text);
}

void WriteAll(const std::filesystem::path& path, std::string_view text) {
  std::ofstream out(path, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  ACUS_REQUIRE(out, path.string(), ": cannot be written; is the disk full?");
}

std::string SecondsText(std::int64_t time_ns) {
  const bool negative = time_ns < 0;
  const std::uint64_t magnitude =
      negative ? 0 - static_cast<std::uint64_t>(time_ns) : static_cast<std::uint64_t>(time_ns);
  std::string text = (negative ? "-" : "") + std::to_string(magnitude / kNsPerS);
  std::string decimals = std::to_string(magnitude % kNsPerS);
  decimals.insert(0, 9 - decimals.size(), '0');
  decimals.erase(decimals.find_last_not_of('0') + 1);
  if (!decimals.empty()) text += '.' + decimals;
  return text;
}

std::optional<std::int64_t> NanosecondsFromText(std::string_view seconds) {
  const auto value = ParseFinite(seconds);
  if (!value || std::abs(*value) > kMaxTimeS) return {};
  // A double holds only 15 to 17 digits: a stamp in Unix time would lose its nanoseconds.
  const bool negative = !seconds.empty() && seconds.front() == '-';
  const std::string_view digits = seconds.substr(negative ? 1 : 0);
  const std::size_t point = std::min(digits.find('.'), digits.size());
  const std::string_view whole = digits.substr(0, point);
  const std::string_view decimals = point < digits.size() ? digits.substr(point + 1) : "";
  const bool is_plain = digits.find_first_not_of("0123456789.") == digits.npos &&
                        decimals.size() <= 9 && !whole.empty() && whole.size() <= 12;
  if (!is_plain) return static_cast<std::int64_t>(std::llround(*value * 1e9));
  std::int64_t time_ns = 0;
  for (const char digit : whole) time_ns = 10 * time_ns + (digit - '0');
  for (std::size_t i = 0; i < 9; ++i) {
    time_ns = 10 * time_ns + (i < decimals.size() ? decimals[i] - '0' : 0);
  }
  return negative ? -time_ns : time_ns;
}

}  // namespace acus::session
