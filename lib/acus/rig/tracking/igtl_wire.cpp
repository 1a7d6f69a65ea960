#include "acus/rig/tracking/igtl_wire.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <igtl_header.h>
#include <igtl_image.h>
#include <igtl_ndarray.h>
#include <igtl_point.h>
#include <igtl_qtdata.h>
#include <igtl_string.h>
#include <igtl_tdata.h>
#include <igtl_transform.h>
#include <igtl_util.h>

#include "acus/base/core/bytes.h"
#include "acus/base/core/error.h"

namespace acus::tracking {
namespace {

static_assert(kIgtlHeaderBytes == IGTL_HEADER_SIZE && kIgtlNameBytes == IGTL_HEADER_NAME_SIZE);

constexpr std::size_t kStatusBytes = 30;  // Code, sub-code, name of the error; then the text.
constexpr std::size_t kExtendedHeaderBytes = 12;
constexpr std::uint64_t kMaxControlBytes = 64 * 1024;
constexpr std::uint16_t kAscii = 3;  // In the list of IANA.

bool IsName(std::string_view name, bool may_be_empty) {
  return (may_be_empty || !name.empty()) && std::all_of(name.begin(), name.end(), [](char c) {
           return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
         });
}

/// Whether a body of the size can be of the type. In header version 2 other parts add to it.
bool SizeGoesWith(const IgtlHeader& header) {
  const bool exact = header.version == 1;
  const std::uint64_t size = header.body_bytes;
  const std::uint64_t most = exact ? UINT64_MAX : kMaxControlBytes;
  const auto fixed = [&](std::uint64_t content) {
    return exact ? size == content : size >= content + kExtendedHeaderBytes && size <= most;
  };
  const auto multiple = [&](std::uint64_t element) {
    return size <= kMaxControlBytes && (!exact || size % element == 0);
  };
  if (header.type == "TRANSFORM") return fixed(IGTL_TRANSFORM_SIZE);
  if (header.type == "TDATA") return multiple(IGTL_TDATA_ELEMENT_SIZE);
  if (header.type == "QTDATA") return multiple(IGTL_QTDATA_ELEMENT_SIZE);
  if (header.type == "POSITION") return fixed(12) || fixed(24) || fixed(28);
  if (header.type == "STATUS") return size >= kStatusBytes && size <= kMaxControlBytes;
  if (header.type == "STT_TDATA") return fixed(IGTL_STT_TDATA_SIZE);
  if (header.type == "IMAGE") return size >= IGTL_IMAGE_HEADER_SIZE;
  return true;
}

/// Networks have the big end first.
struct Reader : core::ByteReader {
  explicit Reader(ByteView bytes) : ByteReader(bytes, std::endian::big) {}
};
struct Writer : core::ByteWriter {
  Writer() : ByteWriter(std::endian::big) {}
};

double Float(Reader& in) {
  return in.Number<float>();
}

void Put(Writer& out, double value) {
  out.Number(static_cast<float>(value));
}

/// 12 numbers: three columns of the rotation, then the translation.
Eigen::Matrix4d Matrix(Reader& in) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) matrix(row, column) = Float(in);
  }
  return matrix;
}

void Put(Writer& out, const Eigen::Matrix4d& matrix) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) Put(out, matrix(row, column));
  }
}

/// Without what would upset a screen or a log.
std::string Printable(std::string text) {
  std::erase_if(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  return text;
}

/// Header and body in one. @param rest  What follows `body` in the body.
Bytes Whole(std::string_view type, std::string_view device, std::int64_t time_ns,
            const Writer& body, std::uint16_t version = 1, ByteView rest = {}) {
  Writer out;
  out.bytes.reserve(kIgtlHeaderBytes + body.bytes.size() + rest.size());
  out.Number(version);
  out.Text(type, IGTL_HEADER_TYPE_SIZE);
  out.Text(device, IGTL_HEADER_NAME_SIZE);
  out.Number(StampFromNs(time_ns));
  out.Number(std::uint64_t{body.bytes.size() + rest.size()});
  out.Number(Crc64(rest, Crc64(body.bytes)));
  out.Raw(body.bytes);
  out.Raw(rest);
  return std::move(out.bytes);
}

Eigen::Matrix4d FromQuaternion(const Eigen::Vector3d& t_mm, const Eigen::Quaterniond& q) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  // Not normalised: a quaternion that is none shows in a matrix that is not rigid.
  matrix.topLeftCorner<3, 3>() = q.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = t_mm;
  return matrix;
}

