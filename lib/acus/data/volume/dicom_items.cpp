// DICOM PS3.5: data element encoding (section 7), sequences (7.5). Read here and not by a library
// for the reasons in dicom_header.cpp.
#include "acus/data/volume/dicom_items.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/words.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kNoLength = 0xFFFFFFFFU;
constexpr std::uint32_t kItemTag = 0xFFFEE000U;
constexpr std::uint32_t kItemEndTag = 0xFFFEE00DU;
constexpr std::uint32_t kSequenceEndTag = 0xFFFEE0DDU;
constexpr std::uint32_t kPixelsTag = 0x7FE00010U;
constexpr std::uint32_t kSyntaxTag = 0x00020010U;
constexpr int kMaxItemDepth = 32;
constexpr std::uintmax_t kMaxDataSetBytes = std::uintmax_t{4} << 30U;

/// Sequences that a file with implicit types does not mark as such.
constexpr std::array<std::uint32_t, 12> kSequenceTags = {
    0x00082218U, 0x00082220U, 0x00209113U, 0x00209116U, 0x00289110U, 0x00620002U,
    0x00620003U, 0x0062000AU, 0x0062000FU, 0x00620011U, 0x52009229U, 0x52009230U};

class ItemParser {
 public:
  ItemParser(const fs::path& path, DicomItem::Bytes bytes) : path_(path), bytes_(bytes) {}

  DicomItem Parse() {
    DicomItem root;
    at_ = bytes_.size() >= 132 && std::equal(bytes_.begin() + 128, bytes_.begin() + 132, "DICM")
              ? 132
              : 0;
    explicit_type_ = true;
    while (at_ + 8 <= bytes_.size() && U16(at_) == 2) Element(root, bytes_.size(), 0);
    const std::string syntax = root.Text(kSyntaxTag);
    explicit_type_ = syntax.empty() ? LooksExplicit() : syntax != "1.2.840.10008.1.2";
    while (at_ + 8 <= bytes_.size()) Element(root, bytes_.size(), 0);
    return root;
  }

 private:
  [[noreturn]] void Fail(const char* what) const {
    throw InputError(Message(path_.string(), ": ", what, " at byte ", at_,
                             "; the file is cut off or broken. Copy or export it again"));
  }
  void Need(std::size_t count, std::size_t end) const {
    if (at_ > end || count > end - at_) Fail("a DICOM element goes beyond the end of its item");
  }
  std::uint32_t U16(std::size_t at) const {
    return bytes_[at] | static_cast<std::uint32_t>(bytes_[at + 1]) << 8U;
  }
  std::uint32_t U32(std::size_t at) const { return U16(at) | U16(at + 2) << 16U; }
  std::uint32_t Tag() const { return U16(at_) << 16U | U16(at_ + 2); }
  bool LooksExplicit() const {
    const auto capital = [&](std::size_t at) { return bytes_[at] >= 'A' && bytes_[at] <= 'Z'; };
    return at_ + 8 <= bytes_.size() && capital(at_ + 4) && capital(at_ + 5);
  }

