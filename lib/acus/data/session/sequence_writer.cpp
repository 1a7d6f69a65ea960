#include "acus/data/session/sequence_writer.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/transforms/transform_graph.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestFieldLine = 1000;  // PLUS reads lines of up to that many characters.
// Speckle hardly repeats: looking for nothing but runs is faster, and files are about as small.
// tests/performance/sequence_speed_test.cpp measures both.
constexpr int kZlibLevel = 1;
constexpr int kZlibStrategy = Z_RLE;

/// An open file descriptor whose every failure is reported.
class OutputFile {
 public:
  explicit OutputFile(const fs::path& path)
      : name_(path.string()), fd_(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0666)) {
    ACUS_REQUIRE(fd_ >= 0, name_, ": cannot be written");
  }
  ~OutputFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void Write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ::ssize_t count = ::write(fd_, bytes.data(), bytes.size());
      ACUS_REQUIRE(count > 0, name_, ": cannot be written; is the disk full?");
      bytes = bytes.subspan(static_cast<std::size_t>(count));
      size_ += static_cast<std::uint64_t>(count);
    }
  }
  void Write(std::string_view text) {
    Write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }

  /// Appends the whole of `other`; the kernel copies, or shares the blocks where it can.
  void Append(const OutputFile& other) {
    ::loff_t from = 0;
    auto left = static_cast<std::int64_t>(other.size_);
    while (left > 0) {
      const ::ssize_t count =
          ::copy_file_range(other.fd_, &from, fd_, nullptr, static_cast<std::size_t>(left), 0);
      if (count <= 0) break;  // Not on every file system: then by hand.
      left -= count;
    }
    std::vector<std::uint8_t> buffer(left > 0 ? 1U << 20U : 0);
    while (left > 0) {
      const ::ssize_t count = ::pread(other.fd_, buffer.data(), buffer.size(), from);
      ACUS_REQUIRE(count > 0, other.name_, ": cannot be read back");
      Write({buffer.data(), static_cast<std::size_t>(count)});
      from += count;
      left -= count;
    }
  }

  std::uint64_t size() const { return size_; }

 private:
  std::string name_;
  int fd_;
  std::uint64_t size_ = 0;
};

/// Deflates into a file.
class Deflater {
 public:
  Deflater(OutputFile& file, bool gzip) : file_(file), buffer_(1U << 18U) {
    ACUS_REQUIRE(deflateInit2(&stream_, kZlibLevel, Z_DEFLATED, gzip ? 15 + 16 : 15, 8,
                              kZlibStrategy) == Z_OK,
                 "zlib cannot be started");
  }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  void Write(std::span<const std::uint8_t> bytes, int flush) {
    stream_.next_in = const_cast<Bytef*>(bytes.data());  // zlib only reads there.
    stream_.avail_in = static_cast<uInt>(bytes.size());
    do {
      stream_.next_out = buffer_.data();
      stream_.avail_out = static_cast<uInt>(buffer_.size());
      const int result = deflate(&stream_, flush);
      ACUS_ASSERT(result != Z_STREAM_ERROR);
      file_.Write({buffer_.data(), buffer_.size() - stream_.avail_out});
    } while (stream_.avail_out == 0);
  }

 private:
  OutputFile& file_;
  std::vector<std::uint8_t> buffer_;
  z_stream stream_ = {};
};

void RequireOneLine(std::string_view name, std::string_view value) {
  ACUS_REQUIRE(!name.empty() && name.find_first_of("=: \t\r\n") == name.npos, "sequence field '",
               name, "': a name must have no blank, '=', ':' or line end");
  ACUS_REQUIRE(value.find_first_of("\r\n") == value.npos &&
                   name.size() + value.size() < kLongestFieldLine - 30,
               "sequence field '", name, "': its value must be one line, of less than ",
               kLongestFieldLine - 30, " characters with the name");
}

}  // namespace

/// Pixels go to a hidden file beside the target: the header comes first in the file, but is only
/// known when all frames are.
class SequenceWriter::State {
 public:
  State(const fs::path& path, const SequenceFormat& format)
      : is_nrrd_(path.extension() == ".nrrd"),
        format_(format),
        target_(path),
        pixel_file_(path.string() + ".pixels"),
        pixels_(pixel_file_.path()) {
    ACUS_REQUIRE(is_nrrd_ || path.extension() == ".mha", path.string(),
                 ": the ending must be .igs.mha or .igs.nrrd");
    ACUS_REQUIRE((format.width > 0) == (format.height > 0) && format.width <= 65536 &&
                     format.height <= 65536 && format.channels >= 1 && format.channels <= 4,
                 path.string(), ": images of ", format.width, " x ", format.height, " x ",
                 format.channels, " cannot be written");
    ACUS_REQUIRE(!is_nrrd_ || format.width > 0, path.string(),
                 ": NRRD cannot hold a recording without images; write .igs.mha");
    for (const auto& [name, value] : format.fields) RequireOneLine(name, value);
    if (format.compressed) deflater_ = std::make_unique<Deflater>(pixels_, is_nrrd_);
  }

