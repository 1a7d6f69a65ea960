#include "session/pose_csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <span>

#include "core/atomic_file.h"
#include "core/csv.h"
#include "core/error.h"
#include "core/words.h"

namespace acus::session {
namespace {

constexpr std::array<std::string_view, 9> kColumns = {"time_s", "x_mm", "y_mm", "z_mm",  "qw",
                                                      "qx",     "qy",   "qz",   "status"};
constexpr std::size_t kNumColumns = kColumns.size();
constexpr std::string_view kHeader = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status";
constexpr double kNormTolerance = 1e-3;
constexpr double kMaxCoordinateMm = 1e6;  // A kilometre: no tracker sees that far.
constexpr std::int64_t kNsPerS = 1'000'000'000;

using Cells = std::array<std::string_view, kNumColumns>;

/// Splits into `cells` and returns how many there are, also when these are more.
std::size_t Split(std::string_view line, std::span<std::string_view> cells) {
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    if (count < cells.size()) cells[count] = Trimmed(line.substr(begin, end - begin));
    ++count;
    begin = end + 1;
  }
  return count;
}

std::optional<double> Number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

/// Reads the lines of one file one after the other.
class PoseCsvReader {
 public:
  PoseCsvReader(const std::filesystem::path& path, const RunContext& context)
      : name_(path.string()), context_(context), text_(ReadTextFile(path)) {
    // After a power cut some file systems fill the end of a file with zero bytes.
    while (!text_.empty() && text_.back() == '\0') text_.pop_back();
  }

  PoseStream Read() {
    const std::string_view text = text_;
    stream_.reserve(text.size() / 80);
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t newline = text.find('\n', begin);
      const std::size_t end = std::min(newline, text.size());
      const std::string_view line = Trimmed(text.substr(begin, end - begin));
      begin = end + 1;
      ++line_number_;
      if (line.empty() || line.front() == '#') continue;
      if (!has_header_) {
        ReadHeader(line);
      } else {
        ReadRow(line, /*is_complete=*/newline != text.npos);
      }
    }
    ACUS_REQUIRE(has_header_, name_, ": is empty; the first line must be ", kHeader);
    ACUS_REQUIRE(!stream_.empty(), name_,
                 ": has no samples; record again, or take the stream out "
                 "of session.json");
    FillLeadingInvalid();
    return std::move(stream_);
  }

 private:
  void ReadHeader(std::string_view line) {
    Cells cells;
    const std::size_t count = Split(line, cells);
    ACUS_REQUIRE(count == kNumColumns, Where(), ": the header has ", count, " columns; it must be ",
                 kHeader);
    for (std::size_t i = 0; i < kNumColumns; ++i) {
      const auto found = std::ranges::find(cells, kColumns[i]);
      ACUS_REQUIRE(found != cells.end(), Where(), ": no column '", kColumns[i],
                   "'; the header must be ", kHeader);
      column_[i] = static_cast<std::size_t>(found - cells.begin());
    }
    has_header_ = true;
  }

  void ReadRow(std::string_view line, bool is_complete) {
    Cells in_file;
    const std::size_t count = Split(line, in_file);
    Cells cells;
    for (std::size_t i = 0; i < kNumColumns; ++i) cells[i] = in_file[column_[i]];
    const bool status_known = count == kNumColumns && (cells[8] == "OK" || cells[8] == "INVALID");
    if (!is_complete && !status_known) {
      // The status ends a line, so a line without it was being written when the recording stopped.
      context_.Warn(Message(Where(),
                            ": the last line is cut off (was the recording interrupted?); "
                            "it is left out"));
      return;
    }
    ACUS_REQUIRE(count == kNumColumns, Where(), ": has ", count, " cells, the columns are ",
                 kNumColumns, " (", kHeader, ")");
    ACUS_REQUIRE(status_known, Where(), ": status is '", cells[8], "'; allowed: OK, INVALID");
    AddSample(cells);
  }

  void AddSample(const Cells& cells) {
    const auto time_ns = NanosecondsFromText(cells[0]);
    ACUS_REQUIRE(time_ns.has_value(), Where(), ": time_s is '", cells[0],
                 "'; a finite number of seconds within +-", kMaxTimeS, " is needed");
    ACUS_REQUIRE(stream_.empty() || *time_ns > stream_.back().time_ns, Where(), ": time_s is ",
                 cells[0], ", but the sample before is at ", SecondsText(stream_.back().time_ns),
                 "; time must increase: remove or sort the rows");
    PoseSample sample{*time_ns, Pose(), cells[8] == "OK"};
    if (sample.valid) {
      sample.reference_from_tool = ReadPose(cells);
    } else if (!stream_.empty()) {
      sample.reference_from_tool = stream_.back().reference_from_tool;
    }
    stream_.push_back(sample);
  }

  Pose ReadPose(const Cells& cells) const {
    std::array<double, 7> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto value = Number(cells[i + 1]);
      ACUS_REQUIRE(value.has_value(), Where(), ": ", kColumns[i + 1], " is '", cells[i + 1],
                   "'; a finite number is needed (a tool that was not seen has status INVALID)");
      values[i] = *value;
      ACUS_REQUIRE(i >= 3 || std::abs(values[i]) <= kMaxCoordinateMm, Where(), ": ",
                   kColumns[i + 1], " is ", cells[i + 1], "; it must lie within +-",
                   kMaxCoordinateMm, " mm");
    }
    const Eigen::Quaterniond rotation(values[3], values[4], values[5], values[6]);
    const double norm = rotation.norm();
    ACUS_REQUIRE(std::abs(norm - 1.0) <= kNormTolerance, Where(),
                 ": the quaternion (qw,qx,qy,qz) has norm ", norm, "; it must be 1 to within ",
                 kNormTolerance);
    return {rotation, Eigen::Vector3d(values[0], values[1], values[2])};
  }

  void FillLeadingInvalid() {
    const auto first_good = std::ranges::find(stream_, true, &PoseSample::valid);
    if (first_good == stream_.end()) {
      context_.Warn(Message(name_, ": the tool was never seen: all samples are INVALID"));
      return;
    }
    for (auto sample = stream_.begin(); sample != first_good; ++sample) {
      sample->reference_from_tool = first_good->reference_from_tool;
    }
  }

  std::string Where() const { return Message(name_, ":", line_number_); }

  std::string name_;
  const RunContext& context_;
  std::string text_;
  PoseStream stream_;
  std::array<std::size_t, kNumColumns> column_{};
  std::size_t line_number_ = 0;
  bool has_header_ = false;
};

}  // namespace

PoseStream ReadPoseCsv(const std::filesystem::path& path, const RunContext& context) {
  return PoseCsvReader(path, context).Read();
}

void WritePoseCsv(const std::filesystem::path& path, const PoseStream& stream) {
  std::string text = std::string(kHeader) + '\n';
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
    text += SecondsText(sample.time_ns);
    for (const double value : {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()}) {
      text += ',';
      text += NumberText(value);
    }
    text += sample.valid ? ",OK\n" : ",INVALID\n";
  }
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
  const auto value = Number(seconds);
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
