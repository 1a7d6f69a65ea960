#include "acus/imaging/graphics/shader_rays.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "acus/imaging/graphics/gl_objects.h"
#include "acus/imaging/graphics/job_thread.h"
#include "acus/imaging/graphics/ray_shader.h"

namespace acus::graphics {
namespace {

using namespace volume_rendering;

/// As the shader has its buffers.
enum Binding : unsigned { kIntegral, kValue, kCuts, kFirst, kFragments, kPixels };
/// Units of its textures.
enum Unit : unsigned { kHu, kSlopes, kClasses, kDistances, kPressed, kShadows, kFirstComponent };
constexpr int kGroup = 8;  // Pixels each way of a group of the shader.
/// Fields of breath that stay on the card: those of an instant, and of some key frames.
constexpr std::size_t kMostFields = 8;

struct ShaderFragment {
  float distance_mm, opacity, red, green, blue, is_tool;
};

/// One component of a motion field on the card.
struct StoredField {
  std::uint64_t field = 0;  ///< MotionField::identity.
  int component = -1;
  Texture texture;
};

/// All of it belongs to one context, and to the thread in which that is current.
class Renderer {
 public:
  explicit Renderer(DriverKind kind);
  const std::string& name() const { return context_.renderer(); }
  void Cast(const VolumeScene& scene, const RaySettings& settings, const Camera& camera,
            const FragmentLists& surfaces, std::vector<std::uint8_t>& rgba);

 private:
  void LoadPatient(const VolumeScene& scene);
  void SetCamera(const Camera& camera);
  void SetBlocks(const VisibleBlocks& blocks);
  void SetBreath(const breathing::MotionMap* motion, const WarpSettings& warp);
  const Texture& FieldOnCard(const breathing::MotionField& field, int component);
  void SetPressed(const PressedTissue* pressed);
  void SetLight(const Light& light, const ShadowMap* shadows);
  void SetCuts(std::span<const CutPlane> cuts);
  void SetSurfaces(const FragmentLists& surfaces);

  GlContext context_;
  ComputeProgram program_{RayShaderSource()};
  bool has_patient_ = false;
  Texture hu_, slopes_, classes_, distances_, pressed_, shadows_;
  std::vector<StoredField> fields_;  ///< The one used last at the end.
  Buffer integral_, value_, cuts_, first_, fragments_, pixels_;
};

Renderer::Renderer(DriverKind kind) : context_(kind) {
  constexpr std::array kNames{"hu",          "slopes",         "classes",     "distances",
                              "pressed",     "shadow_heights", "component_0", "component_1",
                              "component_2", "component_3"};
  for (std::size_t unit = 0; unit < kNames.size(); ++unit) {
    program_.Set(kNames[unit], static_cast<int>(unit));
  }
  context_.Check("its shader");
}

void Renderer::LoadPatient(const VolumeScene& scene) {
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
  program_.Set("ct_size", grid.size);
  program_.Set("index_linear", Eigen::Matrix3f(index_from_ct.linear()));
  program_.Set("index_offset", Eigen::Vector3f(index_from_ct.translation()));
  program_.Set("ct_from_grid", Eigen::Matrix3f(grid.direction.cast<float>()));
  program_.Set("steepest_hu_per_mm", SlopeVolume::kSteepest);
  program_.Set("surface_hu_per_mm", kSurfaceHuPerMm);
  program_.Set("lowest_hu", table.lowest_hu);
  program_.Set("table_count", table.count);
  program_.Set("has_classes", has_classes ? 1 : 0);
  program_.Set("dark", kDark);
  context_.Check("the CT");
  has_patient_ = true;
}

void Renderer::SetCamera(const Camera& camera) {
  program_.Set("image_size", Eigen::Array3i(camera.width_px, camera.height_px, 1));
  program_.Set("focal_px", Eigen::Vector2f(camera.focal_px.cast<float>()));
  program_.Set("centre_px", Eigen::Vector2f(camera.centre_px.cast<float>()));
  program_.Set("ct_from_camera",
               Eigen::Matrix3f(camera.camera_from_ct.linear().transpose().cast<float>()));
  program_.Set("eye_mm", Eigen::Vector3f(camera.EyeInCtMm().cast<float>()));
}

void Renderer::SetBlocks(const VisibleBlocks& blocks) {
  program_.Set("has_volume", blocks.nothing_visible() ? 0 : 1);
  if (blocks.nothing_visible()) return;
  distances_.Set(TexelFormat::kIndex, blocks.size(), blocks.distances());
  program_.Set("blocks_size", blocks.size());
  program_.Set("blocks_linear", Eigen::Matrix3f(blocks.blocks_from_ct().linear()));
  program_.Set("blocks_offset", Eigen::Vector3f(blocks.blocks_from_ct().translation()));
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
  std::vector<std::int16_t> packed;
  packed.reserve(3 * field.nodes().num_voxels());
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      const auto row = field.StoredRow(component, j, k);
      packed.insert(packed.end(), row.begin(), row.end());
    }
  }
  if (fields_.size() == kMostFields) {
    std::rotate(fields_.begin(), fields_.begin() + 1, fields_.end());
  } else {
    fields_.emplace_back();
  }
  StoredField& stored = fields_.back();
  stored.field = field.identity();
  stored.component = component;
  stored.texture.Set(TexelFormat::kShort3, size, packed.data());
  return stored.texture;
}

