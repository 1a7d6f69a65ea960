// Tracked ultrasound sequences as PLUS and 3D Slicer write them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acus/data/session/sequence_header.h"
#include "acus/data/transforms/transform_graph.h"

namespace acus::session {

/// A sequence file: frames with fields (transforms, status, time) and, mostly, an image each.
/// The header is read at once, images when they are requested, so that memory holds one at a time.
class SequenceFile {
 public:
  /// Reads the header of an .igs.mha, .igs.mhd, .mha, .igs.nrrd or .seq.nrrd file.
  /// @throws InputError
  explicit SequenceFile(const std::filesystem::path& path);
  ~SequenceFile();
  SequenceFile(const SequenceFile&) = delete;
  SequenceFile& operator=(const SequenceFile&) = delete;

  const SequenceHeader& header() const { return header_; }
  std::size_t num_frames() const { return header_.num_frames(); }
  bool has_images() const { return header_.bytes_per_frame() > 0; }

  /// Time stamp of a frame, nothing if it has none. @throws InputError if it is not a number.
  std::optional<std::int64_t> TimeNs(std::size_t frame) const;

  /// All transforms of a frame, as far as their names say between which frames; and those of the
  /// whole file (calibrations). A transform whose status is not OK is there, but not valid.
  /// @throws InputError if the frame has a transform that is not 16 finite numbers.
  transforms::TransformGraph Transforms(std::size_t frame) const;

  /// How the rows and columns of the images lie in the body, e.g. "MFA": columns run to the marked
  /// side (M, or U unmarked), rows far from the transducer (F, or N near). "FM": rows are scan
  /// lines.
  std::string Orientation() const;

  /// The pixels of a frame as stored: channels, then width, then height; numbers in this machine's
  /// byte order. In order of frames is fastest (a compressed file starts again when going back).
  /// @throws InputError if the file has no images, or ends early, or its compression is broken.
  std::vector<std::uint8_t> ReadImage(std::size_t frame);

  /// The same, turned so that columns run to the marked side and rows away from the transducer.
  struct Image {
    std::size_t width = 0;
    std::size_t height = 0;
    std::vector<std::uint8_t> pixels;
  };
  /// @throws InputError as above, or if the orientation is not known ("XX").
  Image ReadImageMarkedFar(std::size_t frame);

 private:
  class Pixels;

  std::string Where(std::size_t frame, std::string_view field) const;

  std::filesystem::path path_;
  SequenceHeader header_;
  std::unique_ptr<Pixels> pixels_;
};

}  // namespace acus::session
