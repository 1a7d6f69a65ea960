#include "acus/data/volume/dicom_segmentation.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/data/volume/dicom_header.h"
#include "acus/data/volume/dicom_items.h"
#include "acus/data/volume/dicom_pixels.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/terminology.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kShared = 0x52009229U;    // Functional groups of all frames.
constexpr std::uint32_t kPerFrame = 0x52009230U;  // And of each.
constexpr std::uint32_t kSegmentPixels = 0x7FE00010U;
constexpr double kSamePlaneMm = 0.01;
constexpr double kMostOffStep = 0.05;  // Of the step between planes.

/// One frame: where its first pixel is, and of which segment it is (0: its values say).
struct SegmentFrame {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  int segment = 0;
  int plane = 0;
};

/// A group of functional attributes of one frame, or else of all.
const DicomItem* GroupOf(const DicomItem& root, const DicomItem* frame, std::uint32_t group) {
  if (frame != nullptr) {
    if (const DicomItem* own = frame->First(group)) return own;
  }
  const DicomItem* shared = root.First(kShared);
  return shared == nullptr ? nullptr : shared->First(group);
}

std::vector<double> Attribute(const DicomItem& root, const DicomItem* frame, std::uint32_t group,
                              std::uint32_t tag, std::size_t count) {
  const DicomItem* found = GroupOf(root, frame, group);
  return found == nullptr ? std::vector<double>() : found->Decimals(tag, count);
}

std::string SnomedValue(const DicomItem* code) {
  if (code == nullptr) return "";
  const std::string scheme = code->Text(0x00080102U);
  const bool is_snomed = scheme == "SCT" || scheme == "SRT" || scheme == "99SDM";
  return is_snomed ? code->Text(0x00080100U) : "";
}

ValueNames SegmentNames(const DicomItem& root) {
  ValueNames names;
  const auto found = root.sequences.find(0x00620002U);
  if (found == root.sequences.end()) return names;
  for (const DicomItem& segment : found->second) {
    ValueName name;
    name.text = segment.Text(0x00620005U);
    const DicomItem* type = segment.First(0x0062000FU);
    const DicomItem* region = segment.First(0x00082218U);
    for (const DicomItem* code : {type, region}) {
      if (std::string value = SnomedValue(code); !value.empty()) name.codes.push_back(value);
      if (code == nullptr) continue;
      for (const std::uint32_t modifier : {0x00620011U, 0x00082220U}) {
        const std::string side = SideOfCode(SnomedValue(code->First(modifier)));
        if (!side.empty()) name.side = side;
      }
    }
    const int number = segment.Short(0x00620004U, 0);
    if (number > 0) names[number] = std::move(name);
  }
  return names;
}

std::vector<SegmentFrame> FramesOf(const DicomItem& root, int count, bool is_label_map,
                                   const fs::path& path) {
  const auto found = root.sequences.find(kPerFrame);
  const std::size_t described = found == root.sequences.end() ? 0 : found->second.size();
  ACUS_REQUIRE(count > 0 && described == static_cast<std::size_t>(count), path.string(), ": has ",
               count, " frames, but describes ", described,
               "; the segmentation is broken, export it again");
  std::vector<SegmentFrame> frames;
  for (const DicomItem& item : found->second) {
    const auto position = Attribute(root, &item, 0x00209113U, 0x00200032U, 3);
    ACUS_REQUIRE(!position.empty(), path.string(), ": frame ", frames.size() + 1,
                 " has no position (0020,0032); export the segmentation again");
    SegmentFrame frame;
    frame.position_mm = Eigen::Vector3d(position[0], position[1], position[2]);
    const DicomItem* segment = GroupOf(root, &item, 0x0062000AU);
    if (segment != nullptr) frame.segment = segment->Short(0x0062000BU, 0);
    ACUS_REQUIRE(is_label_map || frame.segment > 0, path.string(), ": frame ", frames.size() + 1,
                 " does not say of which segment it is (0062,000B); export the segmentation again");
    frames.push_back(frame);
  }
  return frames;
}

