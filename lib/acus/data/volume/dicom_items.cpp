// DICOM PS3.5: data element encoding (section 7), sequences (7.5). Read here and not by a library
// for the reasons in dicom_header.cpp.
#include "acus/data/volume/dicom_items.h"

#include <algorithm>
#include <array>

#include "acus/base/core/error.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

/// Sequences that a file with implicit types does not mark as such.
constexpr std::array<std::uint32_t, 19> kSequenceTags = {
    0x00082218U, 0x00082220U, 0x00209111U, 0x00289145U, 0x00209113U, 0x00209116U, 0x00289110U,
    0x00620002U, 0x00620003U, 0x0062000AU, 0x0062000FU, 0x00620011U, 0x30060020U, 0x30060039U,
    0x30060040U, 0x30060080U, 0x30060086U, 0x52009229U, 0x52009230U};

class ItemParser {
 public:
  ItemParser(const fs::path& path, DicomBytes bytes) : path_(path), bytes_(bytes) {}

  DicomItem Parse() {
    DicomItem root;
    at_ = bytes_.size() >= 132 && std::equal(bytes_.begin() + 128, bytes_.begin() + 132, "DICM")
              ? 132
              : 0;
    while (at_ + 8 <= bytes_.size() && DicomU16(bytes_, at_) == 2) Element(root, bytes_.size(), 0);
    const std::string syntax = root.Text(kDicomTransferSyntax);
    explicit_type_ =
        syntax.empty() ? DicomLooksExplicit(bytes_, at_) : syntax != "1.2.840.10008.1.2";
    while (at_ + 8 <= bytes_.size()) Element(root, bytes_.size(), 0);
    return root;
  }

  bool is_encapsulated() const { return is_encapsulated_; }

 private:
  [[noreturn]] void Fail(const char* what) const {
    throw InputError(Message(path_.string(), ": ", what, " at byte ", at_,
                             "; the file is cut off or broken. Copy or export it again"));
  }
  void Need(std::size_t count, std::size_t end) const {
    if (at_ > end || count > end - at_) Fail("a DICOM element goes beyond the end of its item");
  }
  std::uint32_t Tag() const { return DicomTag(bytes_, at_); }

  static bool IsSequence(const DicomHead& head) {
    const bool may_be = head.type.empty() || head.type == "UN";
    return head.type == "SQ" || head.length == kDicomOpenLength ||
           (may_be && std::ranges::find(kSequenceTags, head.tag) != kSequenceTags.end());
  }

  void Element(DicomItem& item, std::size_t end, int depth) {
    if (depth > kMostDicomDepth) Fail("DICOM sequences are nested too deeply");
    Need(8, end);
    const DicomHead head = ReadDicomHead(bytes_, at_, explicit_type_);
    Need(head.size, end);
    const auto [tag, type, length, size] = head;
    at_ += size;
    if (length != kDicomOpenLength) Need(length, end);
    if (tag == kDicomPixels && length == kDicomOpenLength) {
      const std::size_t begin = at_;
      SkipFragments(end);
      item.values[tag] = bytes_.subspan(begin, at_ - begin);
      is_encapsulated_ = true;
      return;
    }
    if (!IsSequence(head)) {
      item.values[tag] = bytes_.subspan(at_, length);
      at_ += length;
      return;
    }
    const bool outer = explicit_type_;
    if (type == "UN") explicit_type_ = false;  // PS3.5 6.2.2, note 4.
    item.sequences[tag] = Items(length == kDicomOpenLength ? end : at_ + length,
                                length == kDicomOpenLength, depth + 1);
    explicit_type_ = outer;
  }

  void SkipFragments(std::size_t end) {
    for (;;) {
      Need(8, end);
      const std::uint32_t tag = Tag();
      const std::uint32_t length = DicomU32(bytes_, at_ + 4);
      at_ += 8;
      if (tag == kDicomSequenceEnd) return;
      if (tag != kDicomItem) Fail("an encapsulated pixel item is missing");
      Need(length, end);
      at_ += length;
    }
  }

  std::vector<DicomItem> Items(std::size_t end, bool is_open, int depth) {
    std::vector<DicomItem> items;
    while (is_open || at_ < end) {
      Need(8, end);
      const std::uint32_t tag = Tag();
      const std::uint32_t length = DicomU32(bytes_, at_ + 4);
      at_ += 8;
      if (is_open && tag == kDicomSequenceEnd) break;
      if (tag != kDicomItem) Fail("a DICOM sequence item is missing");
      if (length != kDicomOpenLength) Need(length, end);
      items.push_back(
          Item(length == kDicomOpenLength ? end : at_ + length, length == kDicomOpenLength, depth));
    }
    return items;
  }

  DicomItem Item(std::size_t end, bool is_open, int depth) {
    DicomItem item;
    while (is_open || at_ < end) {
      Need(8, end);
      if (Tag() == kDicomItemEnd) {
        at_ += 8;
        break;
      }
      Element(item, end, depth);
    }
    return item;
  }

  const fs::path& path_;
  DicomBytes bytes_;
  std::size_t at_ = 0;
  bool is_encapsulated_ = false;
  bool explicit_type_ = true;  ///< The first group is, whatever the others are.
};

}  // namespace

const DicomItem* DicomItem::First(std::uint32_t sequence) const {
  const auto found = sequences.find(sequence);
  return found == sequences.end() || found->second.empty() ? nullptr : &found->second.front();
}

DicomDataSet ReadDicomDataSet(const fs::path& path) {
  DicomDataSet data;
  data.bytes = ReadDicomBytes(path);
  ItemParser parser(path, data.bytes);
  data.root = parser.Parse();
  data.is_encapsulated = parser.is_encapsulated();
  return data;
}

}  // namespace acus::volume
