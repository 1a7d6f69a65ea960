// Writes tracked ultrasound sequences that PLUS and 3D Slicer open.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acus/data/transforms/pose.h"

namespace acus::session {

/// What all frames of a sequence share.
struct SequenceFormat {
  std::size_t width = 0;  ///< Of each image; 0 x 0 for a recording without images.
  std::size_t height = 0;
  std::size_t channels = 1;         ///< 1 grey, 3 RGB; 8 bits each.
  bool compressed = false;          ///< zlib over all frames (gzip in NRRD): smaller, slower.
  std::string orientation = "MFA";  ///< Columns to the marked side, rows far from the transducer.
  std::string image_type = "BRIGHTNESS";
  /// Fields of the whole file, e.g. ImageToProbeTransform.
  std::map<std::string, std::string> fields = {};
};

/// The fields of one frame, in the order in which they are written.
using SequenceFields = std::vector<std::pair<std::string, std::string>>;

/// "m00 m01 m02 m03 m10 ...": a transform as PLUS writes it, row by row, exact.
std::string TransformText(const Eigen::Matrix4d& to_from_from);

/// Appends `<name>Transform` and `<name>TransformStatus`, e.g. name = "ProbeToReference".
void AddTransform(SequenceFields& fields, std::string_view name,
                  const Eigen::Matrix4d& to_from_from, bool valid);

/// Writes frame by frame; memory does not grow with the images. The file appears on Commit().
/// ".mha" makes a MetaImage, ".nrrd" an NRRD. Name the file *.igs.mha or *.igs.nrrd, so that PLUS
/// and Slicer recognise a sequence.
class SequenceWriter {
 public:
  /// @throws InputError if the ending is another one, or the place cannot be written to.
  SequenceWriter(const std::filesystem::path& path, const SequenceFormat& format);
  ~SequenceWriter();
  SequenceWriter(const SequenceWriter&) = delete;
  SequenceWriter& operator=(const SequenceWriter&) = delete;

  /// @param image  width x height x channels bytes; empty for a recording without images, or for a
  ///     frame whose image is missing (it is written black, with ImageStatus INVALID).
  /// @throws InputError if the size differs, the time does not increase, a name or value does not
  ///     fit into one header line, or the disk is full.
  void AddFrame(std::int64_t time_ns, std::span<const std::uint8_t> image,
                const SequenceFields& fields);

  std::size_t num_frames() const;

  /// @throws InputError if there is no frame, or the file cannot be put in place.
  void Commit();

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace acus::session