Eigen::Vector3d Vector(Reader& in) {
  const double x = Float(in), y = Float(in), z = Float(in);
  return {x, y, z};
}

}  // namespace

std::optional<IgtlHeader> ParseHeader(ByteView bytes) {
  // Most places in invalid data are distinguished by the first two bytes.
  if (bytes[0] != 0 || bytes[1] < 1 || bytes[1] > 3) return std::nullopt;
  Reader in(bytes);
  IgtlHeader header;
  header.version = in.Number<std::uint16_t>();
  header.type = in.Text(IGTL_HEADER_TYPE_SIZE);
  header.device = in.Text(IGTL_HEADER_NAME_SIZE);
  header.time_ns = NsFromStamp(in.Number<std::uint64_t>());
  header.body_bytes = in.Number<std::uint64_t>();
  header.crc = in.Number<std::uint64_t>();
  if (!IsName(header.type, false) || !IsName(header.device, true)) return std::nullopt;
  if (header.body_bytes > kMaxIgtlBodyBytes || !SizeGoesWith(header)) return std::nullopt;
  return header;
}

std::uint64_t Crc64(ByteView bytes, std::uint64_t crc) {
  // The library does not say const, but only reads.
  return crc64(const_cast<unsigned char*>(bytes.data()), bytes.size(), crc);
}

std::optional<IgtlBody> SplitBody(const IgtlHeader& header, ByteView body) {
  IgtlBody parts;
  if (header.version == 1) {
    parts.content = body;
    return parts;
  }
  Reader in(body);
  const auto extended_bytes = in.Number<std::uint16_t>();
  const auto metadata_header_bytes = in.Number<std::uint16_t>();
  const auto metadata_bytes = in.Number<std::uint32_t>();
  const std::uint64_t others =
      std::uint64_t{extended_bytes} + metadata_header_bytes + metadata_bytes;
  if (!in.ok() || extended_bytes < kExtendedHeaderBytes || others > body.size()) {
    return std::nullopt;
  }
  parts.content = body.subspan(extended_bytes, body.size() - others);
  Reader sizes(body.subspan(extended_bytes + parts.content.size(), metadata_header_bytes));
  Reader texts(body.last(metadata_bytes));
  if (metadata_header_bytes == 0) return parts;
  const auto count = sizes.Number<std::uint16_t>();
  for (int i = 0; i < count && sizes.ok() && texts.ok(); ++i) {
    const auto key_bytes = sizes.Number<std::uint16_t>();
    sizes.Number<std::uint16_t>();  // Encoding: names and values that we look at are ASCII.
    const auto value_bytes = sizes.Number<std::uint32_t>();
    std::string key = texts.Text(key_bytes);
    parts.metadata.emplace_back(std::move(key), texts.Text(value_bytes));
  }
  if (!sizes.ok() || !texts.ok()) return std::nullopt;
  return parts;
}

std::optional<Eigen::Matrix4d> ReadTransform(ByteView content) {
  if (content.size() != IGTL_TRANSFORM_SIZE) return std::nullopt;
  Reader in(content);
  return Matrix(in);
}

