// DICOM PS3.5: data element encoding (section 7), sequences (7.5), encapsulated pixels (A.4).
//
// Read here and not by a library, because of broken files: GDCM stops the program at an assertion,
// and DCMTK recurses once for each nested sequence, so that a file of 160 kB ends it by a stack
// overflow (both as of Debian 12; DicomSeries.SequencesNestedTooDeeplyAreRefused).
#include "acus/data/volume/dicom_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/data/volume/dicom_elements.h"
#include "acus/data/volume/dicom_items.h"
#include "acus/data/volume/dicom_pixels.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;
using Bytes = DicomBytes;

/// Walks the elements of one file and keeps the values of the top level.
class Walker {
 public:
  Walker(const fs::path& path, Bytes bytes) : path_(path), bytes_(bytes) {}

  /// Begins at `offset`: the meta header, if there is one, then the data set.
  void Walk(std::size_t offset) {
    at_ = offset;
    explicit_vr_ = true;
    while (at_ + 4 <= bytes_.size() && PeekTag() >> 16U == 2U) Element(0);
    const std::string syntax = values_.Text(kDicomTransferSyntax);
    ACUS_REQUIRE(syntax != "1.2.840.10008.1.2.2", path_.string(),
                 ": big-endian DICOM is not read; convert the series to explicit little endian "
                 "(for example with dcmconv)");
    // Without a meta header the syntax shows in whether a VR in capitals follows the first tag.
    explicit_vr_ = syntax.empty() ? DicomLooksExplicit(bytes_, at_) : syntax != "1.2.840.10008.1.2";
    while (at_ < bytes_.size()) {
      if (bytes_.size() - at_ < 8) return;  // Trailing padding.
      Element(0);
    }
  }

  const DicomValues& values() const { return values_; }
  bool is_encapsulated() const { return is_encapsulated_; }

  /// Where the value of an element begins and ends in the file.
  std::pair<std::size_t, std::size_t> Place(std::uint32_t tag) const {
    const Bytes value = values_.values.at(tag);
    const auto begin = static_cast<std::size_t>(value.data() - bytes_.data());
    return {begin, begin + value.size()};
  }

 private:
  [[noreturn]] void Fail(const char* what) const {
    throw InputError(Message(path_.string(), ": ", what, " at byte ", at_,
                             "; the file is cut off or broken. Copy or export it again"));
  }
  void Need(std::size_t count) const {
    if (count > bytes_.size() - at_) Fail("a DICOM element goes beyond the end of the file");
  }
  std::uint32_t PeekTag() const {
    Need(4);
    return DicomTag(bytes_, at_);
  }

  void Element(int depth) {
    if (depth > kMostDicomDepth) Fail("DICOM sequences are nested too deeply");
    Need(8);
    if (PeekTag() >> 16U == 0xFFFEU) Fail("a DICOM delimiter is out of place");
    const DicomHead head = ReadDicomHead(bytes_, at_, explicit_vr_);
    Need(head.size);
    const auto [tag, type, length, size] = head;
    at_ += size;
    if (length == kDicomOpenLength) {
      const bool outer = explicit_vr_;
      if (type == "UN") explicit_vr_ = false;  // PS3.5 6.2.2, note 4.
      const std::size_t begin = at_;
      tag == kDicomPixels ? Fragments() : Sequence(depth + 1);
      explicit_vr_ = outer;
      if (depth == 0) values_.values[tag] = bytes_.subspan(begin, at_ - begin);
      is_encapsulated_ |= depth == 0 && tag == kDicomPixels;
      return;
    }
    Need(length);
    if (depth == 0) values_.values[tag] = bytes_.subspan(at_, length);
    at_ += length;
  }

  /// The length of the next item; nothing at the end of the sequence.
  std::optional<std::uint32_t> NextItem(const char* if_missing) {
    Need(8);
    const std::uint32_t tag = PeekTag();
    const std::uint32_t length = DicomU32(bytes_, at_ + 4);
    at_ += 8;
    if (tag == kDicomSequenceEnd) return {};
    if (tag != kDicomItem) Fail(if_missing);
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
      if (*length != kDicomOpenLength) {
        Need(*length);
        at_ += *length;
        continue;
      }
      while (PeekTag() != kDicomItemEnd) Element(depth);
      Need(8);
      at_ += 8;
    }
  }

  const fs::path& path_;
  Bytes bytes_;
  std::size_t at_ = 0;
  bool explicit_vr_ = true;
  bool is_encapsulated_ = false;
  DicomValues values_;
};

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

