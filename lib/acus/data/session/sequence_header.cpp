#include "acus/data/session/sequence_header.h"

#include <algorithm>
#include <fstream>
#include <map>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/words.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;

// A header line of PLUS has at most 1000 characters; a binary file that is not a sequence may have
// no line end at all.
constexpr std::size_t kMaxLine = 1U << 16U;
constexpr std::uint64_t kMaxHeaderBytes = std::uint64_t{1} << 31U;
constexpr std::uint64_t kMaxSide = 1U << 16U;
constexpr std::uint64_t kMaxFrameBytes = std::uint64_t{1} << 30U;
constexpr std::uint64_t kMaxUntimedFrames = 1'000'000;
// No zlib stream grows by more than this (deflate codes 258 bytes in 2 bits).
constexpr std::uint64_t kMaxInflation = 1032;
constexpr std::string_view kFramePrefix = "Seq_Frame";

std::vector<std::string_view> Words(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  std::vector<std::string_view> words;
  for (std::size_t begin = 0; begin < text.size();) {
    begin = text.find_first_not_of(kBlank, begin);
    if (begin == text.npos) break;
    const std::size_t end = std::min(text.find_first_of(kBlank, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = end;
  }
  return words;
}

std::optional<PixelType> TypeOf(std::string_view word) {
  static const std::map<std::string_view, PixelType> kTypes = {
      {"MET_OTHER", PixelType::kNone},      {"MET_UCHAR", PixelType::kUint8},
      {"MET_CHAR", PixelType::kInt8},       {"MET_USHORT", PixelType::kUint16},
      {"MET_SHORT", PixelType::kInt16},     {"MET_UINT", PixelType::kUint32},
      {"MET_INT", PixelType::kInt32},       {"MET_FLOAT", PixelType::kFloat},
      {"MET_DOUBLE", PixelType::kDouble},   {"uchar", PixelType::kUint8},
      {"unsigned char", PixelType::kUint8}, {"uint8", PixelType::kUint8},
      {"uint8_t", PixelType::kUint8},       {"signed char", PixelType::kInt8},
      {"int8", PixelType::kInt8},           {"int8_t", PixelType::kInt8},
      {"ushort", PixelType::kUint16},       {"unsigned short", PixelType::kUint16},
      {"uint16", PixelType::kUint16},       {"uint16_t", PixelType::kUint16},
      {"short", PixelType::kInt16},         {"int16", PixelType::kInt16},
      {"int16_t", PixelType::kInt16},       {"uint", PixelType::kUint32},
      {"unsigned int", PixelType::kUint32}, {"uint32", PixelType::kUint32},
      {"uint32_t", PixelType::kUint32},     {"int", PixelType::kInt32},
      {"int32", PixelType::kInt32},         {"int32_t", PixelType::kInt32},
      {"float", PixelType::kFloat},         {"double", PixelType::kDouble}};
  const auto found = kTypes.find(word);
  if (found == kTypes.end()) return {};
  return found->second;
}

}  // namespace

std::size_t BytesOf(PixelType type) {
  switch (type) {
    case PixelType::kNone:
      return 0;
    case PixelType::kUint8:
    case PixelType::kInt8:
      return 1;
    case PixelType::kUint16:
    case PixelType::kInt16:
      return 2;
    case PixelType::kUint32:
    case PixelType::kInt32:
    case PixelType::kFloat:
      return 4;
    case PixelType::kDouble:
      return 8;
  }
  return 0;
}

std::optional<std::vector<double>> NumbersOf(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view word : Words(text)) {
    const auto value = ParseFinite(word);
    if (!value) return {};
    numbers.push_back(*value);
  }
  return numbers;
}

std::optional<std::string_view> SequenceHeader::Field(std::size_t frame,
                                                      std::string_view name) const {
  for (const FieldText& field : frames_.at(frame)) {
    if (names_[field.name] == name) {
      return std::string_view(text_).substr(field.offset, field.length);
    }
  }
  return {};
}

std::optional<std::string_view> SequenceHeader::Field(std::string_view name) const {
  for (const auto& [key, value] : fields_) {
    if (key == name) return value;
  }
  return {};
}

/// Reads line by line up to the pixels, then holds the declared sizes against the file's.
class SequenceHeaderReader {
 public:
  SequenceHeaderReader(const fs::path& path, SequenceHeader& header)
      : path_(path), header_(header), file_(path, std::ios::binary) {
    std::error_code error;
    file_bytes_ = fs::file_size(path, error);
    ACUS_REQUIRE(!error && file_, path.string(), ": cannot be read");
  }

