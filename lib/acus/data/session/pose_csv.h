// One stream of poses as CSV: time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"

namespace acus::session {

/// Reads one stream, strictly (see ReadSession). Columns are found by name, in any order.
/// @throws InputError at file:row.
PoseStream ReadPoseCsv(const std::filesystem::path& path, const RunContext& context);

/// Writes one stream, not atomically: for use inside an AtomicFolder.
/// @throws InputError if a time does not increase or a pose is not finite.
void WritePoseCsv(const std::filesystem::path& path, const PoseStream& stream);

/// The header of a stream.
inline constexpr std::string_view kPoseHeader = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status";
/// Farthest coordinate of a pose: a kilometre, no tracker sees that far.
inline constexpr double kMaxCoordinateMm = 1e6;

/// Appends one row with its line end. @throws InputError if the pose is not finite.
void AppendPoseRow(std::string& text, const PoseSample& sample);

/// Writes `text` as a whole file, not atomically. @throws InputError
void WriteAll(const std::filesystem::path& path, std::string_view text);

/// "12.000000001": seconds, exact to the nanosecond, without trailing zeros.
std::string SecondsText(std::int64_t time_ns);

/// Seconds as text to ns: exact for plain decimals of up to nine places, else rounded to the
/// nearest. Nothing if the text is not a finite number or beyond +-kMaxTimeS.
std::optional<std::int64_t> NanosecondsFromText(std::string_view seconds);

/// Stamps lie within +-100 years, so that sums and differences of them never overflow.
constexpr double kMaxTimeS = 3.2e9;

}  // namespace acus::session