/// Places an image, if all three are there and usable. Spacing: rows first.
void Place(const std::vector<double>& position, const std::vector<double>& axes,
           const std::vector<double>& spacing, DicomHeader& header) {
  if (position.empty() || axes.empty() || spacing.empty()) return;
  header.position_mm = Eigen::Vector3d(position[0], position[1], position[2]);
  header.column_axis = Eigen::Vector3d(axes[0], axes[1], axes[2]);
  header.row_axis = Eigen::Vector3d(axes[3], axes[4], axes[5]);
  header.spacing_mm = Eigen::Array2d(spacing[1], spacing[0]);
  header.is_placed = std::abs(header.column_axis.norm() - 1.0) < 1e-2 &&
                     std::abs(header.row_axis.norm() - 1.0) < 1e-2 &&
                     std::abs(header.column_axis.dot(header.row_axis)) < 1e-2 &&
                     (header.spacing_mm > 1e-3).all() && (header.spacing_mm < 100.0).all();
  header.column_axis.normalize();
  header.row_axis -= header.column_axis * header.column_axis.dot(header.row_axis);
  header.row_axis.normalize();
}

void Rescale(const std::vector<double>& slope, const std::vector<double>& intercept,
             DicomHeader& header) {
  if (!slope.empty()) header.rescale_slope = slope[0];
  if (!intercept.empty()) header.rescale_intercept = intercept[0];
}

/// Nominal Percentage of Cardiac Phase (FL), which scanners also use for breath; empty without.
std::string Percentage(const DicomValues& dicom) {
  float percent = 0.0F;
  const auto found = dicom.values.find(0x00209241U);
  if (found == dicom.values.end() || found->second.size() != sizeof(percent)) return {};
  std::memcpy(&percent, found->second.data(), sizeof(percent));
  return percent >= 0.0F && percent <= 100.0F ? Message(percent) : std::string();
}

DicomHeader HeaderFrom(const Walker& walker, const fs::path& path) {
  const DicomValues& dicom = walker.values();
  DicomHeader header;
  header.file = path;
  header.transfer_syntax = dicom.Text(kDicomTransferSyntax);
  header.series_uid = dicom.Text(0x0020000EU);
  header.frame_uid = dicom.Text(0x00200052U);
  if (const auto time = dicom.Decimals(0x00200100U, 1); !time.empty()) {
    header.temporal_position = static_cast<int>(std::clamp(time[0], 0.0, 1e6));
  }
  header.description = dicom.Text(0x0008103EU);
  header.modality = dicom.Text(0x00080060U);
  header.image_type = dicom.Text(0x00080008U);
  header.instance_uid = dicom.Text(0x00080018U);
  header.acquisition_number = dicom.Text(0x00200012U);
  header.acquisition_time = dicom.Text(0x00080032U);
  if (header.acquisition_time.empty()) header.acquisition_time = dicom.Text(0x0008002AU);
  header.content_time = dicom.Text(0x00080033U);
  header.trigger_time = dicom.Text(0x00181060U);
  header.phase_percentage = Percentage(dicom);
  header.comments = dicom.Text(0x00204000U);
  if (const auto number = dicom.Decimals(0x00200013U, 1); !number.empty()) {
    header.instance_number = number[0];
  }
  if (const auto location = dicom.Decimals(0x00201041U, 1); !location.empty()) {
    header.slice_location_mm = location[0];
  }
  header.rows = dicom.Short(0x00280010U, 0);
  header.columns = dicom.Short(0x00280011U, 0);
  header.bits_allocated = dicom.Short(0x00280100U, 16);
  header.bits_stored = dicom.Short(0x00280101U, header.bits_allocated);
  header.high_bit = dicom.Short(0x00280102U, header.bits_stored - 1);
  header.is_signed = dicom.Short(0x00280103U, 0) == 1;
  header.samples_per_pixel = dicom.Short(0x00280002U, 1);
  const auto frames = dicom.Decimals(0x00280008U, 1);
  header.num_frames = frames.empty() ? 1 : static_cast<int>(std::clamp(frames[0], 0.0, 1e6));
  header.has_pixels = dicom.Has(kDicomPixels) && header.rows > 0 && header.columns > 0;
  Place(dicom.Decimals(0x00200032U, 3), dicom.Decimals(0x00200037U, 6),
        dicom.Decimals(0x00280030U, 2), header);
  Rescale(dicom.Decimals(0x00281053U, 1), dicom.Decimals(0x00281052U, 1), header);
  if (dicom.Has(0x00280120U)) {
    const int raw = dicom.Short(0x00280120U, 0);
    header.padding_value = header.is_signed ? static_cast<std::int16_t>(raw) : raw;
  }
  if (header.has_pixels) {
    header.is_encapsulated = walker.is_encapsulated();
    std::tie(header.pixels_begin, header.pixels_end) = walker.Place(kDicomPixels);
    ACUS_REQUIRE(header.rows <= 8192 && header.columns <= 8192, path.string(), ": ", header.columns,
                 " x ", header.rows, " pixels are not possible in a CT; the file is broken");
  }
  return header;
}

}  // namespace