  void Read() {
    std::string_view line;
    ACUS_REQUIRE(NextLine(line), path_.string(), ": is empty");
    is_nrrd_ = line.starts_with("NRRD000");
    ACUS_REQUIRE(is_nrrd_ || line.starts_with("ObjectType") || line.starts_with("NDims"),
                 path_.string(),
                 ": is not a sequence file: it must begin with 'ObjectType = Image' "
                 "(.igs.mha) or 'NRRD000' (.igs.nrrd)");
    bool at_pixels = !is_nrrd_ && MetaLine(line);
    while (!at_pixels) {
      ACUS_REQUIRE(NextLine(line), path_.string(), ":", line_number_,
                   ": the header ends early; is the file cut off? It must end with ",
                   is_nrrd_ ? "an empty line" : "'ElementDataFile = ...'");
      at_pixels = is_nrrd_ ? NrrdLine(line) : MetaLine(line);
    }
    if (header_.data_path.empty()) {
      header_.data_path = path_;
      header_.data_offset = header_.text_.size();
    }
    CheckSizes();
  }

 private:
  /// The next line without its end. Views into text_ stay valid only until the next call.
  bool NextLine(std::string_view& line) {
    std::string& text = header_.text_;
    line_begin_ = text.size();
    for (;;) {
      const int byte = file_.rdbuf()->sbumpc();
      if (byte == std::char_traits<char>::eof()) {
        if (text.size() == line_begin_) return false;
        break;
      }
      text += static_cast<char>(byte);
      if (byte == '\n') break;
      ACUS_REQUIRE(text.size() - line_begin_ < kMaxLine && text.size() < kMaxHeaderBytes,
                   path_.string(), ":", line_number_ + 1, ": the line is longer than ", kMaxLine,
                   " characters; this is not the header of a sequence file");
    }
    ++line_number_;
    line = std::string_view(text).substr(line_begin_);
    while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
    ACUS_REQUIRE(line.find('\0') == line.npos, Where(),
                 ": has a zero byte; this is not the header of a sequence file");
    return true;
  }

  /// @returns true at the last line of the header.
  bool MetaLine(std::string_view line) {
    if (Trimmed(line).empty()) return false;
    const std::size_t equals = line.find('=');
    ACUS_REQUIRE(equals != line.npos, Where(), ": 'name = value' is expected, got '",
                 line.substr(0, 40), "'");
    const std::string_view name = Trimmed(line.substr(0, equals));
    const std::string_view value = Trimmed(line.substr(equals + 1));
    AddField(name, value);
    if (name == "DimSize") {
      SetSizes(Words(value));
    } else if (name == "NDims") {
      ACUS_REQUIRE(value == "3" || value == "2", Where(), ": NDims is '", value,
                   "'; sequences of images have 3 (volumes are not read here)");
    } else if (name == "ElementType") {
      SetType(value);
    } else if (name == "ElementNumberOfChannels") {
      SetChannels(value);
    } else if (name == "CompressedData") {
      header_.compressed = Flag(value);
    } else if (name == "BinaryDataByteOrderMSB" || name == "ElementByteOrderMSB") {
      header_.big_endian = Flag(value);
    } else if (name == "BinaryData") {
      ACUS_REQUIRE(Flag(value), Where(),
                   ": BinaryData is False; pixels written as text are not read");
    } else if (name == "CompressedDataSize") {
      compressed_bytes_ = ParseNumber<std::uint64_t>(value);
      ACUS_REQUIRE(compressed_bytes_, Where(), ": CompressedDataSize is '", value,
                   "'; a whole number is needed");
    } else if (name == "ElementDataFile") {
      SetDataFile(value);
      return true;
    }
    return false;
  }

