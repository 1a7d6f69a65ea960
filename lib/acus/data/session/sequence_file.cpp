#include "acus/data/session/sequence_file.h"

#include <algorithm>
#include <fstream>
#include <zlib.h>

#include "acus/base/core/error.h"
#include "acus/data/session/pose_csv.h"

namespace acus::session {
namespace {

constexpr std::string_view kTransform = "Transform";
constexpr std::size_t kChunkBytes = 1U << 18U;

}  // namespace

/// The pixels of the file as one stream of bytes; remembers where it is.
class SequenceFile::Pixels {
 public:
  Pixels(const std::filesystem::path& path, std::uint64_t offset, bool compressed)
      : path_(path), offset_(offset), compressed_(compressed), file_(path, std::ios::binary) {
    ACUS_REQUIRE(file_, path.string(), ": cannot be read; the images of the sequence are in it");
    if (compressed_) buffer_.resize(kChunkBytes);
    Rewind();
  }
  ~Pixels() {
    if (compressed_) inflateEnd(&stream_);
  }
  Pixels(const Pixels&) = delete;
  Pixels& operator=(const Pixels&) = delete;

  /// Fills `out` with what is at `position` of the (inflated) pixels.
  void Read(std::uint64_t position, std::vector<std::uint8_t>& out, bool is_last) {
    if (!compressed_) {
      file_.clear();
      file_.seekg(static_cast<std::streamoff>(offset_ + position));
      file_.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
      ACUS_REQUIRE(file_, path_.string(), ": the images end early; is the file cut off?");
      return;
    }
    if (position < position_) Rewind();
    std::vector<std::uint8_t> skipped;
    while (position_ < position) {
      skipped.resize(std::min<std::uint64_t>(position - position_, kChunkBytes));
      Inflate(skipped);
    }
    Inflate(out);
    if (is_last) VerifyChecksum();
  }

 private:
  void Rewind() {
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset_));
    position_ = 0;
    has_ended_ = false;
    if (!compressed_) return;
    inflateEnd(&stream_);
    stream_ = {};
    ACUS_REQUIRE(inflateInit2(&stream_, 15 + 32) == Z_OK,
                 "zlib cannot be started");  // zlib or gzip.
  }

  void Inflate(std::vector<std::uint8_t>& out) {
    stream_.next_out = out.data();
    stream_.avail_out = static_cast<uInt>(out.size());
    while (stream_.avail_out > 0) {
      ACUS_REQUIRE(FillInput(), path_.string(),
                   ": the compressed images end early; is the file cut off?");
      const int result = inflate(&stream_, Z_NO_FLUSH);
      has_ended_ = result == Z_STREAM_END;
      RequireSound(result == Z_OK || (has_ended_ && stream_.avail_out == 0));
    }
    position_ += out.size();
  }

  /// Behind the last frame stands the checksum of all of them; zlib looks at it on request
  /// more.
  void VerifyChecksum() {
    std::uint8_t beyond = 0;
    stream_.next_out = &beyond;
    stream_.avail_out = 1;
    int result = has_ended_ ? Z_STREAM_END : Z_OK;
    while (result == Z_OK && stream_.avail_out == 1 && FillInput()) {
      result = inflate(&stream_, Z_NO_FLUSH);
    }
    RequireSound(result == Z_STREAM_END || (result == Z_OK && stream_.avail_out == 0));
    Rewind();
  }

  /// @returns false at the end of the file.
  bool FillInput() {
    if (stream_.avail_in > 0) return true;
    file_.read(reinterpret_cast<char*>(buffer_.data()),
               static_cast<std::streamsize>(buffer_.size()));
    stream_.next_in = buffer_.data();
    stream_.avail_in = static_cast<uInt>(file_.gcount());
    return stream_.avail_in > 0;
  }

  void RequireSound(bool sound) const {
    ACUS_REQUIRE(sound, path_.string(), ": the compressed images are damaged",
                 stream_.msg != nullptr ? Message(" (", stream_.msg, ")") : "",
                 "; copy the file again");
  }

  std::filesystem::path path_;
  std::uint64_t offset_;
  bool compressed_;
  std::ifstream file_;
  z_stream stream_ = {};
  std::vector<std::uint8_t> buffer_;
  std::uint64_t position_ = 0;
  bool has_ended_ = false;  ///< zlib has seen the end, and found the checksum right.
};

SequenceFile::SequenceFile(const std::filesystem::path& path) : path_(path), header_(path) {}

SequenceFile::~SequenceFile() = default;

std::string SequenceFile::Where(std::size_t frame, std::string_view field) const {
  return Message(path_.string(), ": frame ", frame, ": ", field);
}

