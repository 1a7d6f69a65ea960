// The header of a sequence file: MetaImage (.igs.mha, .igs.mhd) or NRRD (.igs.nrrd, .seq.nrrd).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace acus::session {

enum class PixelType { kNone, kUint8, kInt8, kUint16, kInt16, kUint32, kInt32, kFloat, kDouble };

/// Bytes of one value; 0 for kNone.
std::size_t BytesOf(PixelType type);

/// What a sequence file says about itself, and where its pixels are. Fields are kept in the text of
/// the header, so that a long recording costs little more memory than its file has bytes.
class SequenceHeader {
 public:
  /// @throws InputError at file:line if the header is not one of a sequence, contradicts itself, or
  ///     declares more data than the file can hold.
  explicit SequenceHeader(const std::filesystem::path& path);

  PixelType pixel_type = PixelType::kNone;
  std::size_t width = 0;     ///< 0 for a recording without images.
  std::size_t height = 0;    ///< 0 for a recording without images.
  std::size_t channels = 1;  ///< Values per pixel: 3 for RGB.
  bool compressed = false;   ///< One zlib or gzip stream over all frames.
  bool big_endian = false;
  std::filesystem::path data_path;  ///< The file that holds the pixels.
  std::uint64_t data_offset = 0;    ///< Where they begin in it.

  std::size_t num_frames() const { return frames_.size(); }
  std::size_t bytes_per_frame() const { return width * height * channels * BytesOf(pixel_type); }

  /// A field of one frame, without the prefix "Seq_Frame0000_".
  std::optional<std::string_view> Field(std::size_t frame, std::string_view name) const;
  /// A field of the whole file, such as "UltrasoundImageOrientation" (in NRRD the same with
  /// spaces).
  std::optional<std::string_view> Field(std::string_view name) const;
  /// Names of fields that any frame has, in the order in which they first appear.
  const std::vector<std::string>& frame_field_names() const { return names_; }
  /// All fields of the whole file, in their order.
  const std::vector<std::pair<std::string, std::string>>& fields() const { return fields_; }

 private:
  friend class SequenceHeaderReader;

  struct FieldText {
    std::uint32_t name = 0;    ///< Index into names_.
    std::uint32_t length = 0;  ///< Of the value.
    std::uint64_t offset = 0;  ///< Of the value in text_.
  };

  std::string text_;
  std::vector<std::pair<std::string, std::string>> fields_;
  std::vector<std::vector<FieldText>> frames_;
  std::vector<std::string> names_;
};

/// The numbers of a text such as "1 0 0 -2.5e-005". Nothing if one is not a finite number.
std::optional<std::vector<double>> NumbersOf(std::string_view text);

}  // namespace acus::session
