// DICOM PS3.5: data element encoding (section 7), sequences (7.5), encapsulated pixels (A.4).
//
// Read here and not by a library, because of broken files: GDCM stops the program at an assertion,
// and DCMTK recurses once for each nested sequence, so that a file of 160 kB ends it by a stack
// overflow (both as of Debian 12; DicomSeries.SequencesNestedTooDeeplyAreRefused).
#include "acus/data/volume/dicom_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/words.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;
using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kUndefinedLength = 0xFFFFFFFFU;
constexpr std::uint32_t kItem = 0xFFFEE000U;
constexpr std::uint32_t kItemEnd = 0xFFFEE00DU;
constexpr std::uint32_t kSequenceEnd = 0xFFFEE0DDU;
constexpr std::uint32_t kPixelData = 0x7FE00010U;
constexpr std::uint32_t kTransferSyntax = 0x00020010U;
constexpr int kMaxDepth = 32;
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{4} << 30U;

/// Walks the elements of one file and keeps the values of the top level.
class Walker {
 public:
  Walker(const fs::path& path, Bytes bytes) : path_(path), bytes_(bytes) {}

  /// Begins at `offset`: the meta header, if there is one, then the data set.
  void Walk(std::size_t offset) {
    at_ = offset;
    explicit_vr_ = true;
    while (at_ + 4 <= bytes_.size() && PeekTag() >> 16U == 2U) Element(0);
    const std::string syntax = Text(kTransferSyntax);
    ACUS_REQUIRE(syntax != "1.2.840.10008.1.2.2" && syntax != "1.2.840.10008.1.2.1.99",
                 path_.string(),
                 ": big-endian and deflated DICOM are not read; convert the "
                 "series to explicit little endian (for example with dcmconv)");
    // Without a meta header the syntax shows in whether a VR in capitals follows the first tag.
    explicit_vr_ = syntax.empty() ? LooksExplicit() : syntax != "1.2.840.10008.1.2";
    while (at_ < bytes_.size()) {
      if (bytes_.size() - at_ < 8) return;  // Trailing padding.
      Element(0);
    }
  }

  bool Has(std::uint32_t tag) const { return values_.contains(tag); }
  bool is_encapsulated() const { return is_encapsulated_; }

  /// Where the value of an element begins and ends in the file.
  std::pair<std::size_t, std::size_t> Place(std::uint32_t tag) const {
    const Bytes value = values_.at(tag);
    const auto begin = static_cast<std::size_t>(value.data() - bytes_.data());
    return {begin, begin + value.size()};
  }

  std::string Text(std::uint32_t tag) const {
    const auto found = values_.find(tag);
    if (found == values_.end()) return "";
    std::string text(found->second.begin(), found->second.end());
    while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
    return text.substr(std::min(text.find_first_not_of(' '), text.size()));
  }

  /// An unsigned 16-bit value, or `missing`.
  int Short(std::uint32_t tag, int missing) const {
    const auto found = values_.find(tag);
    if (found == values_.end() || found->second.size() < 2) return missing;
    return found->second[0] | found->second[1] << 8;
  }

