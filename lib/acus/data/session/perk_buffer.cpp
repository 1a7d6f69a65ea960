#include "acus/data/session/perk_buffer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/xml_scan.h"
#include "acus/data/session/csv_rows.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/session/sequence_header.h"

namespace acus::session {
namespace {

constexpr double kToleranceS = 0.001;  ///< Of Slicer's index values.
constexpr std::int64_t kSearchNs = 2'000'000;

/// Slicer keeps times as text of six significant digits.
std::int64_t StampNs(const core::XmlElement& entry, const std::string& label) {
  const auto seconds = ParseFinite(entry.Attribute("TimeStampSec").value_or(""));
  const auto nanoseconds = ParseFinite(entry.Attribute("TimeStampNSec").value_or(""));
  const double time_s = seconds && nanoseconds ? *seconds + 1e-9 * *nanoseconds : kMaxTimeS;
  ACUS_REQUIRE(std::abs(time_s) < kMaxTimeS, label,
               ": a log entry has no valid TimeStampSec and TimeStampNSec");
  char text[32];
  std::snprintf(text, sizeof(text), "%g", time_s);
  return std::llround(1e9 * std::strtod(text, nullptr));
}

TimedMatrix EntryOf(const core::XmlElement& entry, const std::string& device,
                    const std::string& label) {
  const auto numbers = NumbersOf(entry.Attribute("transform").value_or(""));
  ACUS_REQUIRE(numbers && numbers->size() == 16, label, ": a transform of ", device,
               " is not 16 finite numbers");
  TimedMatrix out;
  out.time_ns = StampNs(entry, label);
  out.to_from_from =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers->data());
  return out;
}

/// As Slicer compares them: pairs of exactly 1 ms are decided by rounding.
bool IsSameTime(std::int64_t a_ns, std::int64_t b_ns) {
  return std::abs(static_cast<double>(a_ns) / 1e9 - static_cast<double>(b_ns) / 1e9) <= kToleranceS;
}

std::vector<TimedMatrix> At(const std::vector<TimedMatrix>& times,
                            const std::vector<TimedMatrix>& entries) {
  std::vector<TimedMatrix> out;
  for (const TimedMatrix& time : times) {
    auto entry =
        std::ranges::lower_bound(entries, time.time_ns - kSearchNs, {}, &TimedMatrix::time_ns);
    while (entry != entries.end() && !IsSameTime(entry->time_ns, time.time_ns) &&
           entry->time_ns < time.time_ns) {
      ++entry;
    }
    const bool is_same = entry != entries.end() && IsSameTime(entry->time_ns, time.time_ns);
    if (!is_same && entry != entries.begin()) --entry;
    out.push_back({time.time_ns, entry->to_from_from});
  }
  return out;
}

}  // namespace

SlicerScene ReadPerkBuffer(const std::filesystem::path& path) {
  const std::string label = path.string();
  const auto elements = core::ScanXml(ReadTextFile(path), label);
  ACUS_REQUIRE(elements.front().name == "TransformRecorderLog", label,
               ": is not a transform buffer of Perk Tutor (TransformRecorderLog)");
  std::map<std::string, std::vector<TimedMatrix>> devices;
  std::string first;
  for (const core::XmlElement& element : elements) {
    if (element.name != "log" || element.Attribute("type").value_or("") != "transform") continue;
    const std::string device = element.Attribute("DeviceName").value_or("");
    if (!transforms::ParseTransformName(device)) continue;
    if (first.empty()) first = device;
    devices[device].push_back(EntryOf(element, device, label));
  }
  ACUS_REQUIRE(!devices.empty(), label, ": has no transform with a name such as StylusTipToRAS");
  for (auto& [device, entries] : devices) {
    std::ranges::stable_sort(entries, {}, &TimedMatrix::time_ns);
    const auto repeated = std::ranges::unique(entries, {}, &TimedMatrix::time_ns);
    entries.erase(repeated.begin(), repeated.end());
  }
  SlicerScene scene;
  for (const auto& [device, entries] : devices) {
    scene.sequences[device] = At(devices.at(first), entries);
  }
  return scene;
}

}  // namespace acus::session