/// The step between planes along their normal: the least between two frames, or for a single plane
/// what the file says.
double StepMm(const std::vector<double>& along, const DicomItem& root, const fs::path& path) {
  std::vector<double> sorted = along;
  std::ranges::sort(sorted);
  double step = 0.0;
  for (std::size_t n = 1; n < sorted.size(); ++n) {
    const double gap = sorted[n] - sorted[n - 1];
    if (gap > kSamePlaneMm && (step == 0.0 || gap < step)) step = gap;
  }
  if (step > 0.0) return step;
  for (const std::uint32_t tag : {0x00180088U, 0x00180050U}) {
    const auto stated = Attribute(root, nullptr, 0x00289110U, tag, 1);
    if (!stated.empty() && stated[0] > kSamePlaneMm) return stated[0];
  }
  throw InputError(Message(path.string(), ": has one plane, and no thickness of it (0018,0050)"));
}

/// The grid of all frames; sets their planes.
Geometry GridOf(const DicomItem& root, std::vector<SegmentFrame>& frames, const fs::path& path) {
  const auto& items = root.sequences.at(kPerFrame);
  const auto axes = Attribute(root, &items.front(), 0x00209116U, 0x00200037U, 6);
  const auto spacing = Attribute(root, &items.front(), 0x00289110U, 0x00280030U, 2);
  ACUS_REQUIRE(!axes.empty() && !spacing.empty(), path.string(),
               ": has no orientation (0020,0037) or pixel spacing (0028,0030); export it again");
  Geometry geometry;
  geometry.direction.col(0) = Eigen::Vector3d(axes[0], axes[1], axes[2]).normalized();
  geometry.direction.col(1) = Eigen::Vector3d(axes[3], axes[4], axes[5]).normalized();
  geometry.direction.col(2) = geometry.direction.col(0).cross(geometry.direction.col(1));
  const Eigen::Vector3d normal = geometry.direction.col(2);
  std::vector<double> along;
  for (const SegmentFrame& frame : frames) along.push_back(normal.dot(frame.position_mm));
  const double step = StepMm(along, root, path);
  const auto lowest = static_cast<std::size_t>(std::ranges::min_element(along) - along.begin());
  geometry.origin_mm = frames[lowest].position_mm;
  const double planes = (std::ranges::max(along) - along[lowest]) / step;
  ACUS_REQUIRE(planes < 65535.0, path.string(), ": its frames lie ", step, " to ", planes * step,
               " mm from each other; the segmentation is broken");
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const double plane = (along[n] - along[lowest]) / step;
    frames[n].plane = static_cast<int>(std::lround(plane));
    const Eigen::Vector3d aside =
        frames[n].position_mm - geometry.origin_mm - normal * (along[n] - along[lowest]);
    ACUS_REQUIRE(std::abs(plane - frames[n].plane) < kMostOffStep &&
                     aside.norm() < kMostOffStep * std::min(spacing[0], spacing[1]),
                 path.string(), ": frame ", n + 1, " does not lie on the grid of the others (step ",
                 step, " mm); resample the segmentation to a rectangular grid");
  }
  geometry.spacing_mm = Eigen::Array3d(spacing[1], spacing[0], step);  // The file: rows first.
  geometry.size = {root.Short(0x00280011U, 0), root.Short(0x00280010U, 0),
                   static_cast<int>(std::lround(planes)) + 1};
  RequireUsable(geometry, path);
  return geometry;
}

/// The pixels of all frames, one after the other; bits are packed without gaps between frames.
class SegmentPixels {
 public:
  /// @param decoded  Of compressed pixels; otherwise empty.
  SegmentPixels(const DicomItem& root, const std::string& decoded, std::size_t count,
                const fs::path& path)
      : bits_(root.Short(0x00280100U, 1)) {
    const std::string type = root.Text(0x00620001U);
    const int largest = root.Short(0x0062000EU, 255);
    is_label_map_ = type == "LABELMAP";
    threshold_ = type == "FRACTIONAL" ? (largest + 1) / 2 : 1;
    ACUS_REQUIRE(bits_ == 1 || bits_ == 8 || (bits_ == 16 && is_label_map_), path.string(),
                 ": has ", bits_,
                 " bits for each pixel; segmentations have 1, 8, or 16 as label maps");
    const auto found = root.values.find(kSegmentPixels);
    if (!decoded.empty()) {
      bytes_ = {reinterpret_cast<const std::uint8_t*>(decoded.data()), decoded.size()};
    } else if (found != root.values.end()) {
      bytes_ = found->second;
    }
    const std::size_t have = bytes_.size();
    const std::size_t need = (count * static_cast<std::size_t>(bits_) + 7) / 8;
    ACUS_REQUIRE(have >= need, path.string(), ": has ", have, " bytes of pixels for ", need,
                 "; it is cut off or broken. Copy or export it again");
  }

