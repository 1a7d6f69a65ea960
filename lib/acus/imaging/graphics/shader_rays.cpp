#include "acus/imaging/graphics/shader_rays.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "acus/imaging/graphics/blocks_on_card.h"
#include "acus/imaging/graphics/gl_objects.h"
#include "acus/imaging/graphics/job_thread.h"
#include "acus/imaging/graphics/moment_block.h"
#include "acus/imaging/graphics/ray_shader.h"
#include "acus/imaging/graphics/surfaces_on_card.h"

namespace acus::graphics {
namespace {

using namespace volume_rendering;

constexpr int kGroup = 8;        // Pixels each way of a group of the shader of rays.
constexpr int kSplitGroup = 64;  // Invocations of a group that splits pixels, four each.
constexpr double kNearMm = 1.0;  // As of TriangleBands.
/// Fields of breath that stay on the card: those of an instant, and of some key frames.
constexpr int kMostFields = 8;

/// One component of a motion field on the card.
struct StoredField {
  std::uint64_t field = 0;  ///< MotionField::identity.
  int component = -1;
  Texture texture;
};

/// Columns and rows, and the distance before the eye, of places in CT space. Whole numbers are the
/// middles of pixels; the first row is the lowest one of the drawing. Depth is kNearMm over z.
Eigen::Matrix4f ClipFromCt(const Camera& camera) {
  const double width_px = camera.width_px;
  const double height_px = camera.height_px;
  Eigen::Matrix4d clip_from_camera = Eigen::Matrix4d::Zero();
  clip_from_camera(0, 0) = 2.0 * camera.focal_px[0] / width_px;
  clip_from_camera(0, 2) = 2.0 * (camera.centre_px[0] + 0.5) / width_px - 1.0;
  clip_from_camera(1, 1) = 2.0 * camera.focal_px[1] / height_px;
  clip_from_camera(1, 2) = 2.0 * (camera.centre_px[1] + 0.5) / height_px - 1.0;
  clip_from_camera(2, 3) = kNearMm;
  clip_from_camera(3, 2) = 1.0;
  return (clip_from_camera * camera.camera_from_ct.matrix()).cast<float>();
}

/// All of it belongs to one context, and to the thread in which that is current.
class Renderer {
 public:
  explicit Renderer(DriverKind kind) : context_(kind) { context_.Check("its shaders"); }
  const std::string& name() const { return context_.renderer(); }
  void Load(const VolumeScene& scene, const breathing::MotionField* field);
  void Render(const VolumeScene& scene, const DeviceImage& image, std::span<std::uint8_t> rgb,
              std::span<std::uint8_t> coverage);

 private:
  void SetImage(const DeviceImage& image);
  void SetBlocks(const VolumeScene& scene);
  void SetBreath(const breathing::MotionMap* motion, const WarpSettings& warp);
  const Texture& FieldOnCard(const breathing::MotionField& field, int component);
  void SetPressed(const PressedTissue* pressed);
  void SetLight(const Light& light, const ShadowFrame* shadows);
  void SetCuts(std::span<const CutPlane> cuts);
  void CastRays(std::size_t num_pixels);