std::optional<Eigen::Matrix4d> ReadPosition(ByteView content) {
  Reader in(content);
  const Eigen::Vector3d t_mm = Vector(in);
  if (content.size() == 12) return FromQuaternion(t_mm, Eigen::Quaterniond::Identity());
  const Eigen::Vector3d imaginary = Vector(in);
  double w = std::sqrt(std::max(0.0, 1.0 - imaginary.squaredNorm()));  // The short form.
  if (content.size() == 28) w = Float(in);
  if (content.size() != 24 && content.size() != 28) return std::nullopt;
  return FromQuaternion(t_mm, Eigen::Quaterniond(w, imaginary.x(), imaginary.y(), imaginary.z()));
}

std::optional<std::vector<ToolMatrix>> ReadTrackingData(ByteView content) {
  if (content.size() % IGTL_TDATA_ELEMENT_SIZE != 0) return std::nullopt;
  std::vector<ToolMatrix> tools(content.size() / IGTL_TDATA_ELEMENT_SIZE);
  Reader in(content);
  for (ToolMatrix& tool : tools) {
    tool.name = in.Text(IGTL_TDATA_LEN_NAME);
    in.Take(2);  // Kind of instrument, reserved.
    tool.matrix = Matrix(in);
  }
  return tools;
}

std::optional<std::vector<ToolMatrix>> ReadQuaternionTrackingData(ByteView content) {
  if (content.size() % IGTL_QTDATA_ELEMENT_SIZE != 0) return std::nullopt;
  std::vector<ToolMatrix> tools(content.size() / IGTL_QTDATA_ELEMENT_SIZE);
  Reader in(content);
  for (ToolMatrix& tool : tools) {
    tool.name = in.Text(IGTL_QTDATA_LEN_NAME);
    in.Take(2);
    const Eigen::Vector3d t_mm = Vector(in);
    const Eigen::Vector3d imaginary = Vector(in);
    tool.matrix = FromQuaternion(
        t_mm, Eigen::Quaterniond(Float(in), imaginary.x(), imaginary.y(), imaginary.z()));
  }
  return tools;
}

