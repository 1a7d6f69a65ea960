// Videos: images as H.264 in MP4, which every browser plays.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "acus/data/image/image.h"

namespace acus::image {

/// 16 + 219 / 255 grey: grey to the luma range of video (ITU-R BT.601).
constexpr std::uint8_t VideoLuma(std::uint8_t grey) {
  return static_cast<std::uint8_t>((grey * 220 + 16 * 256 + 128) >> 8);
}

struct FilmOptions {
  double frames_per_s = 30.0;
  int quality = 27;         ///< H.264 quantiser: 0 lossless ... 51 worst.
  bool background = false;  ///< Encode on a separate thread. The bytes are the same.
};

/// Writes a video image by image, whole or not at all. The same images give the same bytes.
class FilmWriter {
 public:
  /// @throws InputError if an option is out of range, the size is not 16 to 8192 each way, the
  ///     file cannot be made, or this system's libavcodec has no H.264 encoder.
  FilmWriter(const std::filesystem::path& path, int width_px, int height_px,
             const FilmOptions& options = {});
  /// Without Finish() no file remains.
  ~FilmWriter();
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;

  /// In the background, a copy is queued; waits if eight are. What goes wrong there is thrown by a
  /// later call.
  /// @throws InputError if the image has another size, or the disk is full.
  void Add(const GrayImage& image);
  /// At once, also in the background after what is queued. A video is of one kind of image.
  void Add(const ColourImage& image);

  int num_frames() const { return num_frames_; }

  /// Completes the video and puts it in place.
  /// @throws InputError if it has no frame, or the file cannot be written.
  void Finish();

 private:
  struct Encoder;
  class Worker;
  std::unique_ptr<Encoder> encoder_;
  std::unique_ptr<Worker> worker_;  ///< Null if not in the background. Ends before encoder_.
  int num_frames_ = 0;
};

}  // namespace acus::image