  GlContext context_;
  SurfacesOnCard surfaces_;
  Program rays_{{ShaderStage::kCompute, RayShaderSource()}};
  Program split_{{ShaderStage::kCompute, SplitShaderSource()}};
  MomentBlock moment_;
  Buffer moment_on_card_;
  Texture hu_, slopes_, classes_, pressed_;
  BlocksOnCard blocks_;
  std::vector<StoredField> fields_;  ///< The one used last at the end.
  Buffer integral_, value_, cuts_, pixels_, colours_, coverage_;
};

void Renderer::Load(const VolumeScene& scene, const breathing::MotionField* field) {
  const volume::Geometry& grid = scene.ct->geometry;
  const Eigen::Affine3f index_from_ct = grid.index_from_ct().cast<float>();
  hu_.Set(TexelFormat::kShort, grid.size, scene.ct->voxels.data());
  if (scene.slopes != nullptr && scene.slopes->units() != nullptr) {
    slopes_.Set(TexelFormat::kByte4, grid.size, scene.slopes->units());
  }
  const bool has_classes = scene.classes != nullptr && scene.classes->data() != nullptr;
  if (has_classes) classes_.Set(TexelFormat::kIndex, grid.size, scene.classes->data());
  const auto table = scene.transfer->table();
  const std::size_t bytes = sizeof(TransferFunction::Emission) *
                            static_cast<std::size_t>(table.count * scene.transfer->num_classes());
  integral_.Set(table.integral, bytes);
  value_.Set(table.value, bytes);
  moment_.ct_size = grid.size.matrix();
  moment_.index_linear = Padded(index_from_ct.linear());
  moment_.index_offset = index_from_ct.translation();
  moment_.ct_from_grid = Padded(grid.direction.cast<float>());
  moment_.steepest_hu_per_mm = SlopeVolume::kSteepest;
  moment_.surface_hu_per_mm = kSurfaceHuPerMm;
  moment_.lowest_hu = table.lowest_hu;
  moment_.table_count = table.count;
  moment_.has_classes = has_classes ? 1 : 0;
  moment_.dark = kDark;
  if (!scene.blocks->nothing_visible()) blocks_.Load(*scene.blocks);
  for (int n = 0; field != nullptr && n < std::min(field->num_components(), kMostFields); ++n) {
    FieldOnCard(*field, n);
  }
  context_.Check("the patient");
}

void Renderer::SetImage(const DeviceImage& image) {
  const Camera& camera = image.camera;
  moment_.ct_from_camera = Padded(camera.camera_from_ct.linear().transpose().cast<float>());
  moment_.eye_mm = camera.EyeInCtMm().cast<float>();
  moment_.clip_from_ct = ClipFromCt(camera);
  moment_.focal_px = camera.focal_px.cast<float>();
  moment_.centre_px = camera.centre_px.cast<float>();
  moment_.supersampling = image.supersampling;
  moment_.image_size = {camera.width_px / image.supersampling,
                        camera.height_px / image.supersampling};
  moment_.background_top = image.background_top;
  moment_.background_bottom = image.background_bottom;
  moment_.step_mm = static_cast<float>(image.rays.step_mm);
  moment_.tool_shine = static_cast<float>(image.rays.tool_shine);
  moment_.is_maximum = image.rays.projection == Projection::kMaximum ? 1 : 0;
  moment_.window_hu = {static_cast<float>(image.rays.window.low_hu),
                       static_cast<float>(image.rays.window.high_hu)};
}

void Renderer::SetBlocks(const VolumeScene& scene) {
  moment_.has_volume = scene.blocks->nothing_visible() ? 0 : 1;
  if (scene.blocks->nothing_visible()) return;
  const BlockFrame frame = scene.blocks->FrameFor(scene.motion, moment_.step_mm);
  blocks_.Update(*scene.blocks, frame, scene.motion, scene.pressed);
  moment_.blocks_size = frame.size.matrix();
  moment_.blocks_linear = Padded(frame.blocks_from_ct.linear());
  moment_.blocks_offset = frame.blocks_from_ct.translation();
}

const Texture& Renderer::FieldOnCard(const breathing::MotionField& field, int component) {
  const auto there = std::ranges::find_if(fields_, [&](const StoredField& stored) {
    return stored.field == field.identity() && stored.component == component;
  });
  if (there != fields_.end()) {
    std::rotate(there, there + 1, fields_.end());
    return fields_.back().texture;
  }
  const Eigen::Array3i& size = field.nodes().size;
  // Four values a node: drivers convert textures of three.
  std::vector<std::array<std::int16_t, 4>> packed;
  packed.reserve(field.nodes().num_voxels());
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      const auto row = field.StoredRow(component, j, k);
      for (std::size_t n = 0; n + 2 < row.size(); n += 3) {
        packed.push_back({row[n], row[n + 1], row[n + 2], 0});
      }
    }
  }
  if (fields_.size() == static_cast<std::size_t>(kMostFields)) {
    std::rotate(fields_.begin(), fields_.begin() + 1, fields_.end());
  } else {
    fields_.emplace_back();
  }
  StoredField& stored = fields_.back();
  stored.field = field.identity();
  stored.component = component;
  stored.texture.Set(TexelFormat::kShort4, size, packed.data());
  return stored.texture;
}

void Renderer::SetBreath(const breathing::MotionMap* motion, const WarpSettings& warp) {
  const bool moves = motion != nullptr && motion->moves();
  moment_.num_components = moves ? motion->weights().count : 0;
  if (!moves) return;
  const breathing::MotionField& field = motion->field();
  const Eigen::Affine3f nodes_from_ct = field.nodes().index_from_ct().cast<float>();
  moment_.nodes_size = field.nodes().size.matrix();
  moment_.nodes_linear = Padded(nodes_from_ct.linear());
  moment_.nodes_offset = nodes_from_ct.translation();
  moment_.most_iterations = warp.max_iterations;
  moment_.tolerance_mm = static_cast<float>(warp.tolerance_mm);
  moment_.component_scale.setZero();
  for (int n = 0; n < motion->weights().count; ++n) {
    const int component = motion->weights().component[static_cast<std::size_t>(n)];
    moment_.component_scale[n] = motion->weights().weight[static_cast<std::size_t>(n)] *
                                 static_cast<float>(32767.0 * field.MmPerUnit(component));
    FieldOnCard(field, component).Bind(kFirstComponent + static_cast<unsigned>(n));
  }
}

void Renderer::SetPressed(const PressedTissue* pressed) {
  const bool is_pressed = pressed != nullptr && !pressed->empty();
  moment_.is_pressed = is_pressed ? 1 : 0;
  if (!is_pressed) return;
  pressed_.Set(TexelFormat::kFloat3, pressed->size(), pressed->knots().data());
  moment_.pressed_size = pressed->size().matrix();
  moment_.pressed_low_mm = pressed->box_in_ct_mm().min();
  moment_.pressed_high_mm = pressed->box_in_ct_mm().max();
  moment_.pressed_spacing_mm = pressed->spacing_mm();
}