  /// Reads tag, type and length; `is_sequence` by the type, the tag or an open length.
  std::uint32_t Head(std::size_t end, bool& is_sequence, bool& is_unknown) {
    Need(8, end);
    const std::uint32_t tag = Tag();
    std::string type;
    std::uint32_t length = 0;
    if (explicit_type_ && LooksExplicit()) {
      static constexpr std::string_view kLong = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
      type = {static_cast<char>(bytes_[at_ + 4]), static_cast<char>(bytes_[at_ + 5])};
      if (kLong.find(type) != kLong.npos) {
        Need(12, end);
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
    is_unknown = type == "UN";
    const bool may_be = type.empty() || is_unknown;
    is_sequence = type == "SQ" || length == kNoLength ||
                  (may_be && std::ranges::find(kSequenceTags, tag) != kSequenceTags.end());
    return length;
  }

  void Element(DicomItem& item, std::size_t end, int depth) {
    if (depth > kMaxItemDepth) Fail("DICOM sequences are nested too deeply");
    Need(8, end);
    const std::uint32_t tag = Tag();
    bool is_sequence = false;
    bool is_unknown = false;
    const std::uint32_t length = Head(end, is_sequence, is_unknown);
    if (length != kNoLength) Need(length, end);
    ACUS_REQUIRE(tag != kPixelsTag || length != kNoLength, path_.string(),
                 ": its pixels are compressed, which is not read in segmentations; export it "
                 "uncompressed (for example with gdcmconv --raw)");
    if (!is_sequence) {
      item.values[tag] = bytes_.subspan(at_, length);
      at_ += length;
      return;
    }
    const bool outer = explicit_type_;
    if (is_unknown) explicit_type_ = false;  // PS3.5 6.2.2, note 4.
    item.sequences[tag] =
        Items(length == kNoLength ? end : at_ + length, length == kNoLength, depth + 1);
    explicit_type_ = outer;
  }

  std::vector<DicomItem> Items(std::size_t end, bool is_open, int depth) {
    std::vector<DicomItem> items;
    while (is_open || at_ < end) {
      Need(8, end);
      const std::uint32_t tag = Tag();
      const std::uint32_t length = U32(at_ + 4);
      at_ += 8;
      if (is_open && tag == kSequenceEndTag) break;
      if (tag != kItemTag) Fail("a DICOM sequence item is missing");
      if (length != kNoLength) Need(length, end);
      items.push_back(Item(length == kNoLength ? end : at_ + length, length == kNoLength, depth));
    }
    return items;
  }

  DicomItem Item(std::size_t end, bool is_open, int depth) {
    DicomItem item;
    while (is_open || at_ < end) {
      Need(8, end);
      if (Tag() == kItemEndTag) {
        at_ += 8;
        break;
      }
      Element(item, end, depth);
    }
    return item;
  }

  const fs::path& path_;
  DicomItem::Bytes bytes_;
  std::size_t at_ = 0;
  bool explicit_type_ = true;
};

}  // namespace

std::string DicomItem::Text(std::uint32_t tag) const {
  const auto found = values.find(tag);
  if (found == values.end()) return "";
  std::string text(found->second.begin(), found->second.end());
  text.resize(std::min(text.find('\0'), text.size()));
  return std::string(Trimmed(text));
}

int DicomItem::Short(std::uint32_t tag, int missing) const {
  const auto found = values.find(tag);
  if (found == values.end() || found->second.size() < 2) return missing;
  return found->second[0] | found->second[1] << 8;
}

std::vector<double> DicomItem::Decimals(std::uint32_t tag, std::size_t count) const {
  std::vector<double> numbers;
  const std::string text = Text(tag);
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t cut = std::min(rest.find('\\'), rest.size());
    std::string_view word = Trimmed(rest.substr(0, cut));
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      return {};
    numbers.push_back(value);
    rest.remove_prefix(std::min(cut + 1, rest.size()));
  }
  return numbers.size() == count ? numbers : std::vector<double>();
}

const DicomItem* DicomItem::First(std::uint32_t sequence) const {
  const auto found = sequences.find(sequence);
  return found == sequences.end() || found->second.empty() ? nullptr : &found->second.front();
}

DicomDataSet ReadDicomDataSet(const fs::path& path) {
  DicomDataSet data;
  data.bytes.resize(RequireInputFile(path, kMaxDataSetBytes));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(data.bytes.data()),
            static_cast<std::streamsize>(data.bytes.size()));
  ACUS_REQUIRE(file.gcount() == static_cast<std::streamsize>(data.bytes.size()), path.string(),
               ": cannot be read; is it readable for you?");
  data.root = ItemParser(path, data.bytes).Parse();
  return data;
}

}  // namespace acus::volume
