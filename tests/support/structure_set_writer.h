// Writes a DICOM radiotherapy structure set: explicit little endian.
#pragma once

#include <cmath>
#include <numbers>

#include "support/dicom_writer.h"

namespace acus::testing_support {

using Contour = std::vector<Eigen::Vector3d>;  ///< LPS, mm.

struct StructureSetRoi {
  std::string name;
  std::string type = "ORGAN";  ///< RT ROI interpreted type.
  std::vector<Contour> contours = {};
  std::string geometry = "CLOSED_PLANAR";
  std::string frame_uid = "";  ///< Referenced Frame of Reference UID; empty: not written.
};

/// What a structure set was drawn on; empty: not written.
struct StructureSetReference {
  std::string frame_uid = "";
  std::string series_uid = "";
};

/// A circle in the plane z.
inline Contour CircleContour(double x_mm, double y_mm, double z_mm, double radius_mm,
                             int points = 120) {
  Contour circle;
  for (int n = 0; n < points; ++n) {
    const double angle = 2.0 * std::numbers::pi * n / points;
    circle.emplace_back(x_mm + radius_mm * std::cos(angle), y_mm + radius_mm * std::sin(angle),
                        z_mm);
  }
  return circle;
}

inline void WriteStructureSet(const std::filesystem::path& path,
                              const std::vector<StructureSetRoi>& rois,
                              const StructureSetReference& reference = {}) {
  std::vector<DicomBytes> names, contours_of_rois, observations;
  for (const StructureSetRoi& roi : rois) {
    const std::string number = std::to_string(names.size() + 7);
    DicomBytes name, of_roi, observation;
    name.Element(0x3006, 0x22, "IS", number);
    if (!roi.frame_uid.empty()) name.Element(0x3006, 0x24, "UI", roi.frame_uid);
    name.Element(0x3006, 0x26, "LO", roi.name);
    std::vector<DicomBytes> contours;
    for (const Contour& points : roi.contours) {
      std::string text;
      for (const Eigen::Vector3d& point : points)
        text += (text.empty() ? "" : "\\") + DicomText(point);
      DicomBytes contour;
      contour.Element(0x3006, 0x42, "CS", roi.geometry);
      contour.Element(0x3006, 0x46, "IS", std::to_string(points.size()));
      contour.Element(0x3006, 0x50, "DS", text);
      contours.push_back(contour);
    }
    if (!contours.empty()) of_roi.Sequence(0x3006, 0x40, contours);
    of_roi.Element(0x3006, 0x84, "IS", number);
    observation.Element(0x3006, 0x84, "IS", number);
    observation.Element(0x3006, 0xA4, "CS", roi.type);
    names.push_back(name);
    contours_of_rois.push_back(of_roi);
    observations.push_back(observation);
  }
  DicomBytes meta, body;
  meta.Element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
  body.Element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.481.3");
  body.Element(8, 0x60, "CS", "RTSTRUCT");
  if (!reference.frame_uid.empty()) {
    DicomBytes frame, study, series;
    frame.Element(0x20, 0x52, "UI", reference.frame_uid);
    if (!reference.series_uid.empty()) series.Element(0x20, 0xE, "UI", reference.series_uid);
    study.Sequence(0x3006, 0x14, {series});
    frame.Sequence(0x3006, 0x12, {study});
    body.Sequence(0x3006, 0x10, {frame});
  }
  body.Sequence(0x3006, 0x20, names);
  body.Sequence(0x3006, 0x39, contours_of_rois);
  body.Sequence(0x3006, 0x80, observations);
  std::ofstream out(path, std::ios::binary);
  out << std::string(128, '\0') << "DICM" << meta.bytes() << body.bytes();
}

}  // namespace acus::testing_support