void Renderer::SetBreath(const breathing::MotionMap* motion, const WarpSettings& warp) {
  const bool moves = motion != nullptr && motion->moves();
  program_.Set("num_components", moves ? motion->weights().count : 0);
  if (!moves) return;
  const breathing::MotionField& field = motion->field();
  const Eigen::Affine3f nodes_from_ct = field.nodes().index_from_ct().cast<float>();
  program_.Set("nodes_size", field.nodes().size);
  program_.Set("nodes_linear", Eigen::Matrix3f(nodes_from_ct.linear()));
  program_.Set("nodes_offset", Eigen::Vector3f(nodes_from_ct.translation()));
  program_.Set("most_iterations", warp.max_iterations);
  program_.Set("tolerance_mm", static_cast<float>(warp.tolerance_mm));
  Eigen::Vector4f scale = Eigen::Vector4f::Zero();
  for (int n = 0; n < motion->weights().count; ++n) {
    const int component = motion->weights().component[static_cast<std::size_t>(n)];
    scale[n] = motion->weights().weight[static_cast<std::size_t>(n)] *
               static_cast<float>(32767.0 * field.MmPerUnit(component));
    FieldOnCard(field, component).Bind(kFirstComponent + static_cast<unsigned>(n));
  }
  program_.Set("component_scale", scale);
}

void Renderer::SetPressed(const PressedTissue* pressed) {
  const bool is_pressed = pressed != nullptr && !pressed->empty();
  program_.Set("is_pressed", is_pressed ? 1 : 0);
  if (!is_pressed) return;
  pressed_.Set(TexelFormat::kFloat3, pressed->size(), pressed->knots().data());
  program_.Set("pressed_size", pressed->size());
  program_.Set("pressed_low_mm", Eigen::Vector3f(pressed->box_in_ct_mm().min()));
  program_.Set("pressed_high_mm", Eigen::Vector3f(pressed->box_in_ct_mm().max()));
  program_.Set("pressed_spacing_mm", pressed->spacing_mm());
}

void Renderer::SetLight(const Light& light, const ShadowMap* shadows) {
  program_.Set("to_lamp", light.to_lamp);
  program_.Set("light", Eigen::Vector4f(light.ambient, light.diffuse, light.fill, light.gloss));
  program_.Set("has_shadows", shadows == nullptr ? 0 : 1);
  if (shadows == nullptr) return;
  constexpr int kSize = ShadowMap::kSize;
  shadows_.Set(TexelFormat::kFloat, Eigen::Array3i(kSize, kSize, 1), shadows->height_mm().data());
  program_.Set("shadow_size", kSize);
  program_.Set("lamp_from_ct", shadows->lamp_from_ct());
  program_.Set("shadow_low_mm", shadows->low_mm());
  program_.Set("shadow_cell_mm", shadows->mm_per_cell());
  program_.Set("shadow_clear_mm", ShadowMap::kClearMm);
}