  void AddFrame(std::int64_t time_ns, std::span<const std::uint8_t> image,
                const SequenceFields& fields) {
    ACUS_REQUIRE(num_frames_ == 0 || time_ns > last_time_ns_, "sequence frame ", num_frames_,
                 ": its time ", SecondsText(time_ns), " s is not later than the one before it");
    const std::size_t size = format_.width * format_.height * format_.channels;
    ACUS_REQUIRE(image.size() == size || image.empty(), "sequence frame ", num_frames_,
                 ": the image has ", image.size(), " bytes instead of ", size);
    for (const auto& [name, value] : fields) RequireOneLine(name, value);
    const bool missing = image.empty();
    if (missing) {
      black_.resize(size);
      image = black_;
    }
    if (deflater_ != nullptr) {
      deflater_->Write(image, Z_NO_FLUSH);
    } else {
      pixels_.Write(image);
    }
    for (const auto& [name, value] : fields) AddLine(name, value);
    AddLine("Timestamp", SecondsText(time_ns));
    AddLine("ImageStatus", missing ? "INVALID" : "OK");
    last_time_ns_ = time_ns;
    ++num_frames_;
  }

  void Commit() {
    ACUS_REQUIRE(num_frames_ > 0, "a sequence without a frame is not written");
    if (deflater_ != nullptr) deflater_->Write({}, Z_FINISH);
    OutputFile file(target_.path());
    file.Write(is_nrrd_ ? NrrdHeader() : MetaHeader());
    file.Write(frame_lines_);
    file.Write(is_nrrd_ ? "\n" : "ElementDataFile = LOCAL\n");
    file.Append(pixels_);
    target_.Commit();
  }

  std::size_t num_frames() const { return num_frames_; }

 private:
  bool has_images() const { return format_.width > 0; }

  void AddLine(std::string_view name, std::string_view value) {
    std::array<char, 40> prefix{};
    std::snprintf(prefix.data(), prefix.size(), "Seq_Frame%04zu_", num_frames_);
    frame_lines_.append(prefix.data()).append(name).append(is_nrrd_ ? ":=" : " = ");
    frame_lines_.append(value).append("\n");
  }

  std::string MetaHeader() const {
    std::string text =
        "ObjectType = Image\nNDims = 3\nAnatomicalOrientation = RAI\n"
        "BinaryData = True\nBinaryDataByteOrderMSB = False\nCenterOfRotation = 0 0 0\n";
    text += Message("CompressedData = ", format_.compressed ? "True" : "False", "\n");
    if (format_.compressed) text += Message("CompressedDataSize = ", pixels_.size(), "\n");
    text += Message("DimSize = ", format_.width, " ", format_.height, " ", num_frames_, "\n");
    text += "Kinds = domain domain list\n";
    if (format_.channels > 1) text += Message("ElementNumberOfChannels = ", format_.channels, "\n");
    text +=
        Message("ElementSpacing = 1 1 1\nElementType = ", has_images() ? "MET_UCHAR" : "MET_OTHER",
                "\nOffset = 0 0 0\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n");
    text +=
        Message("UltrasoundImageOrientation = ", has_images() ? format_.orientation : "XX", "\n");
    text += Message("UltrasoundImageType = ", has_images() ? format_.image_type : "XX", "\n");
    for (const auto& [name, value] : format_.fields) text += Message(name, " = ", value, "\n");
    return text;
  }

  std::string NrrdHeader() const {
    const bool colour = format_.channels > 1;
    std::string text = Message("NRRD0004\ntype: uint8\ndimension: ", colour ? 4 : 3, "\n");
    text += Message("kinds: ",
                    !colour                 ? ""
                    : format_.channels == 3 ? "RGB-color "
                                            : "vector ",
                    "domain domain list\nsizes: ");
    if (colour) text += Message(format_.channels, " ");
    text += Message(format_.width, " ", format_.height, " ", num_frames_,
                    "\nencoding: ", format_.compressed ? "gzip" : "raw", "\nendian: little\n");
    text +=
        Message("ultrasound image orientation:=", has_images() ? format_.orientation : "XX", "\n");
    text += Message("ultrasound image type:=", has_images() ? format_.image_type : "XX", "\n");
    for (const auto& [name, value] : format_.fields) text += Message(name, ":=", value, "\n");
    return text;
  }

  bool is_nrrd_;
  SequenceFormat format_;
  AtomicFile target_;
  AtomicFile pixel_file_;  ///< Never committed: gone with this object.
  OutputFile pixels_;
  std::unique_ptr<Deflater> deflater_;
  std::vector<std::uint8_t> black_;
  std::string frame_lines_;
  std::size_t num_frames_ = 0;
  std::int64_t last_time_ns_ = 0;
};

std::string TransformText(const Eigen::Matrix4d& to_from_from) {
  std::string text;
  for (int i = 0; i < 16; ++i) {
    if (i > 0) text += ' ';
    text += NumberText(to_from_from(i / 4, i % 4));
  }
  return text;
}

void AddTransform(SequenceFields& fields, std::string_view name,
                  const Eigen::Matrix4d& to_from_from, bool valid) {
  ACUS_REQUIRE(transforms::ParseTransformName(name), "'", name,
               "' is not the name of a transform such as ", "ProbeToReference");
  fields.emplace_back(Message(name, "Transform"), TransformText(to_from_from));
  fields.emplace_back(Message(name, "TransformStatus"), valid ? "OK" : "INVALID");
}

SequenceWriter::SequenceWriter(const fs::path& path, const SequenceFormat& format)
    : state_(std::make_unique<State>(path, format)) {}
SequenceWriter::~SequenceWriter() = default;
void SequenceWriter::AddFrame(std::int64_t time_ns, std::span<const std::uint8_t> image,
                              const SequenceFields& fields) {
  state_->AddFrame(time_ns, image, fields);
}
std::size_t SequenceWriter::num_frames() const {
  return state_->num_frames();
}
void SequenceWriter::Commit() {
  state_->Commit();
}

}  // namespace acus::session