  /// @returns true at the empty line that ends the header.
  bool NrrdLine(std::string_view line) {
    if (line.empty()) return true;
    if (line.front() == '#') return false;
    const std::size_t colon = line.find(':');
    ACUS_REQUIRE(colon != line.npos, Where(), ": 'name: value' is expected, got '",
                 line.substr(0, 40), "'");
    const bool is_key = colon + 1 < line.size() && line[colon + 1] == '=';
    const std::string_view name = Trimmed(line.substr(0, colon));
    const std::string_view value = Trimmed(line.substr(colon + (is_key ? 2 : 1)));
    AddField(name, value);
    if (is_key) return false;
    if (name == "sizes") {
      nrrd_sizes_ = std::vector<std::string>();
      for (const auto word : Words(value)) nrrd_sizes_.emplace_back(word);
    } else if (name == "kinds") {
      for (const auto word : Words(value)) nrrd_kinds_.emplace_back(word);
    } else if (name == "type") {
      SetType(value);
    } else if (name == "encoding") {
      ACUS_REQUIRE(value == "raw" || value == "gzip" || value == "gz", Where(), ": encoding is '",
                   value, "'; allowed: raw, gzip");
      header_.compressed = value != "raw";
    } else if (name == "endian") {
      ACUS_REQUIRE(value == "little" || value == "big", Where(), ": endian is '", value,
                   "'; allowed: little, big");
      header_.big_endian = value == "big";
    } else if (name == "data file" || name == "datafile" || name == "byte skip" ||
               name == "byteskip" || name == "line skip" || name == "lineskip") {
      throw InputError(Message(Where(), ": '", name,
                               "' is not read; save the pixels in the same "
                               "file, right behind the header"));
    }
    return false;
  }

  void AddField(std::string_view name, std::string_view value) {
    if (!name.starts_with(kFramePrefix)) {
      header_.fields_.emplace_back(name, value);
      return;
    }
    const std::size_t underscore = name.find('_', kFramePrefix.size());
    const auto frame = ParseNumber<std::uint64_t>(name.substr(
        kFramePrefix.size(), underscore == name.npos ? 0 : underscore - kFramePrefix.size()));
    ACUS_REQUIRE(frame && underscore + 1 < name.size(), Where(), ": '", name,
                 "' is not the name of a frame's field (Seq_Frame0000_Name)");
    // Each frame has a line of more than 10 bytes: a larger number is not one of this file.
    ACUS_REQUIRE(*frame < file_bytes_ / 10 + 1, Where(), ": frame ", *frame,
                 " cannot be in a file of ", file_bytes_, " bytes");
    if (*frame >= header_.frames_.size()) header_.frames_.resize(*frame + 1);
    auto& fields = header_.frames_[*frame];
    const std::uint32_t index = IndexOf(name.substr(underscore + 1));
    ACUS_REQUIRE(std::ranges::find(fields, index, &SequenceHeader::FieldText::name) == fields.end(),
                 Where(), ": '", name, "' is given twice");
    const auto offset = static_cast<std::uint64_t>(value.data() - header_.text_.data());
    fields.push_back({index, static_cast<std::uint32_t>(value.size()),
                      value.empty() ? std::uint64_t{0} : offset});
  }

  std::uint32_t IndexOf(std::string_view name) {
    auto& names = header_.names_;
    const auto found = std::ranges::find(names, name);
    const auto index = static_cast<std::uint32_t>(found - names.begin());
    if (found == names.end()) {
      ACUS_REQUIRE(names.size() < 1000, Where(), ": more than 1000 different fields");
      names.emplace_back(name);
    }
    return index;
  }

  void SetSizes(const std::vector<std::string_view>& words) {
    ACUS_REQUIRE(words.size() == 2 || words.size() == 3, Where(), ": the size has ", words.size(),
                 " numbers; width, height and number of frames are needed");
    const auto width = ParseNumber<std::uint64_t>(words[0]);
    const auto height = ParseNumber<std::uint64_t>(words[1]);
    const auto frames =
        words.size() == 3 ? ParseNumber<std::uint64_t>(words[2]) : std::optional<std::uint64_t>(1);
    ACUS_REQUIRE(
        width && height && frames && *width <= kMaxSide && *height <= kMaxSide && *frames >= 1,
        Where(), ": the size is not three whole numbers (width and height at most ", kMaxSide,
        ", at least one frame)");
    header_.width = *width;
    header_.height = *height;
    num_frames_ = *frames;
  }

  void SetType(std::string_view value) {
    const auto type = TypeOf(value);
    ACUS_REQUIRE(type, Where(), ": pixels of type '", value,
                 "' are not read; allowed: 8, 16 or 32 bit integers, float, double");
    header_.pixel_type = *type;
    has_type_ = true;
  }

  void SetChannels(std::string_view value) {
    const auto channels = ParseNumber<std::uint64_t>(value);
    ACUS_REQUIRE(channels && *channels >= 1 && *channels <= 4, Where(), ": ", value,
                 " values per pixel; 1 to 4 are read");
    header_.channels = *channels;
  }