std::optional<int> ReadStartTrackingData(ByteView content) {
  if (content.size() != IGTL_STT_TDATA_SIZE) return std::nullopt;
  const auto interval_ms = Reader(content).Number<std::int32_t>();
  return std::clamp(interval_ms, 0, 60'000);
}

std::optional<std::string> ReadStatus(ByteView content) {
  if (content.size() < kStatusBytes) return std::nullopt;
  Reader in(content);
  const auto code = in.Number<std::uint16_t>();
  in.Number<std::uint64_t>();  // Sub-code.
  const std::string name = Printable(in.Text(kIgtlNameBytes));
  const std::string text = Printable(in.Text(std::min<std::size_t>(in.left(), 200)));
  std::string all = code == 1 ? "OK" : Message("code ", code);
  // Senders leave the name of the error as it happens to be when there is none.
  if (code != 1 && !name.empty()) all += ": " + name;
  if (!text.empty()) all += ": " + text;
  return all;
}

std::optional<Image> ReadImage(ByteView content) {
  Reader in(content);
  in.Number<std::uint16_t>();  // Version of the format.
  Image image;
  image.channels = in.Number<std::uint8_t>();
  const auto scalar = in.Number<std::uint8_t>();
  in.Take(2);  // Byte order, which bytes do not have; RAS or LPS, which is for scanners.
  image.width = in.Number<std::uint16_t>();
  image.height = in.Number<std::uint16_t>();
  const auto slices = in.Number<std::uint16_t>();
  Eigen::Matrix4d matrix = Matrix(in);
  std::uint16_t offset[3], part[3];
  for (std::uint16_t& value : offset) value = in.Number<std::uint16_t>();
  for (std::uint16_t& value : part) value = in.Number<std::uint16_t>();
  const std::size_t num_bytes = static_cast<std::size_t>(image.width) *
                                static_cast<std::size_t>(image.height) *
                                static_cast<std::size_t>(image.channels);
  const bool whole = part[0] == image.width && part[1] == image.height && part[2] == 1;
  if (!in.ok() || slices != 1 || !whole || num_bytes == 0 || num_bytes != in.left() ||
      (image.channels != 1 && image.channels != 3) || scalar != IGTL_IMAGE_STYPE_TYPE_UINT8) {
    return std::nullopt;
  }
  // The message has the place of the middle of the image.
  const Eigen::Vector4d middle_px(0.5 * (image.width - 1), 0.5 * (image.height - 1), 0.0, 0.0);
  matrix.col(3) -= matrix * middle_px;
  image.reference_from_pixel = matrix;
  const ByteView pixels = in.Take(num_bytes);
  image.pixels.assign(pixels.begin(), pixels.end());
  return image;
}

std::optional<NumberTable> ReadTable(ByteView content) {
  Reader in(content);
  const auto type = in.Number<std::uint8_t>();
  const auto dimensions = in.Number<std::uint8_t>();
  if (type != IGTL_NDARRAY_STYPE_TYPE_FLOAT64 || dimensions != 2) return std::nullopt;
  const std::size_t rows = in.Number<std::uint16_t>();
  const std::size_t columns = in.Number<std::uint16_t>();
  if (!in.ok() || rows == 0 || columns == 0) return std::nullopt;
  if (in.left() != rows * columns * sizeof(double)) return std::nullopt;
  NumberTable table{.columns = columns, .values = std::vector<double>(rows * columns)};
  for (double& value : table.values) value = in.Number<double>();
  return table;
}

std::optional<std::string> ReadText(ByteView content) {
  Reader in(content);
  in.Number<std::uint16_t>();  // Encoding: what we look at is ASCII.
  const auto size = in.Number<std::uint16_t>();
  if (!in.ok() || size != in.left()) return std::nullopt;
  return Printable(in.Text(size));
}

bool SaysValid(const Metadata& metadata) {
  for (const auto& [key, value] : metadata) {
    if (key == "TransformStatus" && value != "OK") return false;
    if (key == "TransformValid" && (value == "false" || value == "0" || value == "FALSE")) {
      return false;
    }
  }
  return true;
}

Bytes PackTransform(std::string_view device, std::int64_t time_ns, const transforms::Pose& pose) {
  return PackMatrix(device, time_ns, pose.matrix());
}

Bytes PackMatrix(std::string_view device, std::int64_t time_ns, const Eigen::Matrix4d& matrix) {
  Writer body;
  Put(body, matrix);
  return Whole("TRANSFORM", device, time_ns, body);
}

Bytes PackTransformWithStatus(std::string_view device, std::int64_t time_ns,
                              const transforms::Pose& pose, bool valid) {
  const std::pair<std::string_view, std::string_view> entries[] = {
      {"TransformValid", valid ? "true" : "false"}, {"TransformStatus", valid ? "OK" : "MISSING"}};
  Writer sizes, texts;
  sizes.Number(static_cast<std::uint16_t>(std::size(entries)));
  for (const auto& [key, value] : entries) {
    sizes.Number(static_cast<std::uint16_t>(key.size()));
    sizes.Number(kAscii);
    sizes.Number(static_cast<std::uint32_t>(value.size()));
    texts.Text(key, key.size());
    texts.Text(value, value.size());
  }
  Writer body;
  body.Number(static_cast<std::uint16_t>(kExtendedHeaderBytes));
  body.Number(static_cast<std::uint16_t>(sizes.bytes.size()));
  body.Number(static_cast<std::uint32_t>(texts.bytes.size()));
  body.Number(std::uint32_t{0});  // Number of the message: not used.
  Put(body, pose.matrix());
  body.Raw(sizes.bytes);
  body.Raw(texts.bytes);
  return Whole("TRANSFORM", device, time_ns, body, 2);
}

Bytes PackTrackingData(std::string_view device, std::int64_t time_ns,
                       std::span<const std::pair<std::string, transforms::Pose>> tools) {
  Writer body;
  for (const auto& [name, pose] : tools) {
    body.Text(name, IGTL_TDATA_LEN_NAME);
    body.Number(std::uint8_t{IGTL_TDATA_TYPE_6D});
    body.Number(std::uint8_t{0});
    Put(body, pose.matrix());
  }
  return Whole("TDATA", device, time_ns, body);
}

Bytes PackStatus(std::string_view device, std::int64_t time_ns, bool ok, std::string_view text) {
  Writer body;
  body.Number(static_cast<std::uint16_t>(ok ? 1 : 13));  // 13: device not ready.
  body.Number(std::uint64_t{0});
  body.Text(ok ? "" : "NotReady", kIgtlNameBytes);
  body.Text(text, text.size() + 1);
  return Whole("STATUS", device, time_ns, body);
}

Bytes PackImage(std::string_view device, std::int64_t time_ns, const Image& image) {
  const auto num_bytes = static_cast<std::size_t>(image.width) *
                         static_cast<std::size_t>(image.height) *
                         static_cast<std::size_t>(image.channels);
  ACUS_ASSERT(num_bytes > 0 && image.pixels.size() == num_bytes);
  ACUS_ASSERT(image.width <= 65535 && image.height <= 65535);
  Writer body;
  body.bytes.reserve(IGTL_IMAGE_HEADER_SIZE + num_bytes);
  body.Number(std::uint16_t{IGTL_IMAGE_HEADER_VERSION});
  body.Number(static_cast<std::uint8_t>(image.channels));
  body.Number(std::uint8_t{IGTL_IMAGE_STYPE_TYPE_UINT8});
  body.Number(std::uint8_t{IGTL_IMAGE_ENDIAN_BIG});
  body.Number(std::uint8_t{IGTL_IMAGE_COORD_RAS});  // What receivers take all frames for.
  const std::uint16_t size[] = {static_cast<std::uint16_t>(image.width),
                                static_cast<std::uint16_t>(image.height), 1};
  for (const std::uint16_t value : size) body.Number(value);
  Eigen::Matrix4d matrix = image.reference_from_pixel;
  matrix.col(3) +=
      matrix * Eigen::Vector4d(0.5 * (image.width - 1), 0.5 * (image.height - 1), 0.0, 0.0);
  Put(body, matrix);
  for (int i = 0; i < 3; ++i) body.Number(std::uint16_t{0});
  for (const std::uint16_t value : size) body.Number(value);
  body.Raw(image.pixels);
  return Whole("IMAGE", device, time_ns, body);
}

Bytes PackTable(std::string_view device, std::int64_t time_ns, const NumberTable& table) {
  ACUS_ASSERT(table.columns > 0 && table.columns <= 65535 && !table.values.empty());
  const std::size_t rows = table.values.size() / table.columns;
  ACUS_ASSERT(rows * table.columns == table.values.size() && rows <= 65535);
  Writer body;
  body.Number(std::uint8_t{IGTL_NDARRAY_STYPE_TYPE_FLOAT64});
  body.Number(std::uint8_t{2});
  body.Number(static_cast<std::uint16_t>(rows));
  body.Number(static_cast<std::uint16_t>(table.columns));
  for (const double value : table.values) body.Number(value);
  return Whole("NDARRAY", device, time_ns, body);
}

Bytes PackText(std::string_view device, std::string_view text) {
  ACUS_ASSERT(text.size() <= 65535);
  Writer body;
  body.Number(kAscii);
  body.Number(static_cast<std::uint16_t>(text.size()));
  body.Text(text, text.size());
  return Whole("STRING", device, 0, body);
}

Bytes PackVolume(std::string_view device, std::int64_t time_ns, const VolumeView& volume) {
  const auto [size, voxels, matrix] = volume;
  const bool is_hu = std::holds_alternative<std::span<const std::int16_t>>(voxels);
  const ByteView bytes = std::visit(
      [](const auto& of) {
        return ByteView(reinterpret_cast<const std::uint8_t*>(of.data()), of.size_bytes());
      },
      voxels);
  std::size_t expected = is_hu ? sizeof(std::int16_t) : 1;
  for (const int side : size) {
    ACUS_ASSERT(side >= 1 && side <= 65535);
    expected *= static_cast<std::size_t>(side);
  }
  ACUS_ASSERT(bytes.size() == expected);
  Writer body;
  body.Number(std::uint16_t{IGTL_IMAGE_HEADER_VERSION});
  body.Number(std::uint8_t{1});
  const int type = is_hu ? IGTL_IMAGE_STYPE_TYPE_INT16 : IGTL_IMAGE_STYPE_TYPE_UINT8;
  body.Number(static_cast<std::uint8_t>(type));
  static_assert(std::endian::native == std::endian::little, "voxels are sent as they lie here");
  body.Number(std::uint8_t{IGTL_IMAGE_ENDIAN_LITTLE});
  body.Number(std::uint8_t{IGTL_IMAGE_COORD_RAS});
  for (const int side : size) body.Number(static_cast<std::uint16_t>(side));
  const Eigen::Vector4d middle(0.5 * (size[0] - 1), 0.5 * (size[1] - 1), 0.5 * (size[2] - 1), 0.0);
  Eigen::Matrix4d placed = matrix;
  placed.col(3) += matrix * middle;
  Put(body, placed);
  for (int i = 0; i < 3; ++i) body.Number(std::uint16_t{0});
  for (const int side : size) body.Number(static_cast<std::uint16_t>(side));
  return Whole("IMAGE", device, time_ns, body, 1, bytes);
}

Bytes PackPoints(std::string_view device, std::int64_t time_ns,
                 std::span<const NamedPoint> points) {
  Writer body;
  for (const NamedPoint& point : points) {
    body.Text(point.name, IGTL_POINT_LEN_NAME);
    body.Text("Acus", IGTL_POINT_LEN_GROUP_NAME);
    for (const int part : {255, 0, 0, 255}) body.Number(static_cast<std::uint8_t>(part));
    for (int i = 0; i < 3; ++i) Put(body, point.ras_mm[i]);
    Put(body, point.diameter_mm);
    body.Text("", IGTL_POINT_LEN_OWNER);
  }
  return Whole("POINT", device, time_ns, body);
}

Bytes PackStartTrackingData(std::string_view device, int interval_ms) {
  Writer body;
  body.Number(static_cast<std::uint32_t>(interval_ms));
  body.Text("Reference", IGTL_STT_TDATA_LEN_COORDNAME);
  return Whole("STT_TDATA", device, 0, body);
}

Bytes PackStopTrackingData(std::string_view device) {
  return PackQuery("STP_TDATA", device);
}

Bytes PackTrackingDataReply(std::string_view device, bool ok) {
  Writer body;
  body.Number(static_cast<std::uint8_t>(ok ? 0 : 1));
  return Whole("RTS_TDATA", device, 0, body);
}

Bytes PackCapability(std::string_view device, std::span<const std::string> types) {
  Writer body;
  for (const std::string& type : types) body.Text(type, IGTL_HEADER_TYPE_SIZE);
  return Whole("CAPABILITY", device, 0, body);
}

Bytes PackQuery(std::string_view type, std::string_view device) {
  return Whole(type, device, 0, Writer());
}

std::uint64_t StampFromNs(std::int64_t time_ns) {
  if (time_ns <= 0) return 0;
  const auto seconds = static_cast<std::uint64_t>(time_ns / 1'000'000'000);
  const auto ns = static_cast<std::uint64_t>(time_ns % 1'000'000'000);
  // Rounded; 999,999,999.9 ns may carry over into the seconds, which the sum does by itself.
  return (seconds << 32) + ((ns << 32) + 500'000'000) / 1'000'000'000;
}

std::int64_t NsFromStamp(std::uint64_t stamp) {
  const std::uint64_t fraction = stamp & 0xffffffffu;
  return static_cast<std::int64_t>((stamp >> 32) * 1'000'000'000 +
                                   ((fraction * 1'000'000'000 + (std::uint64_t{1} << 31)) >> 32));
}

}  // namespace acus::tracking
