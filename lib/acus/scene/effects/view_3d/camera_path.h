// The path of a camera: key frames in a file.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <vector>

#include "acus/imaging/volume_rendering/camera.h"

namespace acus::effects {

/// Format acus-camera-path/1. Between keys, eye and focus, or the angles around the patient, follow
/// cubic Hermite curves whose slope at a key is that from the key before to the key after it, and
/// at the ends that of the first and last piece: two keys give a uniform motion.
class CameraPath {
 public:
  /// @throws InputError listing all problems of the file; for times that do not rise, and keys that
  ///     have both or neither of eye_mm with focus_mm and azimuth_deg.
  static CameraPath Read(const std::filesystem::path& path);

  /// @param session_s  Since the session began. Before the first key, the first key holds.
  /// @param box_in_ct_mm  The patient, for keys around him.
  volume_rendering::Viewpoint At(double session_s, const Eigen::AlignedBox3d& box_in_ct_mm,
                                 const volume_rendering::ImageSize& size) const;

 private:
  /// Eye, focus and up; or azimuth, elevation and distance, then zeros. Then the view angle.
  static constexpr int kNumValues = 10;
  using Values = Eigen::Array<double, kNumValues, 1>;
  struct Key {
    double time_s = 0.0;
    Values values = Values::Zero();
  };

  Values ValuesAt(double time_s) const;
  Values SlopeAt(std::size_t key) const;

  std::vector<Key> keys_;
  bool around_ = false;  ///< Keys are around the patient; otherwise in CT space.
  bool repeat_ = false;
};

}  // namespace acus::effects