  void SetDataFile(std::string_view value) {
    if (value == "LOCAL") return;
    const fs::path name(value);
    ACUS_REQUIRE(!name.empty() && name == name.filename() && name != ".." && name != "." &&
                     value.find('%') == value.npos && !value.starts_with("LIST"),
                 Where(), ": ElementDataFile is '", value,
                 "'; allowed: LOCAL, or the name of one file beside this one");
    header_.data_path = path_.parent_path() / name;
  }

  bool Flag(std::string_view value) const {
    ACUS_REQUIRE(value == "True" || value == "False" || value == "true" || value == "false",
                 Where(), ": '", value, "'; allowed: True, False");
    return value == "True" || value == "true";
  }

  /// NRRD: the axes that are not "domain" and not "list" hold the values of a pixel.
  void UseNrrdSizes() {
    if (nrrd_kinds_.empty()) nrrd_kinds_.assign(nrrd_sizes_.size(), "domain");
    ACUS_REQUIRE(nrrd_kinds_.size() == nrrd_sizes_.size(), path_.string(), ": has ",
                 nrrd_sizes_.size(), " sizes, but ", nrrd_kinds_.size(), " kinds");
    std::vector<std::string_view> sizes(nrrd_sizes_.begin(), nrrd_sizes_.end());
    if (!nrrd_kinds_.empty() && nrrd_kinds_[0] != "domain" && nrrd_kinds_[0] != "space") {
      ACUS_REQUIRE(nrrd_kinds_[0] != "list", path_.string(),
                   ": the frames are interleaved (kinds: list first), which is not read; save as "
                   ".igs.mha");
      SetChannels(sizes[0]);
      sizes.erase(sizes.begin());
    }
    SetSizes(sizes);
  }

  void CheckSizes() {
    if (is_nrrd_) UseNrrdSizes();
    ACUS_REQUIRE(num_frames_ > 0, path_.string(),
                 ": the header has no DimSize (width height frames)");
    ACUS_REQUIRE(has_type_, path_.string(), ": the header has no type of the pixels");
    auto& frames = header_.frames_;
    ACUS_REQUIRE(frames.size() <= num_frames_, path_.string(), ": has fields of frame ",
                 frames.size() - 1, ", but declares ", num_frames_, " frames only");
    ACUS_REQUIRE(
        frames.size() == num_frames_ || (frames.empty() && num_frames_ <= kMaxUntimedFrames),
        path_.string(), ": declares ", num_frames_, " frames, but the fields of only ",
        frames.size(), " are there; is the file cut off?");
    frames.resize(num_frames_);
    ACUS_REQUIRE(header_.bytes_per_frame() <= kMaxFrameBytes, path_.string(), ": one image has ",
                 header_.bytes_per_frame(), " bytes; at most ", kMaxFrameBytes, " are read");
    if (header_.bytes_per_frame() > 0) CheckData();
  }

  void CheckData() const {
    std::error_code error;
    const auto bytes_of_file = fs::file_size(header_.data_path, error);
    if (error)
      return;  // Poses can be read without the pixels; who requests these gets the message.
    const std::uint64_t available =
        bytes_of_file - std::min<std::uint64_t>(bytes_of_file, header_.data_offset);
    const std::uint64_t most = header_.compressed ? available * kMaxInflation : available;
    const bool fits = compressed_bytes_.value_or(0) <= available &&
                      num_frames_ <= most / header_.bytes_per_frame();
    ACUS_REQUIRE(
        fits, header_.data_path.string(), ": is cut off, or its size is wrong: ", num_frames_,
        " frames of ", header_.width, " x ", header_.height, " x ", header_.channels, " x ",
        BytesOf(header_.pixel_type), " bytes are declared",
        header_.compressed ? Message(" (", compressed_bytes_.value_or(0), " compressed)") : "",
        ", but only ", available, " bytes are there");
  }

  std::string Where() const { return Message(path_.string(), ":", line_number_); }

  const fs::path& path_;
  SequenceHeader& header_;
  std::ifstream file_;
  std::uint64_t file_bytes_ = 0;
  std::size_t line_begin_ = 0;
  std::size_t line_number_ = 0;
  bool is_nrrd_ = false;
  bool has_type_ = false;
  std::uint64_t num_frames_ = 0;
  std::optional<std::uint64_t> compressed_bytes_;
  std::vector<std::string> nrrd_sizes_;
  std::vector<std::string> nrrd_kinds_;
};

SequenceHeader::SequenceHeader(const fs::path& path) {
  RequireInputFile(path);
  SequenceHeaderReader(path, *this).Read();
}

}  // namespace acus::session
