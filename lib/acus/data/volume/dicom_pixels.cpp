#include "acus/data/volume/dicom_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <gdcmImageReader.h>
#include <gdcmJPEG12Codec.h>
#include <gdcmTrace.h>
#include <sstream>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/data/volume/dicom_elements.h"

namespace acus::volume {
namespace {

constexpr double kLowestHu = -1024.0;
constexpr const char* kDicomJpegExtended = "1.2.840.10008.1.2.4.51";
constexpr double kMaxPlausibleHu = 3072.0;  ///< A padding value above this is not tissue.

/// The bytes of the pixel data element, or of its whole sequence of fragments.
std::string PixelBytes(const DicomHeader& header) {
  if (header.transfer_syntax == kDicomDeflated) {  // The place is that in the inflated file.
    const auto all = ReadDicomBytes(header.file);
    ACUS_REQUIRE(header.pixels_end <= all.size(), header.file.string(),
                 ": has changed while it was read");
    return {all.begin() + static_cast<std::ptrdiff_t>(header.pixels_begin),
            all.begin() + static_cast<std::ptrdiff_t>(header.pixels_end)};
  }
  std::ifstream file(header.file, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(header.pixels_begin));
  std::string bytes(header.pixels_end - header.pixels_begin, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ACUS_REQUIRE(file.gcount() == static_cast<std::streamsize>(bytes.size()), header.file.string(),
               ": its pixels cannot be read");
  return bytes;
}

/// A DICOM file with nothing but what a decoder needs. GDCM stops the whole program at an
/// assertion when it meets a broken element, so it is never given the original file.
class MinimalDicom {
 public:
  MinimalDicom(const DicomHeader& header, const std::string& fragments) {
    const std::string ct_image_storage = "1.2.840.10008.5.1.4.1.1.2";
    bytes_ = std::string(128, '\0') + "DICM";
    Element(2, 1, "OB", std::string("\0\1", 2));
    Element(2, 2, "UI", ct_image_storage);
    Element(2, 3, "UI", "1.2.3");
    Element(2, 0x10, "UI", header.transfer_syntax);
    Element(8, 0x16, "UI", ct_image_storage);
    Element(8, 0x18, "UI", "1.2.3");
    Number(0x02, 1);
    Element(0x28, 4, "CS", "MONOCHROME2");
    if (header.num_frames > 1) Element(0x28, 8, "IS", std::to_string(header.num_frames));
    Number(0x10, header.rows);
    Number(0x11, header.columns);
    Number(0x100, header.bits_allocated);
    Number(0x101, header.bits_stored);
    Number(0x102, header.bits_stored - 1);
    Number(0x103, header.is_signed ? 1 : 0);
    Tag(0x7FE0, 0x10);
    bytes_ += std::string("OB\0\0\xFF\xFF\xFF\xFF", 8) + fragments;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void Word(int value) {
    bytes_ += static_cast<char>(value & 255);
    bytes_ += static_cast<char>(value >> 8 & 255);
  }
  void Tag(int group, int element) {
    Word(group);
    Word(element);
  }
  void Number(int element, int value) {
    Tag(0x28, element);
    bytes_ += "US";
    Word(2);
    Word(value);
  }
  void Element(int group, int element, const std::string& vr, std::string value) {
    if (value.size() % 2 == 1) value += vr == "UI" ? '\0' : ' ';
    Tag(group, element);
    bytes_ += vr;
    if (vr == "OB") Word(0);
    Word(static_cast<int>(value.size()));
    if (vr == "OB") Word(0);
    bytes_ += value;
  }
  std::string bytes_;
};

/// The stored bits of a pixel, which are the lowest, with their sign.
std::int32_t WithoutHighBits(std::int32_t whole, unsigned unused, const DicomHeader& header) {
  if (unused == 0) return whole;
  const auto bits = static_cast<unsigned>(header.bits_stored);
  const auto low =
      static_cast<std::int32_t>(static_cast<std::uint32_t>(whole) & ((1U << bits) - 1U));
  const bool is_negative = header.is_signed && (low >> (bits - 1U) & 1) != 0;
  return is_negative ? low - (1 << bits) : low;
}

/// The frames of encapsulated pixels (PS3.5 A.4): one fragment each, or all of a single frame.
/// Nothing if they do not fit each other.
std::vector<std::string> FrameFragments(const std::string& fragments, int num_frames) {
  const DicomBytes bytes(reinterpret_cast<const std::uint8_t*>(fragments.data()), fragments.size());
  std::vector<std::string> items;
  for (std::size_t at = 0; at + 8 <= bytes.size() && DicomTag(bytes, at) == kDicomItem;) {
    const std::size_t length = DicomU32(bytes, at + 4);
    if (length > bytes.size() - at - 8) return {};
    items.push_back(fragments.substr(at + 8, length));
    at += 8 + length;
  }
  if (items.empty()) return {};
  items.erase(items.begin());  // The table of offsets.
  if (num_frames == 1) {
    std::string all;
    for (const std::string& item : items) all += item;
    return {all};
  }
  return items.size() == static_cast<std::size_t>(num_frames) ? items : std::vector<std::string>();
}

void RequireFrames(const DicomHeader& header, bool fits) {
  ACUS_REQUIRE(fits, header.file.string(),
               ": its compressed pixels do not fit its header; the file is broken");
}

/// What the frame header of lossy JPEG says (ITU T.81, B.2.2); zeros if there is none.
struct JpegFrame {
  int precision = 0;
  int lines = 0;
  int columns = 0;
};

JpegFrame JpegFrameOf(const std::string& stream) {
  const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(stream[at]); };
  const auto word = [&](std::size_t at) { return byte(at) << 8 | byte(at + 1); };
  for (std::size_t at = 2; at + 8 < stream.size() && byte(at) == 0xFF;) {
    if (byte(at + 1) == 0xC0 || byte(at + 1) == 0xC1) {
      return {.precision = byte(at + 4), .lines = word(at + 5), .columns = word(at + 7)};
    }
    at += 2U + static_cast<std::size_t>(word(at + 2));
  }
  return {};
}

/// Extended JPEG of 12 bits. GDCM's reader would try its decoder of 16 bits first, which writes a
/// line to stderr for each image before the one of 12 bits is chosen. Empty if it is not that.
std::string DecodedJpeg12(const DicomHeader& header, const std::string& fragments) {
  if (header.transfer_syntax != kDicomJpegExtended || header.bits_allocated != 16) return {};
  std::string raw;
  for (const std::string& frame : FrameFragments(fragments, header.num_frames)) {
    const JpegFrame stated = JpegFrameOf(frame);
    if (stated.precision != 12) return {};
    RequireFrames(header, stated.columns == header.columns && stated.lines == header.rows);
    const std::array<unsigned, 3> size = {static_cast<unsigned>(header.columns),
                                          static_cast<unsigned>(header.rows), 1};
    gdcm::JPEG12Codec codec;
    codec.SetDimensions(size.data());
    codec.SetPixelFormat(gdcm::PixelFormat(1, 16, static_cast<std::uint16_t>(header.bits_stored),
                                           static_cast<std::uint16_t>(header.bits_stored - 1),
                                           header.is_signed ? 1 : 0));
    std::istringstream in(frame);
    std::ostringstream out;
    ACUS_REQUIRE(codec.DecodeByStreams(in, out), header.file.string(),
                 ": its compressed pixels are broken; copy or export the file again");
    raw += out.str();
  }
  return raw;
}

}  // namespace

std::string DecodedFrames(const DicomHeader& header, const std::string& fragments) {
  const std::string name = header.file.string();
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  const auto count = static_cast<std::size_t>(header.columns) *
                     static_cast<std::size_t>(header.rows) *
                     static_cast<std::size_t>(header.num_frames);
  const std::size_t num_bytes = count * (static_cast<std::size_t>(header.bits_allocated) / 8U);
  RequireMemory(static_cast<double>(num_bytes), static_cast<double>(fragments.size()), name);
  if (std::string raw = DecodedJpeg12(header, fragments); !raw.empty()) {
    RequireFrames(header, raw.size() == num_bytes);
    return raw;
  }
  std::istringstream stream(MinimalDicom(header, fragments).bytes());
  gdcm::ImageReader reader;
  reader.SetStream(stream);
  ACUS_REQUIRE(reader.Read(), name, ": its pixels cannot be decoded (transfer syntax ",
               header.transfer_syntax,
               "); the file is broken or the compression is not known. "
               "Try dcmdjpeg or gdcmconv --raw on the series");
  const gdcm::Image& image = reader.GetImage();
  RequireFrames(header, image.GetDimension(0) == static_cast<unsigned>(header.columns) &&
                            image.GetDimension(1) == static_cast<unsigned>(header.rows) &&
                            image.GetBufferLength() == num_bytes);
  std::string raw(image.GetBufferLength(), '\0');
  ACUS_REQUIRE(image.GetBuffer(raw.data()), name,
               ": its compressed pixels are broken; copy or export the file again");
  return raw;
}

std::vector<std::int16_t> DecodedSlice(const DicomHeader& header) {
  const std::string name = header.file.string();
  const bool wide = header.bits_allocated == 16;
  ACUS_REQUIRE((wide || header.bits_allocated == 8) && header.samples_per_pixel == 1 &&
                   header.bits_stored >= 1 && header.bits_stored <= header.bits_allocated,
               name, ": has ", header.samples_per_pixel, " samples of ", header.bits_allocated,
               " bits (", header.bits_stored, " used) per pixel; one of 8 or 16 is needed");
  const auto count =
      static_cast<std::size_t>(header.columns) * static_cast<std::size_t>(header.rows);
  const std::size_t frame_bytes = count * (wide ? 2 : 1);
  std::string raw = header.decoded_frames
                        ? header.decoded_frames->substr(header.frame * frame_bytes, frame_bytes)
                        : PixelBytes(header);
  if (header.is_encapsulated && !header.decoded_frames) raw = DecodedFrames(header, raw);
  ACUS_REQUIRE(raw.size() >= frame_bytes, name, ": has ", raw.size(), " bytes of pixels for ",
               header.columns, " x ", header.rows, "; it is cut off or broken");
  const double slope = header.rescale_slope;
  const double intercept = header.rescale_intercept;
  ACUS_REQUIRE(slope != 0.0 && std::abs(slope) < 1e4 && std::abs(intercept) < 1e5, name,
               ": its rescale slope ", slope, " or intercept ", intercept, " is not usable");
  const double padding = header.padding_value.value_or(0.0) * slope + intercept;
  const bool has_high_padding = header.padding_value && padding > kMaxPlausibleHu;
  std::vector<std::int16_t> hu(count);
  // Old scanners store pixels in the upper bits.
  const int shift = header.is_encapsulated ? 0 : header.high_bit + 1 - header.bits_stored;
  ACUS_REQUIRE(shift >= 0 && shift <= header.bits_allocated - header.bits_stored, name,
               ": its high bit is ", header.high_bit, " with ", header.bits_stored, " of ",
               header.bits_allocated, " bits stored; the header is broken");
  // Bits above those stored may hold an overlay; padding may use them.
  const unsigned unused = static_cast<unsigned>(header.bits_allocated - header.bits_stored);
  for (std::size_t i = 0; i < count; ++i) {
    const auto low = static_cast<std::uint8_t>(raw[wide ? 2 * i : i]);
    std::int32_t whole = header.is_signed ? static_cast<std::int8_t>(low) : low;
    if (wide) {
      const auto word =
          static_cast<std::uint16_t>(low | static_cast<std::uint8_t>(raw[2 * i + 1]) << 8);
      whole = header.is_signed ? static_cast<std::int16_t>(word) : word;
    }
    const bool is_declared_padding = header.padding_value && whole == *header.padding_value;
    const std::int32_t stored =
        is_declared_padding ? whole : WithoutHighBits(whole >> shift, unused, header);
    const double value = std::round(stored * slope + intercept);
    const bool is_padding = has_high_padding && value >= padding;
    hu[i] =
        static_cast<std::int16_t>(is_padding ? kLowestHu : std::clamp(value, kLowestHu, 32767.0));
  }
  return hu;
}

}  // namespace acus::volume