std::optional<std::int64_t> SequenceFile::TimeNs(std::size_t frame) const {
  const auto text = header_.Field(frame, "Timestamp");
  if (!text) return {};
  const auto time_ns = NanosecondsFromText(*text);
  ACUS_REQUIRE(time_ns, Where(frame, "Timestamp"), " is '", *text,
               "'; a finite number of seconds is needed");
  return time_ns;
}

transforms::TransformGraph SequenceFile::Transforms(std::size_t frame) const {
  transforms::TransformGraph graph;
  const auto add = [&](const std::string& field, std::string_view value, std::string_view status) {
    const auto name =
        field.ends_with(kTransform) ? transforms::ParseTransformName(field) : std::nullopt;
    if (!name) return;
    const auto numbers = NumbersOf(value);
    const bool valid = status == "OK";
    // A tracker may write anything for a tool that it does not see.
    ACUS_REQUIRE(!valid || (numbers && numbers->size() == 16), Where(frame, field), " is '",
                 value.substr(0, 80),
                 "'; 16 finite numbers are needed (or a status other than OK)");
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    if (numbers && numbers->size() == 16) {
      matrix = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers->data());
    }
    graph.Set(*name, matrix, valid);
  };
  for (const auto& [field, value] : header_.fields()) add(field, value, "OK");
  for (const std::string& field : header_.frame_field_names()) {
    const auto value = header_.Field(frame, field);
    if (value) add(field, *value, header_.Field(frame, field + "Status").value_or("OK"));
  }
  return graph;
}

std::string SequenceFile::Orientation() const {
  for (const char* name : {"UltrasoundImageOrientation", "ultrasound image orientation"}) {
    if (const auto value = header_.Field(name)) return std::string(*value);
  }
  return "MF";  // As PLUS takes it.
}

std::vector<std::uint8_t> SequenceFile::ReadImage(std::size_t frame) {
  ACUS_REQUIRE(has_images(), path_.string(), ": is a recording without images");
  ACUS_REQUIRE(frame < num_frames(), path_.string(), ": has no frame ", frame, "; the last is ",
               num_frames() - 1);
  if (pixels_ == nullptr) {
    pixels_ = std::make_unique<Pixels>(header_.data_path, header_.data_offset, header_.compressed);
  }
  const std::size_t size = header_.bytes_per_frame();
  std::vector<std::uint8_t> bytes(size);
  pixels_->Read(std::uint64_t{size} * frame, bytes, frame + 1 == num_frames());
  const std::size_t width = BytesOf(header_.pixel_type);
  if (header_.big_endian && width > 1) {
    for (std::size_t i = 0; i < size; i += width) {
      std::reverse(bytes.begin() + i, bytes.begin() + i + width);
    }
  }
  return bytes;
}

SequenceFile::Image SequenceFile::ReadImageMarkedFar(std::size_t frame) {
  const std::string orientation = Orientation();
  const char columns = orientation.empty() ? 'X' : orientation[0];
  const char rows = orientation.size() < 2 ? 'X' : orientation[1];
  const auto across = [](char axis) { return axis == 'M' || axis == 'U'; };
  const auto along = [](char axis) { return axis == 'F' || axis == 'N'; };
  const bool turned = along(columns);  // Each row is a scan line.
  ACUS_REQUIRE(turned ? across(rows) : across(columns) && along(rows), path_.string(),
               ": UltrasoundImageOrientation is '", orientation,
               "'; two letters are needed: M or U (marked, unmarked side) and F or N (far, near)");
  const std::vector<std::uint8_t> stored = ReadImage(frame);
  const bool flip_x = (turned ? rows : columns) == 'U';
  const bool flip_y = (turned ? columns : rows) == 'N';
  Image image;
  image.width = turned ? header_.height : header_.width;
  image.height = turned ? header_.width : header_.height;
  image.pixels.resize(stored.size());
  const std::size_t bytes = header_.channels * BytesOf(header_.pixel_type);
  std::uint8_t* to = image.pixels.data();
  for (std::size_t y = 0; y < image.height; ++y) {
    for (std::size_t x = 0; x < image.width; ++x, to += bytes) {
      const std::size_t from_x = flip_x ? image.width - 1 - x : x;
      const std::size_t from_y = flip_y ? image.height - 1 - y : y;
      const std::size_t pixel =
          turned ? from_x * header_.width + from_y : from_y * header_.width + from_x;
      std::copy_n(stored.data() + pixel * bytes, bytes, to);
    }
  }
  return image;
}

}  // namespace acus::session
