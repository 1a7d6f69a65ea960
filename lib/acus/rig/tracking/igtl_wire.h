// OpenIGTLink messages as bytes: headers, contents, checksums.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acus/data/transforms/pose.h"
#include "acus/rig/tracking/image.h"

namespace acus::tracking {

/// The 58 bytes before every message. Header version 1 is protocol 1 and 2; header version 2 is
/// protocol 3, whose bodies have an extended header before and metadata after the content.
struct IgtlHeader {
  std::uint16_t version = 1;
  std::string type = {};     ///< "TRANSFORM"; up to 12 characters.
  std::string device = {};   ///< Up to 20 characters.
  std::int64_t time_ns = 0;  ///< The sender's clock, mostly UTC since 1970; 0 if there is none.
  std::uint64_t body_bytes = 0;
  std::uint64_t crc = 0;
};
inline constexpr std::size_t kIgtlHeaderBytes = 58;
inline constexpr std::size_t kIgtlNameBytes = 20;
/// No message that is larger is believed: a volume of 512 x 512 x 120 pixels of 16 bits.
inline constexpr std::uint64_t kMaxIgtlBodyBytes = 64 * 1024 * 1024;

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;
using Metadata = std::vector<std::pair<std::string, std::string>>;

/// Nothing if these cannot be the first bytes of a message that we would read: version, type name
/// or a size that does not go with a known type. @pre 58 bytes
std::optional<IgtlHeader> ParseHeader(ByteView bytes);

/// The checksum of the protocol (ECMA-182). `crc` continues that of the bytes before.
std::uint64_t Crc64(ByteView bytes, std::uint64_t crc = 0);

/// A body in its parts. For header version 1 all of it is content.
struct IgtlBody {
  ByteView content = {};
  Metadata metadata = {};
};
/// Nothing if the sizes in the body do not fit in it.
std::optional<IgtlBody> SplitBody(const IgtlHeader& header, ByteView body);

/// A tool in a message: the matrix as sent (mm), not looked at yet.
struct ToolMatrix {
  std::string name = {};
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
};

/// Numbers in rows of the same length.
struct NumberTable {
  std::size_t columns = 0;
  std::vector<double> values = {};  ///< Row after row.
};

/// Contents. Nothing if the size is wrong.
std::optional<Eigen::Matrix4d> ReadTransform(ByteView content);
std::optional<Eigen::Matrix4d> ReadPosition(ByteView content);
std::optional<std::vector<ToolMatrix>> ReadTrackingData(ByteView content);
std::optional<std::vector<ToolMatrix>> ReadQuaternionTrackingData(ByteView content);
/// Least interval in ms that STT_TDATA requests; 0 is as fast as there are poses.
std::optional<int> ReadStartTrackingData(ByteView content);
/// "OK", or "code 3: name: text".
std::optional<std::string> ReadStatus(ByteView content);
/// Grey or RGB of 8 bits, one slice. Nothing if it is something else or its sizes do not fit.
std::optional<Image> ReadImage(ByteView content);
/// NDARRAY of two dimensions and 64-bit floating-point numbers.
std::optional<NumberTable> ReadTable(ByteView content);
/// STRING, without what would upset a screen or a log.
std::optional<std::string> ReadText(ByteView content);

/// What PLUS says of a transform in its metadata (TransformValid, TransformStatus); true without.
bool SaysValid(const Metadata& metadata);

/// Whole messages, ready to be sent. Names that are too long are cut.
Bytes PackTransform(std::string_view device, std::int64_t time_ns, const transforms::Pose& pose);
/// Any numbers as a TRANSFORM: for tests of what is not a pose.
Bytes PackMatrix(std::string_view device, std::int64_t time_ns, const Eigen::Matrix4d& matrix);
/// As protocol 3, with PLUS's metadata: the only way to say that a tool is not seen.
Bytes PackTransformWithStatus(std::string_view device, std::int64_t time_ns,
                              const transforms::Pose& pose, bool valid);
Bytes PackTrackingData(std::string_view device, std::int64_t time_ns,
                       std::span<const std::pair<std::string, transforms::Pose>> tools);
Bytes PackStatus(std::string_view device, std::int64_t time_ns, bool ok, std::string_view text);
Bytes PackImage(std::string_view device, std::int64_t time_ns, const Image& image);
/// @pre 1 to 65535 rows and columns, all of them full.
Bytes PackTable(std::string_view device, std::int64_t time_ns, const NumberTable& table);
/// @pre at most 65535 bytes of ASCII.
Bytes PackText(std::string_view device, std::string_view text);
/// @pre volume has as many voxels as its size says.
Bytes PackVolume(std::string_view device, std::int64_t time_ns, const VolumeView& volume);
/// POINT: a list of points, in red.
Bytes PackPoints(std::string_view device, std::int64_t time_ns, std::span<const NamedPoint> points);
Bytes PackStartTrackingData(std::string_view device, int interval_ms);
Bytes PackStopTrackingData(std::string_view device);
Bytes PackTrackingDataReply(std::string_view device, bool ok);
Bytes PackCapability(std::string_view device, std::span<const std::string> types);
/// A message without content, such as GET_STATUS.
Bytes PackQuery(std::string_view type, std::string_view device);

/// Fixed-point stamp of the protocol (seconds, 2^-32 s) and ns, to the nearest.
std::uint64_t StampFromNs(std::int64_t time_ns);
std::int64_t NsFromStamp(std::uint64_t stamp);

}  // namespace acus::tracking
