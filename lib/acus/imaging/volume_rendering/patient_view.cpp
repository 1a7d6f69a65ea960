#include "acus/imaging/volume_rendering/patient_view.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/imaging/volume_rendering/band_renderer.h"
#include "acus/imaging/volume_rendering/fragments.h"
#include "acus/imaging/volume_rendering/moving_surface.h"
#include "acus/imaging/volume_rendering/pressed_surface.h"
#include "acus/imaging/volume_rendering/shadow_map.h"
#include "acus/imaging/volume_rendering/smoothing.h"
#include "acus/imaging/volume_rendering/tools.h"
#include "acus/imaging/volume_rendering/visible_blocks.h"

namespace acus::volume_rendering {
namespace {

/// Left of the camera, above and behind it.
const Eigen::Vector3d kLampInCamera{-0.40, -0.55, -0.75};
const Eigen::Array3f kSteel{0.92F, 0.94F, 0.97F};
const Eigen::Array3f kHub{0.95F, 0.72F, 0.18F};
const Eigen::Array3f kProbe{0.86F, 0.88F, 0.90F};
const Eigen::Array3f kMark{0.15F, 0.55F, 0.95F};
const Eigen::Array3f kPath{1.0F, 0.55F, 0.1F};
constexpr double kPathStepMm = 0.5;
constexpr double kPathRadiusMm = 0.4;
const Eigen::Array3f kArrow{0.9F, 0.15F, 0.15F};
constexpr double kArrowHeadMm = 6.0;  // Of a short arrow, half of it.
const Eigen::Array3f kPane{0.45F, 0.75F, 1.0F};
/// A needle of a third of a pixel could not be seen.
constexpr double kLeastNeedlePx = 1.1;

void CheckSettings(const ViewSettings& s) {
  ACUS_REQUIRE(s.rays.step_mm >= 0.05 && s.rays.step_mm <= 20.0, "view: samples on rays are ",
               s.rays.step_mm, " mm apart; allowed is 0.05 to 20 mm");
  ACUS_REQUIRE(s.rays.warp.max_iterations >= 1 && s.rays.warp.max_iterations <= 1000,
               "view: ", s.rays.warp.max_iterations, " inversion iterations; allowed is 1 to 1000");
  ACUS_REQUIRE(s.rays.warp.tolerance_mm >= 0.0 && s.rays.warp.tolerance_mm <= 10.0,
               "view: an inversion tolerance of ", s.rays.warp.tolerance_mm,
               " mm; allowed is 0 to 10 mm");
  ACUS_REQUIRE(s.rays.warp.lattice_mm >= 0.0 && s.rays.warp.lattice_mm <= 10.0,
               "view: a tolerance between knots of the warp of ", s.rays.warp.lattice_mm,
               " mm; allowed is 0 to 10 mm");
  ACUS_REQUIRE(s.rays.pixel_tolerance >= 0.0 && s.rays.pixel_tolerance <= 1.0,
               "view: pixels between others within ", s.rays.pixel_tolerance,
               " of full scale are interpolated; allowed is 0 to 1");
  ACUS_REQUIRE(s.rays.tool_shine >= 0.0 && s.rays.tool_shine <= 1.0,
               "view: tools shine through by ", s.rays.tool_shine, "; allowed is 0 to 1");
  ACUS_REQUIRE(s.supersampling == 1 || s.supersampling == 2 || s.supersampling == 4,
               "view: supersampling by ", s.supersampling, "; allowed are 1, 2 and 4");
}

/// What of the CT can show.
TransferFunction TransferOf(const PatientInView& patient, const RaySettings& rays) {
  if (rays.projection == Projection::kEmission) return TransferFunction(patient.layers);
  ACUS_REQUIRE(patient.ct != nullptr,
               "view: a maximum intensity projection needs a CT, and there is none");
  return ShownIn(rays.window);
}

/// A tool's surface in the world, for one image.
struct Placed {
  Placed(const mesh::Surface& surface, const Eigen::Isometry3d& ct_from_surface)
      : moving({ct_from_surface * surface.nodes_mm, surface.triangles}) {}
  MovingSurface moving;
};

std::uint8_t ByteOf(float share) {
  return static_cast<std::uint8_t>(255.0F * std::clamp(share, 0.0F, 1.0F) + 0.5F);
}

}  // namespace

struct PatientView::Content {
  Content(PatientInView patient, const ViewSettings& settings);
  void PlaceTools(const Camera& camera, const ViewMoment& moment);
  void AddTool(const mesh::Surface& surface, const Eigen::Isometry3d& ct_from_surface,
               const Eigen::Array3f& colour);
  void AddPlane(const ProbeInView& probe);
  void AddPath(const Camera& camera, std::span<const Eigen::Vector3d> path_mm);
  void AddArrow(const Arrow& arrow);
  void DrawSurface(std::size_t n, const ViewMoment& moment, bool at_rest, int num_threads);
  std::optional<ShadowFrame> ShadowsFrom(const Light& light) const;
  void CastShadows(const ShadowFrame& frame);
  void WriteRows(const std::vector<RayColour>& pixels, int band, const Camera& camera,
                 ViewImage& out) const;
  VolumeScene SceneAtRest() const;
  bool RenderOnDevice(const VolumeScene& scene, const Camera& fine, const ShadowFrame* frame,
                      ViewImage& out);