  /// A decimal string of `count` numbers; empty if it is missing or not that.
  std::vector<double> Decimals(std::uint32_t tag, std::size_t count) const {
    std::vector<double> numbers;
    const std::string text = Text(tag) + "\\";
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = text.find('\\', begin);
      begin = std::min(text.find_first_not_of(" +", begin), end);
      double value = 0.0;
      const auto [stop, error] = std::from_chars(text.data() + begin, text.data() + end, value);
      const bool whole = error == std::errc() && Trimmed({stop, text.data() + end}).empty();
      if (!whole || !std::isfinite(value)) return {};
      numbers.push_back(value);
      begin = end + 1;
    }
    return numbers.size() == count ? numbers : std::vector<double>();
  }

 private:
  [[noreturn]] void Fail(const char* what) const {
    throw InputError(Message(path_.string(), ": ", what, " at byte ", at_,
                             "; the file is cut off or broken. Copy or export it again"));
  }
  void Need(std::size_t count) const {
    if (count > bytes_.size() - at_) Fail("a DICOM element goes beyond the end of the file");
  }
  std::uint32_t U16(std::size_t at) const {
    return bytes_[at] | static_cast<std::uint32_t>(bytes_[at + 1]) << 8U;
  }
  std::uint32_t U32(std::size_t at) const { return U16(at) | U16(at + 2) << 16U; }
  std::uint32_t PeekTag() const {
    Need(4);
    return U16(at_) << 16U | U16(at_ + 2);
  }
  bool LooksExplicit() const {
    if (at_ + 6 > bytes_.size()) return false;
    const auto capital = [&](std::size_t at) { return bytes_[at] >= 'A' && bytes_[at] <= 'Z'; };
    return capital(at_ + 4) && capital(at_ + 5);
  }
  static bool HasLongLength(const std::string& vr) {
    static constexpr const char* kLong[] = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                            "SV", "UC", "UN", "UR", "UT", "UV"};
    for (const char* name : kLong) {
      if (vr == name) return true;
    }
    return false;
  }

  void Element(int depth) {
    if (depth > kMaxDepth) Fail("DICOM sequences are nested too deeply");
    Need(8);
    const std::uint32_t tag = PeekTag();
    std::uint32_t length = 0;
    bool is_unknown_vr = false;
    if (tag >> 16U == 0xFFFEU) Fail("a DICOM delimiter is out of place");
    if (explicit_vr_ && LooksExplicit()) {
      const std::string vr{static_cast<char>(bytes_[at_ + 4]), static_cast<char>(bytes_[at_ + 5])};
      is_unknown_vr = vr == "UN";
      if (HasLongLength(vr)) {
        Need(12);
        length = U32(at_ + 8);
        at_ += 12;
      } else {
        length = U16(at_ + 6);
        at_ += 8;
      }
    } else {
      length = U32(at_ + 4);
      at_ += 8;
    }
    if (length == kUndefinedLength) {
      const bool outer = explicit_vr_;
      if (is_unknown_vr) explicit_vr_ = false;  // PS3.5 6.2.2, note 4.
      const std::size_t begin = at_;
      tag == kPixelData ? Fragments() : Sequence(depth + 1);
      explicit_vr_ = outer;
      if (depth == 0) values_[tag] = bytes_.subspan(begin, at_ - begin);
      is_encapsulated_ |= depth == 0 && tag == kPixelData;
      return;
    }
    Need(length);
    if (depth == 0) values_[tag] = bytes_.subspan(at_, length);
    at_ += length;
  }

  /// The length of the next item; nothing at the end of the sequence.
  std::optional<std::uint32_t> NextItem(const char* if_missing) {
    Need(8);
    const std::uint32_t tag = PeekTag();
    const std::uint32_t length = U32(at_ + 4);
    at_ += 8;
    if (tag == kSequenceEnd) return {};
    if (tag != kItem) Fail(if_missing);
    return length;
  }

  void Fragments() {
    for (;;) {
      const auto length = NextItem("an encapsulated pixel item is missing");
      if (!length) return;
      Need(*length);
      at_ += *length;
    }
  }

  void Sequence(int depth) {
    for (;;) {
      const auto length = NextItem("a DICOM sequence item is missing");
      if (!length) return;
      if (*length != kUndefinedLength) {
        Need(*length);
        at_ += *length;
        continue;
      }
      while (PeekTag() != kItemEnd) Element(depth);
      Need(8);
      at_ += 8;
    }
  }

  const fs::path& path_;
  Bytes bytes_;
  std::size_t at_ = 0;
  bool explicit_vr_ = true;
  bool is_encapsulated_ = false;
  std::map<std::uint32_t, Bytes> values_;
};

std::vector<std::uint8_t> AllBytes(const fs::path& path) {
  const auto size = RequireInputFile(path, kMaxFileBytes);
  std::vector<std::uint8_t> bytes(size);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  ACUS_REQUIRE(file.gcount() == static_cast<std::streamsize>(size), path.string(),
               ": cannot be read; is it readable for you?");
  return bytes;
}

/// Whether the file begins with DICOM's mark, found without reading the rest.
enum class Kind { kNotDicom, kMarked, kMaybeBare };

Kind KindOf(const fs::path& path) {
  RequireInputFile(path);
  std::array<std::uint8_t, 132> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(head.data()), head.size());
  if (file.gcount() == 132 && head[128] == 'D' && head[129] == 'I' && head[130] == 'C' &&
      head[131] == 'M') {
    return Kind::kMarked;
  }
  // Old files have no preamble: they begin at group 2 or 8, element below 0x20.
  const bool bare = file.gcount() >= 16 && (head[0] == 2 || head[0] == 8) && head[1] == 0 &&
                    head[2] < 0x20 && head[3] == 0;
  return bare ? Kind::kMaybeBare : Kind::kNotDicom;
}