std::optional<DicomHeader> ReadDicomHeader(const fs::path& file) {
  const Kind kind = KindOf(file);
  if (kind == Kind::kNotDicom) return std::nullopt;
  const auto bytes = ReadDicomBytes(file);
  Walker walker(file, bytes);
  try {
    walker.Walk(kind == Kind::kMarked ? 132 : 0);
  } catch (const InputError&) {
    if (kind == Kind::kMaybeBare) return std::nullopt;
    throw;
  }
  return HeaderFrom(walker, file);
}

std::vector<DicomHeader> FramesOf(const DicomHeader& object) {
  const DicomDataSet data = ReadDicomDataSet(object.file);
  const DicomItem& root = data.root;
  const auto items = root.sequences.find(0x52009230U);
  const auto count = static_cast<std::size_t>(object.num_frames);
  if (items == root.sequences.end() || items->second.size() != count) return {object};
  const DicomItem* shared = root.First(0x52009229U);
  std::vector<DicomHeader> frames(count, object);
  std::shared_ptr<const std::string> decoded;
  if (object.is_encapsulated) {
    const DicomBytes pixels = root.values.at(kDicomPixels);
    decoded = std::make_shared<const std::string>(
        DecodedFrames(object, std::string(pixels.begin(), pixels.end())));
  }
  for (std::size_t n = 0; n < count; ++n) {
    DicomHeader& frame = frames[n];
    const DicomItem& own = items->second[n];
    const auto attribute = [&](std::uint32_t group, std::uint32_t tag, std::size_t size) {
      const DicomItem* found = own.First(group);
      if (found == nullptr && shared != nullptr) found = shared->First(group);
      return found == nullptr ? std::vector<double>() : found->Decimals(tag, size);
    };
    Place(attribute(0x00209113U, 0x00200032U, 3), attribute(0x00209116U, 0x00200037U, 6),
          attribute(0x00289110U, 0x00280030U, 2), frame);
    Rescale(attribute(0x00289145U, 0x00281053U, 1), attribute(0x00289145U, 0x00281052U, 1), frame);
    if (const DicomItem* content = own.First(0x00209111U)) {
      frame.temporal_position = content->Long(0x00209128U, frame.temporal_position);
      const int acquisition = content->Short(0x00209156U, 0);
      if (acquisition > 0) frame.acquisition_number = std::to_string(acquisition);
      frame.comments = content->Text(0x00209158U);
    }
    frame.num_frames = 1;
    frame.frame = n;
    frame.instance_number = static_cast<double>(n + 1);
    frame.instance_uid.clear();  // All have that of the object.
    frame.decoded_frames = decoded;
    if (decoded) continue;
    const std::size_t bytes = static_cast<std::size_t>(object.rows) *
                              static_cast<std::size_t>(object.columns) *
                              static_cast<std::size_t>(object.bits_allocated / 8);
    frame.pixels_begin = std::min(object.pixels_begin + n * bytes, object.pixels_end);
    frame.pixels_end = std::min(frame.pixels_begin + bytes, object.pixels_end);
  }
  return frames;
}

}  // namespace acus::volume