  /// The value that a pixel gives to its voxel, 0 for none.
  std::int32_t ValueAt(std::size_t pixel, int segment) const {
    int stored = 0;
    if (bits_ == 1) {
      stored = bytes_[pixel / 8] >> (pixel % 8) & 1;
    } else {
      const auto each = static_cast<std::size_t>(bits_ / 8);
      stored = bytes_[pixel * each] | (each == 2 ? bytes_[pixel * each + 1] << 8 : 0);
    }
    return is_label_map_ ? stored : stored >= threshold_ ? segment : 0;
  }

 private:
  int bits_;
  int threshold_ = 1;
  bool is_label_map_ = false;
  DicomBytes bytes_;
};

/// Compressed pixels, decoded: of 8 or 16 bits, as single bits cannot be compressed.
std::string DecodedPixels(const DicomItem& root, int count, const fs::path& path) {
  DicomHeader header;
  header.file = path;
  header.transfer_syntax = root.Text(kDicomTransferSyntax);
  header.rows = root.Short(0x00280010U, 0);
  header.columns = root.Short(0x00280011U, 0);
  header.num_frames = count;
  header.bits_allocated = root.Short(0x00280100U, 1);
  header.bits_stored = root.Short(0x00280101U, header.bits_allocated);
  ACUS_REQUIRE(header.bits_allocated == 8 || header.bits_allocated == 16, path.string(),
               ": its pixels of ", header.bits_allocated,
               " bits are compressed, which is read for 8 and 16; export it uncompressed (for "
               "example with gdcmconv --raw)");
  const DicomBytes fragments = root.values.at(kSegmentPixels);
  return DecodedFrames(header, std::string(fragments.begin(), fragments.end()));
}

}  // namespace

bool IsDicomSegmentation(const fs::path& path) {
  const auto header = ReadDicomHeader(path);
  return header && header->modality == "SEG";
}

NamedValues ReadDicomSegmentation(const fs::path& path) {
  const DicomDataSet data = ReadDicomDataSet(path);
  const DicomItem& root = data.root;
  const auto stated = root.Decimals(0x00280008U, 1);
  const int count = stated.empty() ? 1 : static_cast<int>(std::clamp(stated[0], 0.0, 1e6));
  const bool is_label_map = root.Text(0x00620001U) == "LABELMAP";
  std::vector<SegmentFrame> frames = FramesOf(root, count, is_label_map, path);
  NamedValues map;
  const Geometry geometry = GridOf(root, frames, path);
  RequireMemory(static_cast<double>(geometry.num_voxels()) * sizeof(std::int32_t),
                static_cast<double>(data.bytes.size()), path.string());
  map.values = Grid<std::int32_t>(geometry);
  const std::size_t frame_pixels = geometry.Index(0, 0, 1);
  const std::string decoded = data.is_encapsulated ? DecodedPixels(root, count, path) : "";
  const SegmentPixels pixels(root, decoded, frame_pixels * frames.size(), path);
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const std::size_t begin = geometry.Index(0, 0, frames[n].plane);
    for (std::size_t p = 0; p < frame_pixels; ++p) {
      const std::int32_t value = pixels.ValueAt(n * frame_pixels + p, frames[n].segment);
      std::int32_t& voxel = map.values.voxels[begin + p];
      voxel = std::max(voxel, value);
    }
  }
  map.names = SegmentNames(root);
  map.named_by = map.names.empty() ? "" : "by its segments' labels and codes";
  return map;
}

}  // namespace acus::volume