DicomHeader HeaderFrom(const Walker& dicom, const fs::path& path) {
  DicomHeader header;
  header.file = path;
  header.transfer_syntax = dicom.Text(kTransferSyntax);
  header.series_uid = dicom.Text(0x0020000EU);
  if (const auto time = dicom.Decimals(0x00200100U, 1); !time.empty()) {
    header.temporal_position = static_cast<int>(std::clamp(time[0], 0.0, 1e6));
  }
  header.description = dicom.Text(0x0008103EU);
  header.modality = dicom.Text(0x00080060U);
  header.image_type = dicom.Text(0x00080008U);
  header.rows = dicom.Short(0x00280010U, 0);
  header.columns = dicom.Short(0x00280011U, 0);
  header.bits_allocated = dicom.Short(0x00280100U, 16);
  header.bits_stored = dicom.Short(0x00280101U, header.bits_allocated);
  header.is_signed = dicom.Short(0x00280103U, 0) == 1;
  header.samples_per_pixel = dicom.Short(0x00280002U, 1);
  const auto frames = dicom.Decimals(0x00280008U, 1);
  header.num_frames = frames.empty() ? 1 : static_cast<int>(std::clamp(frames[0], 0.0, 1e6));
  header.has_pixels = dicom.Has(kPixelData) && header.rows > 0 && header.columns > 0;
  const auto position = dicom.Decimals(0x00200032U, 3);
  const auto axes = dicom.Decimals(0x00200037U, 6);
  const auto spacing = dicom.Decimals(0x00280030U, 2);
  if (!position.empty() && !axes.empty() && !spacing.empty()) {
    header.position_mm = Eigen::Vector3d(position[0], position[1], position[2]);
    header.column_axis = Eigen::Vector3d(axes[0], axes[1], axes[2]);
    header.row_axis = Eigen::Vector3d(axes[3], axes[4], axes[5]);
    header.spacing_mm = Eigen::Array2d(spacing[1], spacing[0]);  // The file gives rows first.
    header.is_placed = std::abs(header.column_axis.norm() - 1.0) < 1e-2 &&
                       std::abs(header.row_axis.norm() - 1.0) < 1e-2 &&
                       std::abs(header.column_axis.dot(header.row_axis)) < 1e-2 &&
                       (header.spacing_mm > 1e-3).all() && (header.spacing_mm < 100.0).all();
    header.column_axis.normalize();
    header.row_axis -= header.column_axis * header.column_axis.dot(header.row_axis);
    header.row_axis.normalize();
  }
  const auto slope = dicom.Decimals(0x00281053U, 1);
  const auto intercept = dicom.Decimals(0x00281052U, 1);
  if (!slope.empty()) header.rescale_slope = slope[0];
  if (!intercept.empty()) header.rescale_intercept = intercept[0];
  if (dicom.Has(0x00280120U)) {
    const int raw = dicom.Short(0x00280120U, 0);
    header.padding_value = header.is_signed ? static_cast<std::int16_t>(raw) : raw;
  }
  if (header.has_pixels) {
    header.is_encapsulated = dicom.is_encapsulated();
    std::tie(header.pixels_begin, header.pixels_end) = dicom.Place(kPixelData);
    ACUS_REQUIRE(header.rows <= 8192 && header.columns <= 8192, path.string(), ": ", header.columns,
                 " x ", header.rows, " pixels are not possible in a CT; the file is broken");
  }
  return header;
}

}  // namespace

std::optional<DicomHeader> ReadDicomHeader(const fs::path& file) {
  const Kind kind = KindOf(file);
  if (kind == Kind::kNotDicom) return std::nullopt;
  const auto bytes = AllBytes(file);
  Walker walker(file, bytes);
  try {
    walker.Walk(kind == Kind::kMarked ? 132 : 0);
  } catch (const InputError&) {
    if (kind == Kind::kMaybeBare) return std::nullopt;
    throw;
  }
  return HeaderFrom(walker, file);
}

}  // namespace acus::volume
