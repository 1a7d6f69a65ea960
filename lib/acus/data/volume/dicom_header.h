// The few DICOM elements that place a CT slice, read without decoding its pixels.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace acus::volume {

struct DicomHeader {
  std::filesystem::path file;
  std::string transfer_syntax;  ///< UID; empty for a file without a meta header.
  std::string series_uid;       ///< May be empty.
  std::string frame_uid;        ///< Frame of Reference UID; may be empty.
  std::string description;
  int temporal_position = 0;  ///< Temporal Position Identifier, of a scan over time; 0: none.
  std::string modality;       ///< "CT", "MR", "SEG", ...
  std::string image_type;     ///< For example "ORIGINAL\PRIMARY\LOCALIZER".
  std::string instance_uid;   ///< Of the object; may be empty.
  std::string acquisition_number;
  std::string acquisition_time;  ///< Or date and time.
  std::string content_time;
  std::string trigger_time;                 ///< Since the last breath or heart beat, ms.
  std::string phase_percentage;             ///< Nominal, of a cycle.
  std::string comments;                     ///< Image comments: of some scanners, the phase.
  double instance_number = 0.0;             ///< 0: not known.
  std::optional<double> slice_location_mm;  ///< As the scanner says, along its axis.
  int columns = 0;
  int rows = 0;
  int num_frames = 1;
  int bits_allocated = 16;
  int bits_stored = 16;
  int high_bit = 15;  ///< The highest bit that is stored.
  bool is_signed = false;
  int samples_per_pixel = 1;
  bool has_pixels = false;
  bool is_encapsulated = false;  ///< The pixels are compressed fragments.
  std::size_t pixels_begin = 0;  ///< Bytes of the pixel data in the file.
  std::size_t pixels_end = 0;
  bool is_placed = false;  ///< Position, orientation and spacing are there.
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();   ///< Centre of the first pixel, LPS.
  Eigen::Vector3d column_axis = Eigen::Vector3d::UnitX();  ///< Unit vector of increasing column.
  Eigen::Vector3d row_axis = Eigen::Vector3d::UnitY();     ///< Unit vector of increasing row.
  Eigen::Array2d spacing_mm = Eigen::Array2d::Ones();      ///< Between columns, between rows.
  double rescale_slope = 1.0;                              ///< HU = slope * stored + intercept.
  double rescale_intercept = 0.0;
  std::optional<double> padding_value;  ///< As stored, before rescaling.
  /// Of a frame of a compressed multi-frame object: all its frames, decoded; and which one it is.
  std::shared_ptr<const std::string> decoded_frames;
  std::size_t frame = 0;
};

/// Reads and checks the whole element structure, nested sequences too: no length in it is trusted
/// before it was held against the end of the file.
/// @returns Nothing if the file is not DICOM.
/// @throws InputError if it is DICOM, but cut off or broken.
std::optional<DicomHeader> ReadDicomHeader(const std::filesystem::path& file);

/// The frames of a multi-frame object (Enhanced CT), each with its place and rescaling. The object
/// itself if it does not say them.
std::vector<DicomHeader> FramesOf(const DicomHeader& object);

}  // namespace acus::volume