  PatientInView patient;
  ViewSettings settings;
  TransferFunction transfer;
  TissueClasses classes;
  std::optional<VisibleBlocks> blocks;
  SlopeVolume slopes;
  HiddenCells hidden;
  std::vector<MovingSurface> surfaces;
  std::vector<PressedSurface> pressed_surfaces;
  Eigen::AlignedBox3d box;

  // State of one image.
  std::deque<Placed> tools;
  ImagePlane plane;
  std::vector<Drawing> drawings;
  TriangleBands bands;
  ShadowMap shadows;
  WarpLattice lattice;

  std::unique_ptr<RayDevice> device;  ///< Null: the processor casts the rays.
  std::string device_trouble;
};

PatientView::Content::Content(PatientInView given, const ViewSettings& view_settings)
    : patient(std::move(given)),
      settings(view_settings),
      transfer(TransferOf(patient, settings.rays)) {
  CheckSettings(settings);
  const bool shows_ct = patient.ct != nullptr && !transfer.empty();
  ACUS_REQUIRE(patient.layers.empty() || patient.ct != nullptr,
               "view: volume layers need a CT, and there is none");
  if (shows_ct) {
    ACUS_REQUIRE((patient.ct->geometry.size >= 2).all(),
                 "view: the CT must have at least two voxels along each axis");
    if (transfer.has_classes()) {
      ACUS_REQUIRE(patient.labels != nullptr,
                   "view: a volume layer holds in some tissues only, and there is no label map");
      classes = TissueClasses(patient.ct->geometry, *patient.labels, transfer.class_of_label());
      patient.labels = nullptr;  // Not needed any more.
    }
    blocks.emplace(*patient.ct, transfer, patient.field, classes);
    if (settings.rays.projection == Projection::kEmission) {
      slopes = SlopeVolume(Smoothed(*patient.ct, 1), 1);
    }
    hidden = HiddenCells(*patient.ct, transfer, classes);
  }
  for (const SurfaceInView& surface : patient.surfaces) {
    ACUS_REQUIRE(surface.opacity >= 0.0 && surface.opacity <= 1.0, "view: surface \"", surface.name,
                 "\" has an opacity of ", surface.opacity, "; allowed is 0 to 1");
    if (surface.opacity == 0.0) continue;
    surfaces.emplace_back(surface.surface);
    box.extend(surfaces.back().RestBox());
    pressed_surfaces.emplace_back();
  }
  ACUS_REQUIRE(shows_ct || !surfaces.empty(),
               "view: there is nothing to show; give a layer of the CT, or a surface");
  std::erase_if(patient.surfaces, [](const SurfaceInView& s) { return s.opacity == 0.0; });
  for (SurfaceInView& surface : patient.surfaces) surface.surface = {};  // Not needed any more.
  if (box.isEmpty()) box = blocks->VisibleBox();
}

void PatientView::Content::AddTool(const mesh::Surface& surface,
                                   const Eigen::Isometry3d& ct_from_surface,
                                   const Eigen::Array3f& colour) {
  const MovingSurface& placed = tools.emplace_back(surface, ct_from_surface).moving;
  Drawing drawing;
  drawing.nodes_mm = &placed.nodes_mm();
  drawing.normals = &placed.normals();
  drawing.triangles = &placed.triangles();
  drawing.colour = colour;
  drawing.is_tool = true;
  drawings.push_back(drawing);
}

void PatientView::Content::AddPlane(const ProbeInView& probe) {
  const image::ImageGeometry image = acoustics::ImageOf(*probe.probe);
  plane = PlaneOf(*probe.probe);
  AddTool(plane.surface, probe.ct_from_probe, kPane);
  Drawing& drawing = drawings.back();
  drawing.normals = nullptr;
  drawing.closed = false;
  drawing.opacity = 0.25F;
  if (probe.b_mode != nullptr) {
    ACUS_REQUIRE(probe.b_mode->width == image.width_px && probe.b_mode->height == image.height_px,
                 "view: the image in the probe's plane has ", probe.b_mode->width, " x ",
                 probe.b_mode->height, " pixels; the probe's has ", image.width_px, " x ",
                 image.height_px);
    drawing.colour.setOnes();
    drawing.opacity = 0.97F;
    drawing.texture = probe.b_mode;
    drawing.texture_at = &plane.pixel_of_node;
  }
  // A frame, so that a black image is seen as well.
  AddTool(Tube(plane.outline_mm, Eigen::VectorXd::Constant(plane.outline_mm.cols(), 0.35)),
          probe.ct_from_probe, kPane);
}

/// Flat, and without a shadow: no tool, but seen through tissue as tools are.
void PatientView::Content::AddPath(const Camera& camera, std::span<const Eigen::Vector3d> path_mm) {
  std::vector<Eigen::Vector3d> apart;
  for (const Eigen::Vector3d& place : path_mm) {
    if (!place.allFinite()) continue;
    if (apart.empty() || (place - apart.back()).norm() > kPathStepMm) apart.push_back(place);
  }
  if (apart.size() < 2) return;
  const double depth_mm = (camera.camera_from_ct * apart.back())[2];
  const double radius_mm =
      std::max(kPathRadiusMm, kLeastNeedlePx * std::max(0.0, depth_mm) / camera.focal_px[0]);
  const auto count = static_cast<Eigen::Index>(apart.size());
  Eigen::Matrix3Xd points(3, count);
  for (Eigen::Index n = 0; n < count; ++n) points.col(n) = apart[static_cast<std::size_t>(n)];
  AddTool(Tube(points, Eigen::VectorXd::Constant(count, radius_mm)), Eigen::Isometry3d::Identity(),
          kPath);
  drawings.back().normals = nullptr;
}

void PatientView::Content::AddArrow(const Arrow& arrow) {
  const Eigen::Vector3d along_mm = arrow.to_mm - arrow.from_mm;
  const double length_mm = along_mm.norm();
  if (!(arrow.from_mm.allFinite() && std::isfinite(length_mm) && length_mm > kPathStepMm)) return;
  const double head_mm = std::min(kArrowHeadMm, 0.5 * length_mm);
  const Eigen::Vector3d neck_mm = arrow.to_mm - head_mm / length_mm * along_mm;
  Eigen::Matrix3Xd points(3, 4);
  points << arrow.from_mm, neck_mm, neck_mm, arrow.to_mm;
  const Eigen::Vector4d radii_mm(0.15 * head_mm, 0.15 * head_mm, 0.4 * head_mm, 0.0);
  AddTool(Tube(points, radii_mm), Eigen::Isometry3d::Identity(), kArrow);
}

void PatientView::Content::DrawSurface(std::size_t n, const ViewMoment& moment, bool at_rest,
                                       int num_threads) {
  MovingSurface& surface = surfaces[n];
  if (!at_rest) surface.Update(moment.motion, num_threads);
  Drawing drawing;
  drawing.at_rest = at_rest;
  drawing.nodes_mm = at_rest ? &surface.rest_mm() : &surface.nodes_mm();
  drawing.normals = at_rest ? &surface.rest_normals() : &surface.normals();
  drawing.triangles = &surface.triangles();
  if (moment.pressed != nullptr && !at_rest) {
    PressedSurface& pressed = pressed_surfaces[n];
    pressed.Update(*moment.pressed, surface.nodes_mm(), surface.normals(), surface.triangles(),
                   num_threads);
    drawing.nodes_mm = &pressed.nodes_mm();
    drawing.normals = &pressed.normals();
  }
  drawing.colour = patient.surfaces[n].colour;
  drawing.opacity = static_cast<float>(patient.surfaces[n].opacity);
  drawing.in_shadow = true;
  drawing.cuts = moment.cuts;
  drawing.closed = moment.cuts.empty();  // Cut open, its inside is seen.
  drawings.push_back(drawing);
}

void PatientView::Content::PlaceTools(const Camera& camera, const ViewMoment& moment) {
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  if (moment.needle) {
    const image::NeedleInImage& needle = *moment.needle;
    ACUS_REQUIRE(needle.tip_in_ct_mm.allFinite() && needle.axis_in_ct.allFinite() &&
                     std::isfinite(needle.length_mm) && std::isfinite(needle.radius_mm),
                 "view: the needle is at a place that is not finite");
    const double depth_mm = (camera.camera_from_ct * needle.tip_in_ct_mm)[2];
    const double mm_per_px = std::max(0.0, depth_mm) / camera.focal_px[0];
    AddTool(NeedleShaft(needle, kLeastNeedlePx * mm_per_px), here, kSteel);
    AddTool(NeedleHub(needle), here, kHub);
  }
  AddPath(camera, moment.path_in_ct_mm);
  if (moment.arrow) AddArrow(*moment.arrow);
  if (moment.probe) {
    const ProbeInView& probe = *moment.probe;
    ACUS_REQUIRE(probe.ct_from_probe.matrix().allFinite(),
                 "view: the probe is at a place that is not finite");
    ACUS_ASSERT(probe.probe != nullptr);
    AddTool(ProbeBody(*probe.probe), probe.ct_from_probe, kProbe);
    AddTool(ProbeMark(*probe.probe), probe.ct_from_probe, kMark);
    if (probe.plane) AddPlane(probe);
  }
}

std::optional<ShadowFrame> PatientView::Content::ShadowsFrom(const Light& light) const {
  if (!settings.tool_shadows) return std::nullopt;
  Eigen::AlignedBox3f around;
  for (const Drawing& drawing : drawings) {
    if (!drawing.throws_shadow()) continue;
    around.extend(drawing.nodes_mm->rowwise().minCoeff());
    around.extend(drawing.nodes_mm->rowwise().maxCoeff());
  }
  if (around.isEmpty()) return std::nullopt;
  return ShadowMap::FrameOf(light.to_lamp, around);
}

void PatientView::Content::CastShadows(const ShadowFrame& frame) {
  shadows.Begin(frame);
  for (const Drawing& drawing : drawings) {
    if (drawing.throws_shadow()) shadows.Add(*drawing.nodes_mm, *drawing.triangles);
  }
}

void PatientView::Content::WriteRows(const std::vector<RayColour>& pixels, int band,
                                     const Camera& camera, ViewImage& out) const {
  const int factor = settings.supersampling;
  const int fine_width = camera.width_px * factor;
  const float share = 1.0F / static_cast<float>(factor * factor);
  const int top = band * TriangleBands::kRows / factor;
  const int end = std::min(camera.height_px, top + TriangleBands::kRows / factor);
  for (int row = top; row < end; ++row) {
    const float down = static_cast<float>(row) / static_cast<float>(camera.height_px);
    const Eigen::Array3f background =
        settings.background_top + down * (settings.background_bottom - settings.background_top);
    for (int column = 0; column < camera.width_px; ++column) {
      Eigen::Array3f colour = Eigen::Array3f::Zero();
      float opacity = 0.0F;
      for (int j = 0; j < factor; ++j) {
        for (int i = 0; i < factor; ++i) {
          const RayColour& ray = pixels[static_cast<std::size_t>(
              ((row - top) * factor + j) * fine_width + column * factor + i)];
          colour += ray.colour.min(1.0F);
          opacity += ray.opacity;
        }
      }
      colour = share * colour + (1.0F - share * opacity) * background;
      const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(camera.width_px) +
                      static_cast<std::size_t>(column);
      for (int c = 0; c < 3; ++c) {
        out.colour.rgb[3 * at + static_cast<std::size_t>(c)] = ByteOf(colour[c]);
      }
      out.coverage[at] = ByteOf(share * opacity);
    }
  }
}

VolumeScene PatientView::Content::SceneAtRest() const {
  VolumeScene scene;
  if (!blocks) return scene;
  scene.ct = patient.ct.get();
  scene.slopes = &slopes;
  scene.transfer = &transfer;
  scene.classes = &classes;
  scene.blocks = &*blocks;
  scene.lattice = &lattice;
  scene.hidden = &hidden;
  return scene;
}

/// @return false if the device has failed.
bool PatientView::Content::RenderOnDevice(const VolumeScene& scene, const Camera& fine,
                                          const ShadowFrame* frame, ViewImage& out) {
  DeviceImage image;
  image.camera = fine;
  image.supersampling = settings.supersampling;
  image.rays = settings.rays;
  image.background_top = settings.background_top;
  image.background_bottom = settings.background_bottom;
  image.drawings = drawings;
  image.shadows = frame;
  try {
    device->Render(scene, image, out.colour.rgb, out.coverage);
  } catch (const InputError& error) {
    device_trouble = error.what();
    device.reset();
    return false;
  }
  return true;
}

PatientView::PatientView(PatientInView patient, const ViewSettings& settings)
    : content_(std::make_unique<Content>(std::move(patient), settings)) {}
PatientView::~PatientView() = default;
PatientView::PatientView(PatientView&&) noexcept = default;
PatientView& PatientView::operator=(PatientView&&) noexcept = default;

const Eigen::AlignedBox3d& PatientView::box_in_ct_mm() const {
  return content_->box;
}

void PatientView::UseDevice(std::unique_ptr<RayDevice> device) {
  content_->device = std::move(device);
  content_->device_trouble.clear();
  if (content_->device && content_->blocks) {
    content_->device->Load(content_->SceneAtRest(), content_->patient.field);
  }
}

const std::string& PatientView::device_trouble() const {
  return content_->device_trouble;
}

bool PatientView::Render(const Camera& camera, const ViewMoment& moment, ViewImage& out,
                         int num_threads, const std::function<bool()>& stop) {
  Content& c = *content_;
  camera.Check();
  const bool moves = moment.motion != nullptr && moment.motion->moves();
  ACUS_REQUIRE(!moves || &moment.motion->field() == c.patient.field,
               "view: the motion is of another field than the one the view was made with");
  const breathing::MotionMap* motion = moves ? moment.motion : nullptr;
  const PressedTissue* pressed =
      moment.pressed != nullptr && !moment.pressed->empty() ? moment.pressed : nullptr;
  for (const CutPlane& cut : moment.cuts) {
    ACUS_REQUIRE(cut.coeffs().allFinite(), "view: a cut plane is not finite");
  }
  const bool on_device = c.device != nullptr && c.blocks.has_value();
  if (c.blocks && !on_device) c.blocks->Update(motion, c.settings.rays.step_mm);
  if (c.blocks && !on_device && pressed != nullptr) {
    c.blocks->Widen(pressed->box_in_ct_mm(), pressed->LargestMm());
  }
  c.lattice.Clear();
  if (c.blocks && motion != nullptr && !on_device) {
    c.lattice.Update(*motion, *c.blocks, c.patient.ct->geometry.index_from_ct(),
                     c.settings.rays.warp.lattice_mm, num_threads);
  }

  c.tools.clear();
  c.drawings.clear();
  ViewMoment seen = moment;
  seen.motion = motion;
  seen.pressed = pressed;
  for (std::size_t n = 0; n < c.surfaces.size(); ++n) {
    c.DrawSurface(n, seen, on_device, num_threads);
  }
  c.PlaceTools(camera, moment);

  VolumeScene scene = c.SceneAtRest();
  scene.light.to_lamp =
      (camera.camera_from_ct.linear().transpose() * kLampInCamera.normalized()).cast<float>();
  scene.motion = motion;
  scene.pressed = pressed;
  scene.cuts = moment.cuts;
  const Camera fine = camera.Magnified(c.settings.supersampling);
  const std::optional<ShadowFrame> shadows = c.ShadowsFrom(scene.light);
  out.colour.Resize(camera.width_px, camera.height_px);
  out.coverage.resize(out.colour.rgb.size() / 3);
  if (on_device) {
    if (stop && stop()) return false;
    return c.RenderOnDevice(scene, fine, shadows ? &*shadows : nullptr, out) ||
           Render(camera, moment, out, num_threads, stop);
  }
  if (shadows) {
    c.CastShadows(*shadows);
    scene.shadows = &c.shadows;
  }
  c.bands.Sort(fine, c.drawings, num_threads);
  const BandRenderer renderer(scene, c.settings.rays, fine, c.bands);
  // Whichever thread is free takes the next band; each writes rows of its own.
  std::atomic<int> next = 0;
  std::atomic<bool> stopped = false;
  ParallelFor(num_threads, num_threads, [&](int) {
    BandRenderer::Scratch scratch;
    for (int band = next++; band < c.bands.num_bands() && !stopped; band = next++) {
      if (stop && stop()) stopped = true;
      renderer.Render(band, scratch);
      c.WriteRows(scratch.pixels, band, camera, out);
    }
  });
  return !stopped;
}

}  // namespace acus::volume_rendering