void Renderer::SetCuts(std::span<const CutPlane> cuts) {
  std::vector<Eigen::Vector4f> planes;
  for (const CutPlane& cut : cuts) planes.emplace_back(cut.coeffs().cast<float>());
  program_.Set("num_cuts", static_cast<int>(planes.size()));
  cuts_.Set(planes.data(), planes.size() * sizeof(Eigen::Vector4f));
}

void Renderer::SetSurfaces(const FragmentLists& surfaces) {
  std::vector<ShaderFragment> fragments;
  fragments.reserve(surfaces.fragments.size());
  for (const Fragment& met : surfaces.fragments) {
    fragments.push_back({met.distance_mm, met.opacity, met.colour[0], met.colour[1], met.colour[2],
                         met.is_tool ? 1.0F : 0.0F});
  }
  first_.Set(surfaces.first.data(), surfaces.first.size() * sizeof(surfaces.first[0]));
  fragments_.Set(fragments.data(), fragments.size() * sizeof(ShaderFragment));
}

void Renderer::Cast(const VolumeScene& scene, const RaySettings& settings, const Camera& camera,
                    const FragmentLists& surfaces, std::vector<std::uint8_t>& rgba) {
  if (!has_patient_) LoadPatient(scene);
  SetCamera(camera);
  SetBlocks(*scene.blocks);
  SetBreath(scene.motion, settings.warp);
  SetPressed(scene.pressed);
  SetLight(scene.light, scene.shadows);
  SetCuts(scene.cuts);
  SetSurfaces(surfaces);
  program_.Set("step_mm", static_cast<float>(settings.step_mm));
  program_.Set("tool_shine", static_cast<float>(settings.tool_shine));
  program_.Set("is_maximum", settings.projection == Projection::kMaximum ? 1 : 0);
  program_.Set("window_hu", Eigen::Vector2f(static_cast<float>(settings.window.low_hu),
                                            static_cast<float>(settings.window.high_hu)));
  rgba.resize(4 * static_cast<std::size_t>(camera.width_px) *
              static_cast<std::size_t>(camera.height_px));
  pixels_.Set(nullptr, rgba.size());
  hu_.Bind(kHu);
  slopes_.Bind(kSlopes);
  classes_.Bind(kClasses);
  distances_.Bind(kDistances);
  pressed_.Bind(kPressed);
  shadows_.Bind(kShadows);
  integral_.Bind(kIntegral);
  value_.Bind(kValue);
  cuts_.Bind(kCuts);
  first_.Bind(kFirst);
  fragments_.Bind(kFragments);
  pixels_.Bind(kPixels);
  context_.Check("an image's data");
  program_.Run((camera.width_px + kGroup - 1) / kGroup, (camera.height_px + kGroup - 1) / kGroup);
  pixels_.Read(rgba.data(), rgba.size());
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
    thread_.Run([&] { renderer_.reset(); });
  }
  ShaderRays(const ShaderRays&) = delete;
  ShaderRays& operator=(const ShaderRays&) = delete;

  std::string name() const override { return name_; }
  void Cast(const VolumeScene& scene, const RaySettings& settings, const Camera& camera,
            const FragmentLists& surfaces, std::vector<std::uint8_t>& rgba) override {
    thread_.Run([&] { renderer_->Cast(scene, settings, camera, surfaces, rgba); });
  }

 private:
  std::string name_;
  std::optional<Renderer> renderer_;
  JobThread thread_;
};

}  // namespace

std::unique_ptr<RayDevice> MakeShaderRays(DriverKind kind) {
  return std::make_unique<ShaderRays>(kind);
}

}  // namespace acus::graphics
