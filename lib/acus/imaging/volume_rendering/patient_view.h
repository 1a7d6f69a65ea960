// Images of a breathing patient in three dimensions: the CT by direct volume rendering, organs as
// surfaces, and the tools.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/data/mesh/surface.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/cut_planes.h"
#include "acus/imaging/volume_rendering/pressed_tissue.h"
#include "acus/imaging/volume_rendering/ray_device.h"
#include "acus/imaging/volume_rendering/transfer_function.h"
#include "acus/imaging/volume_rendering/volume_ray.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::volume_rendering {

struct SurfaceInView {
  std::string name;
  mesh::Surface surface;                                   ///< At rest, CT space; closed.
  Eigen::Array3f colour = Eigen::Array3f::Constant(0.8F);  ///< sRGB, 0 to 1.
  double opacity = 1.0;                                    ///< 1 hides what is behind.
};

/// All that is constant. What is not there is not shown and costs nothing.
struct PatientInView {
  std::shared_ptr<const volume::CtVolume> ct;  ///< May be null.
  /// How the CT looks; empty: it does not show. A maximum intensity projection needs none.
  std::vector<VolumeLayer> layers;
  std::vector<SurfaceInView> surfaces;
  /// What the patient breathes by; null: never. Must outlive the view.
  const breathing::MotionField* field = nullptr;
  /// Needed by layers that hold in some tissues only; else it may be null.
  std::shared_ptr<const volume::LabelMap> labels = nullptr;
};

struct ViewSettings {
  RaySettings rays;
  /// Pixels are the mean of this many each way: smooth edges. 1, 2 or 4.
  int supersampling = 1;
  bool tool_shadows = true;
  Eigen::Array3f background_top = {0.20F, 0.23F, 0.27F};
  Eigen::Array3f background_bottom = {0.05F, 0.06F, 0.08F};
};

/// The probe, and the plane that it sees.
struct ProbeInView {
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  const acoustics::Probe* probe = nullptr;
  bool plane = true;
  const image::GrayImage* b_mode = nullptr;  ///< Shown in the plane; null: an empty pane.
};

/// What an image needs of an instant. Tools are in the world: where they are, not where
/// that was at rest.
/// From one place to another, drawn as an arrow; CT space.
struct Arrow {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mm = Eigen::Vector3d::Zero();
};

struct ViewMoment {
  const breathing::MotionMap* motion = nullptr;  ///< Of the field given before; null: at rest.
  std::optional<image::NeedleInImage> needle = std::nullopt;
  std::optional<ProbeInView> probe = std::nullopt;
  /// Where the needle's tip has been, drawn as a line; CT space, mm. Fewer than two: none.
  std::span<const Eigen::Vector3d> path_in_ct_mm = {};
  /// Arrow of a force; one that is not finite or has no length is not drawn.
  std::optional<Arrow> arrow = std::nullopt;
  /// Tissue that tools press, after breath; null: none.
  const PressedTissue* pressed = nullptr;
  /// Finite normals of unit length; empty: the patient is whole.
  std::vector<CutPlane> cuts = {};
};

/// An image, and how much of each pixel the patient and the tools fill: for laying it over video.
struct ViewImage {
  image::ColourImage colour;
  std::vector<std::uint8_t> coverage;  ///< By pixel: 0 background, 255 opaque.
};

/// Renders by itself, without graphics hardware or display: the same input, the same bits, with any
/// number of threads and whatever was rendered before, unless a device casts the rays. Not for two
/// threads at a time.
class PatientView {
 public:
  /// @throws InputError naming what is wrong: a setting out of range, a surface without triangles,
  ///     a CT of fewer than two voxels along an axis, a layer without a preset, a
  ///     projection without a CT, nothing to show.
  PatientView(PatientInView patient, const ViewSettings& settings);
  ~PatientView();
  PatientView(PatientView&&) noexcept;
  PatientView& operator=(PatientView&&) noexcept;

  /// @throws InputError if the camera, the needle or the probe's pose is not finite or out of
  ///     range, or the motion is of another field.
  /// @param stop  Asked again and again, by any of the threads: true ends it.
  /// @return false if it was stopped: `out` is not whole.
  bool Render(const Camera& camera, const ViewMoment& moment, ViewImage& out, int num_threads,
              const std::function<bool()>& stop = {});

  /// From now on this casts the rays through the CT; surfaces and tools are drawn as before. If it
  /// fails, the processor does it again, for good.
  void UseDevice(std::unique_ptr<RayDevice> device);
  /// Why the device is not used any more; empty: it is, or there never was one.
  const std::string& device_trouble() const;

  /// Box of the patient at rest: surfaces, or else the CT's visible part.
  const Eigen::AlignedBox3d& box_in_ct_mm() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::volume_rendering
