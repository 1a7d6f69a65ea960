// Writes the smallest DICOM CT slice that a reader accepts: explicit little endian, uncompressed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::testing_support {

struct DicomSlice {
  std::string series_uid = "1.2.3";
  std::string description = "made by a test";
  std::string modality = "CT";
  int columns = 16;
  int rows = 12;
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d column_axis = Eigen::Vector3d::UnitX();
  Eigen::Vector3d row_axis = Eigen::Vector3d::UnitY();
  Eigen::Array2d spacing_mm = {0.5, 0.75};  ///< Between columns, between rows.
  bool is_signed = true;
  double slope = 1.0;
  double intercept = 0.0;
  int temporal_position = 0;         ///< 0: not written.
  std::vector<std::int16_t> stored;  ///< columns x rows.
  std::string frame_uid = "";        ///< Frame of Reference UID; empty: not written.
};

class DicomBytes {
 public:
  void Element(std::uint32_t group, std::uint32_t element, const char* vr, std::string value) {
    if (value.size() % 2 == 1) value += std::string(vr) == "UI" ? '\0' : ' ';
    U16(group);
    U16(element);
    bytes_ += vr;
    if (std::string(vr) == "OB" || std::string(vr) == "OW") {
      U16(0);
      U32(static_cast<std::uint32_t>(value.size()));
    } else {
      U16(static_cast<std::uint32_t>(value.size()));
    }
    bytes_ += value;
  }
  void Short(std::uint32_t group, std::uint32_t element, int value) {
    const std::string word{static_cast<char>(value & 255), static_cast<char>(value >> 8)};
    Element(group, element, "US", word);
  }
  /// A sequence of items with stated lengths.
  void Sequence(std::uint32_t group, std::uint32_t element, const std::vector<DicomBytes>& items) {
    DicomBytes all;
    for (const DicomBytes& item : items) {
      all.U16(0xFFFE);
      all.U16(0xE000);
      all.U32(static_cast<std::uint32_t>(item.bytes_.size()));
      all.bytes_ += item.bytes_;
    }
    U16(group);
    U16(element);
    bytes_ += "SQ";
    U16(0);
    U32(static_cast<std::uint32_t>(all.bytes_.size()));
    bytes_ += all.bytes_;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void U16(std::uint32_t v) {
    bytes_ += static_cast<char>(v & 255U);
    bytes_ += static_cast<char>(v >> 8U & 255U);
  }
  void U32(std::uint32_t v) {
    U16(v & 0xFFFFU);
    U16(v >> 16U);
  }
  std::string bytes_;
};

inline std::string DicomText(const Eigen::Vector3d& v) {
  return Message(v[0], "\\", v[1], "\\", v[2]);
}

inline void WriteDicomSlice(const std::filesystem::path& path, const DicomSlice& slice) {
  const std::string ct_image_storage = "1.2.840.10008.5.1.4.1.1.2";
  DicomBytes meta;
  meta.Element(2, 1, "OB", std::string("\0\1", 2));
  meta.Element(2, 2, "UI", ct_image_storage);
  meta.Element(2, 3, "UI", "1.2.3.4");
  meta.Element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
  DicomBytes body;
  body.Element(8, 8, "CS", "ORIGINAL\\PRIMARY\\AXIAL");
  body.Element(8, 0x16, "UI", ct_image_storage);
  body.Element(8, 0x60, "CS", slice.modality);
  body.Element(8, 0x103E, "LO", slice.description);
  body.Element(0x20, 0x0E, "UI", slice.series_uid);
  body.Element(0x20, 0x32, "DS", DicomText(slice.position_mm));
  body.Element(0x20, 0x37, "DS", DicomText(slice.column_axis) + "\\" + DicomText(slice.row_axis));
  if (!slice.frame_uid.empty()) body.Element(0x20, 0x52, "UI", slice.frame_uid);
  if (slice.temporal_position > 0) {
    body.Element(0x20, 0x100, "IS", std::to_string(slice.temporal_position));
  }
  body.Short(0x28, 2, 1);
  body.Element(0x28, 4, "CS", "MONOCHROME2");
  body.Short(0x28, 0x10, slice.rows);
  body.Short(0x28, 0x11, slice.columns);
  body.Element(0x28, 0x30, "DS", Message(slice.spacing_mm[1], "\\", slice.spacing_mm[0]));
  body.Short(0x28, 0x100, 16);
  body.Short(0x28, 0x101, 16);
  body.Short(0x28, 0x102, 15);
  body.Short(0x28, 0x103, slice.is_signed ? 1 : 0);
  body.Element(0x28, 0x1052, "DS", Message(slice.intercept));
  body.Element(0x28, 0x1053, "DS", Message(slice.slope));
  std::string pixels;
  for (const std::int16_t value : slice.stored) {
    pixels += static_cast<char>(value & 255);
    pixels += static_cast<char>(static_cast<std::uint16_t>(value) >> 8U);
  }
  body.Element(0x7FE0, 0x10, "OW", pixels);
  std::ofstream out(path, std::ios::binary);
  out << std::string(128, '\0') << "DICM" << meta.bytes() << body.bytes();
}

}  // namespace acus::testing_support