void Renderer::SetLight(const Light& light, const ShadowFrame* shadows) {
  moment_.to_lamp = light.to_lamp;
  moment_.light = {light.ambient, light.diffuse, light.fill, light.gloss};
  moment_.has_shadows = shadows == nullptr ? 0 : 1;
  if (shadows == nullptr) return;
  moment_.shadow_size = ShadowMap::kSize;
  moment_.lamp_from_ct = Padded(shadows->lamp_from_ct);
  moment_.shadow_low_mm = shadows->low_mm;
  moment_.shadow_cell_mm = shadows->mm_per_cell;
  moment_.shadow_clear_mm = ShadowMap::kClearMm;
}

void Renderer::SetCuts(std::span<const CutPlane> cuts) {
  std::vector<Eigen::Vector4f> planes;
  for (const CutPlane& cut : cuts) planes.emplace_back(cut.coeffs().cast<float>());
  moment_.num_cuts = static_cast<int>(planes.size());
  cuts_.Set(planes.data(), planes.size() * sizeof(Eigen::Vector4f));
  cuts_.Bind(kCuts);
}

void Renderer::CastRays(std::size_t num_pixels) {
  hu_.Bind(kHu);
  slopes_.Bind(kSlopes);
  classes_.Bind(kClasses);
  blocks_.Bind(kDistances);
  integral_.Bind(kIntegral);
  value_.Bind(kValue);
  pixels_.Bind(kPixels);
  colours_.Bind(kColours);
  coverage_.Bind(kCoverage);
  surfaces_.Bind();
  rays_.Run({(moment_.image_size[0] + kGroup - 1) / kGroup,
             (moment_.image_size[1] + kGroup - 1) / kGroup, 1});
  split_.Set("num_pixels", static_cast<int>(num_pixels));
  const auto pixels_of_group = static_cast<std::size_t>(4 * kSplitGroup);
  split_.Run({static_cast<int>((num_pixels + pixels_of_group - 1) / pixels_of_group), 1, 1});
}

void Renderer::Render(const VolumeScene& scene, const DeviceImage& image,
                      std::span<std::uint8_t> rgb, std::span<std::uint8_t> coverage) {
  SetImage(image);
  SetBlocks(scene);
  SetBreath(scene.motion, image.rays.warp);
  SetPressed(scene.pressed);
  SetLight(scene.light, image.shadows);
  SetCuts(scene.cuts);
  pressed_.Bind(kPressed);
  const std::size_t num_pixels = coverage.size();
  const std::size_t in_fours = 4 * ((num_pixels + 3) / 4);
  pixels_.Set(nullptr, 4 * in_fours);
  colours_.Set(nullptr, 3 * in_fours);
  coverage_.Set(nullptr, in_fours);
  do {
    moment_.most_nodes = surfaces_.Begin(image);
    moment_on_card_.Set(&moment_, sizeof(moment_));
    moment_on_card_.BindUniforms(0);
    context_.Check("an image's data");
    surfaces_.Draw(image);
    CastRays(num_pixels);
  } while (!surfaces_.HadRoom());
  colours_.Read(rgb.data(), rgb.size());
  coverage_.Read(coverage.data(), coverage.size());
  context_.Check("an image");
}

class ShaderRays final : public RayDevice {
 public:
  explicit ShaderRays(DriverKind kind) {
    thread_.Run([&] {
      renderer_.emplace(kind);
      name_ = renderer_->name();
    });
  }
  ~ShaderRays() override {
    try {
      thread_.Run([&] { renderer_.reset(); });
    } catch (const InputError&) {
      // What was begun has failed, and no image waits for it any more.
      thread_.Run([&] { renderer_.reset(); });
    }
  }
  ShaderRays(const ShaderRays&) = delete;
  ShaderRays& operator=(const ShaderRays&) = delete;

  std::string name() const override { return name_; }
  void Load(const VolumeScene& scene, const breathing::MotionField* field) override {
    thread_.Start([this, scene, field] {
      renderer_->Load(scene, field);
      bytes_sent_ = BytesSent();
    });
  }
  void Render(const VolumeScene& scene, const DeviceImage& image, std::span<std::uint8_t> rgb,
              std::span<std::uint8_t> coverage) override {
    thread_.Run([&] {
      renderer_->Render(scene, image, rgb, coverage);
      bytes_sent_ = BytesSent();
    });
  }
  std::uint64_t bytes_sent() const override { return bytes_sent_; }

 private:
  std::string name_;
  std::optional<Renderer> renderer_;
  std::atomic<std::uint64_t> bytes_sent_ = 0;
  JobThread thread_;
};

}  // namespace

std::unique_ptr<RayDevice> MakeShaderRays(DriverKind kind) {
  return std::make_unique<ShaderRays>(kind);
}

}  // namespace acus::graphics
