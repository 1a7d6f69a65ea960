// Writes a DICOM segmentation object: explicit little endian.
#pragma once

#include "support/dicom_writer.h"

namespace acus::testing_support {

struct DicomSegment {
  std::string label;
  std::string code;       ///< SNOMED CT, of the segmented property.
  std::string side_code;  ///< Of its modifier; empty: none.
};

struct DicomSegFrame {
  int segment = 1;
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  std::vector<int> pixels;  ///< Columns x rows; 0 or 1 if binary.
};

struct DicomSegObject {
  int columns = 3;
  int rows = 3;
  std::string spacing = "2\\1";  ///< Between rows, between columns.
  std::string orientation = "1\\0\\0\\0\\1\\0";
  std::string type = "BINARY";
  int bits = 1;  ///< Of a pixel: 1, 8 or 16.
  std::vector<DicomSegment> segments;
  std::vector<DicomSegFrame> frames;
};

inline DicomBytes DicomCode(const std::string& value) {
  DicomBytes code;
  code.Element(8, 0x100, "SH", value);
  code.Element(8, 0x102, "SH", "SCT");
  return code;
}

inline DicomBytes DicomSegmentItem(const DicomSegment& segment, int number) {
  DicomBytes type = DicomCode(segment.code);
  if (!segment.side_code.empty()) type.Sequence(0x62, 0x11, {DicomCode(segment.side_code)});
  DicomBytes item;
  item.Short(0x62, 4, number);
  item.Element(0x62, 5, "LO", segment.label);
  item.Sequence(0x62, 0xF, {type});
  return item;
}

inline DicomBytes DicomFrameItem(const DicomSegFrame& frame) {
  DicomBytes position, segment, item;
  position.Element(0x20, 0x32, "DS", DicomText(frame.position_mm));
  segment.Short(0x62, 0xB, frame.segment);
  item.Sequence(0x20, 0x9113, {position});
  item.Sequence(0x62, 0xA, {segment});
  return item;
}

/// Pixels of all frames, without gaps between them.
inline std::string PackedPixels(const DicomSegObject& object) {
  std::string packed;
  if (object.bits > 1) {
    for (const DicomSegFrame& frame : object.frames) {
      for (const int pixel : frame.pixels) {
        packed += static_cast<char>(pixel & 0xFF);
        if (object.bits == 16) packed += static_cast<char>(pixel >> 8);
      }
    }
    return packed;
  }
  std::size_t bit = 0;
  for (const DicomSegFrame& frame : object.frames) {
    for (const int pixel : frame.pixels) {
      if (bit % 8 == 0) packed += '\0';
      packed.back() = static_cast<char>(packed.back() | pixel << bit % 8);
      ++bit;
    }
  }
  return packed;
}

inline void WriteDicomSegmentation(const std::filesystem::path& path,
                                   const DicomSegObject& object) {
  const std::string segmentation_storage = "1.2.840.10008.5.1.4.1.1.66.4";
  DicomBytes meta, body, orientation, measures, shared;
  meta.Element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
  body.Element(8, 0x16, "UI", segmentation_storage);
  body.Element(8, 0x60, "CS", "SEG");
  body.Short(0x28, 2, 1);
  body.Element(0x28, 8, "IS", std::to_string(object.frames.size()));
  body.Short(0x28, 0x10, object.rows);
  body.Short(0x28, 0x11, object.columns);
  body.Short(0x28, 0x100, object.bits);
  body.Element(0x62, 1, "CS", object.type);
  std::vector<DicomBytes> segments, frames;
  for (const DicomSegment& segment : object.segments) {
    segments.push_back(DicomSegmentItem(segment, static_cast<int>(segments.size()) + 1));
  }
  body.Sequence(0x62, 2, segments);
  orientation.Element(0x20, 0x37, "DS", object.orientation);
  measures.Element(0x18, 0x50, "DS", "3");
  measures.Element(0x28, 0x30, "DS", object.spacing);
  shared.Sequence(0x20, 0x9116, {orientation});
  shared.Sequence(0x28, 0x9110, {measures});
  body.Sequence(0x5200, 0x9229, {shared});
  for (const DicomSegFrame& frame : object.frames) frames.push_back(DicomFrameItem(frame));
  body.Sequence(0x5200, 0x9230, frames);
  body.Element(0x7FE0, 0x10, "OB", PackedPixels(object));
  std::ofstream out(path, std::ios::binary);
  out << std::string(128, '\0') << "DICM" << meta.bytes() << body.bytes();
}

}  // namespace acus::testing_support
