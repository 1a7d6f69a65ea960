#include "acus/scene/effects/view_3d/view_3d.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/scene/effects/ports.h"
#include "acus/scene/effects/view_3d/camera_path.h"
#include "acus/scene/effects/view_3d/patient_surfaces.h"
#include "acus/scene/effects/view_3d/tissue_under_tools.h"

namespace acus::effects {
namespace {

using nlohmann::json;

constexpr Port<image::ColourImage> kView{"view"};
constexpr ports::FilePort kCameraPath{"camera path"};

/// @param scene  Outlives the view.
volume_rendering::PatientInView PatientOf(const View3dSettings& settings, const PortValues& scene,
                                          const RunContext& context) {
  volume_rendering::PatientInView patient;
  if (settings.maximum_projection || !settings.layers.empty()) {
    patient.ct = {std::shared_ptr<const void>(), &scene.Get(ports::kCt)};
  }
  if (!settings.maximum_projection) {
    for (const auto& layer : settings.layers) {
      patient.layers.push_back({layer.preset, layer.opacity});
    }
  }
  if (!settings.surfaces.empty()) {
    patient.surfaces = SurfacesOf(settings, scene.Get(ports::kLabels), context);
  }
  if (const volume::LabelMap* labels = scene.Find(ports::kLabels)) {
    patient.labels = {std::shared_ptr<const void>(), labels};
  }
  patient.field = scene.Find(ports::kMotionField);
  return patient;
}

bool IsMaximumProjection(const json& settings) {
  return settings.at("projection") == "maximum";
}

/// True if a layer is limited to some tissues: it needs the label map.
bool HasTissueLayer(const json& settings) {
  if (IsMaximumProjection(settings)) return false;  // It shows no layer.
  return std::ranges::any_of(settings.at("layers"), [](const json& layer) {
    const auto file =
        volume_rendering::FindTransferFunction(layer.at("preset").get<std::string>(), {});
    return !volume_rendering::ReadTransferFunction(file).tissues.empty();
  });
}

volume_rendering::ViewSettings LookOf(const View3dSettings& settings) {
  volume_rendering::ViewSettings look;
  look.rays.step_mm = settings.step_mm;
  look.rays.warp.max_iterations = settings.inverse_iterations;
  look.rays.warp.lattice_mm = settings.warp_tolerance_mm;
  look.rays.pixel_tolerance = settings.pixel_tolerance;
  look.rays.tool_shine = settings.tool_shine;
  if (settings.maximum_projection) {
    look.rays.projection = volume_rendering::Projection::kMaximum;
    look.rays.window = {settings.window_hu[0], settings.window_hu[1]};
  }
  look.supersampling = settings.supersampling;
  look.tool_shadows = settings.shadows;
  return look;
}

volume_rendering::Camera CameraOf(const View3dSettings& settings, const Eigen::AlignedBox3d& box) {
  const volume_rendering::ImageSize size{settings.width_px, settings.height_px};
  if (!settings.eye_in_ct_mm) {
    return LookAt(volume_rendering::ViewFrom(settings.from, box, size, settings.view_angle_deg),
                  size);
  }
  return LookAt({.eye_in_ct_mm = *settings.eye_in_ct_mm,
                 .focus_in_ct_mm = *settings.focus_in_ct_mm,
                 .up_in_ct = settings.up_in_ct,
                 .view_angle_deg = settings.view_angle_deg},
                size);
}

/// Two images of the same size, side by side.
void PutBeside(const image::ColourImage& left, const image::ColourImage& right,
               image::ColourImage& out) {
  out.Resize(left.width + right.width, left.height);
  const auto row_bytes = static_cast<std::ptrdiff_t>(3) * left.width;
  for (int row = 0; row < left.height; ++row) {
    auto to = out.rgb.begin() + 2 * row * row_bytes;
    to = std::copy_n(left.rgb.begin() + row * row_bytes, row_bytes, to);
    std::copy_n(right.rgb.begin() + row * row_bytes, row_bytes, to);
  }
}

class ViewStage final : public ImageStage {
 public:
  ViewStage(const View3dSettings& settings, const PortValues& scene, const RunContext& context)
      : settings_(settings),
        view_(PatientOf(settings, scene, context), LookOf(settings)),
        camera_(CameraOf(settings, view_.box_in_ct_mm())),
        num_threads_(context.num_threads) {
    if (!settings.camera_path.empty()) path_ = CameraPath::Read(settings.camera_path);
  }

  Activity Render(const ImageMoment& moment, const PortValues& ports, EffectPixels& out) override {
    if (!path_ && !HasChanged(moment.changes)) return Activity::kUnchanged;
    if (path_) {
      const volume_rendering::ImageSize size{settings_.width_px, settings_.height_px};
      camera_ = LookAt(path_->At(moment.session_s, view_.box_in_ct_mm(), size), size);
    }
    volume_rendering::ViewMoment seen;
    seen.path_in_ct_mm = moment.tip_path_in_ct_mm;
    seen.motion = moment.breath;
    if (moment.needle != nullptr) {
      seen.needle = *moment.needle;
      const Eigen::Vector3d& tip_mm = moment.needle->tip_in_ct_mm;
      // The needle's force on the tissue: the opposite force, on the hand, would be drawn inside
      // the shaft.
      seen.arrow = {tip_mm, tip_mm - settings_.force_arrow_mm_per_n * moment.needle_force_in_ct_n};
    }
    if (settings_.probe && moment.probe_valid) {
      seen.probe.emplace();
      seen.probe->ct_from_probe = moment.ct_from_probe;
      seen.probe->probe = &ports.Get(ports::kProbePreset);
      const image::GrayImage* b_mode = ports.Find(ports::kBMode);
      if (b_mode != nullptr && !b_mode->pixels.empty()) seen.probe->b_mode = b_mode;
    }
    const volume_rendering::PressedTissue pressed = PressedAt(moment, ports);
    seen.pressed = &pressed;
    view_.Render(camera_, seen, rendered_, num_threads_);
    if (!settings_.beside_rest) {
      std::swap(rendered_.colour, out.colour);
      return Activity::kActive;
    }
    seen.motion = nullptr;
    seen.pressed = nullptr;
    view_.Render(camera_, seen, at_rest_, num_threads_);
    PutBeside(at_rest_.colour, rendered_.colour, out.colour);
    return Activity::kActive;
  }

  bool NeedsRestMap(const ImageChanges& changes) const override {
    return settings_.pressed && (path_ || HasChanged(changes));
  }

  bool ShowsEvents() const override { return settings_.event_stills; }

 private:
  volume_rendering::PressedTissue PressedAt(const ImageMoment& moment,
                                            const PortValues& ports) const {
    const slicing::RestMap* rest = settings_.pressed ? ports.Find(ports::kRestMap) : nullptr;
    if (rest == nullptr) return {};
    ToolsOnTissue tools;
    if (moment.needle != nullptr) tools.needle = *moment.needle;
    if (moment.probe_valid) tools.ct_from_probe = moment.ct_from_probe;
    tools.probe = ports.Find(ports::kProbePreset);
    const PressedDetail detail{.num_threads = num_threads_};
    return PressedIn(*rest, moment.breath, ReachOf(tools), detail);
  }
  bool HasChanged(const ImageChanges& changes) const {
    return changes.breath || changes.images || (settings_.pressed && changes.tissue) ||
           (settings_.needle && changes.needle) ||
           (settings_.force_arrow_mm_per_n > 0.0 && changes.force) ||
           (settings_.probe && changes.probe);
  }

  View3dSettings settings_;
  volume_rendering::PatientView view_;
  volume_rendering::Camera camera_;
  int num_threads_;
  std::optional<CameraPath> path_;
  volume_rendering::ViewImage rendered_;
  volume_rendering::ViewImage at_rest_;
};

class LoadedView final : public LoadedEffect {
 public:
  explicit LoadedView(View3dSettings settings) : settings_(std::move(settings)) {}

  std::unique_ptr<ImageStage> NewImageStage(const PortValues& scene,
                                            const RunContext& context) const override {
    return std::make_unique<ViewStage>(settings_, scene, context);
  }

 private:
  View3dSettings settings_;
};

class View3dEffect final : public Effect {
 public:
  std::string_view key() const override { return "view_3d"; }
  std::string_view title() const override { return "The patient in three dimensions"; }

  json Schema() const override {
    return json::parse(R"json({
      "type": "object",
      "additionalProperties": false,
      "description": "The patient in three dimensions, with needle, probe and its image: a video, view_3d.mp4",
      "properties": {
        "width_px": {"type": "integer", "minimum": 16, "maximum": 4096, "default": 800, "description": "Of the image, pixels"},
        "height_px": {"type": "integer", "minimum": 16, "maximum": 4096, "default": 600, "description": "Of the image, pixels"},
        "rate_hz": {"type": "number", "exclusiveMinimum": 0, "maximum": 200, "default": 10, "description": "Images per second of session time; at moments of the other images, so the nearest fraction of image_rate_hz"},
        "camera": {
          "type": "object",
          "additionalProperties": false,
          "default": {},
          "description": "Where the view is taken from",
          "properties": {
            "from": {"enum": ["anterior", "posterior", "left", "right", "superior", "inferior", "oblique"], "default": "oblique", "description": "Side of the patient; all of him is in the image. oblique: from in front, his right and above"},
            "eye_mm": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}, "description": "Eye in CT space, mm; in place of `from`"},
            "focus_mm": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}, "description": "What it looks at, CT space, mm"},
            "up": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}, "default": [0, 0, 1], "description": "Direction that is up in the image, CT space"},
            "view_angle_deg": {"type": "number", "minimum": 1, "maximum": 120, "default": 30, "description": "Over the height of the image, degrees"}
          }
        },
        "camera_path": {"type": "string", "description": "Path of the camera (acus-camera-path), in place of `camera`: camera_paths/turntable.json, or a file"},
        "beside": {"enum": ["nothing", "rest"], "default": "nothing", "description": "rest: on the left the patient at rest, without breath and not pressed; on the right as he is"},
        "event_stills": {"type": "boolean", "default": true, "description": "A still of every puncture and bone contact for the report, with the path of the needle's tip"},
        "projection": {"enum": ["emission", "maximum"], "default": "emission", "description": "How the CT becomes an image. emission: by its `layers`; maximum: maximum intensity projection, white by the largest HU along each ray, see window_hu; layers are not used then. Opaque surfaces hide what is behind them: `surfaces`: [] shows the CT alone"},
        "window_hu": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number", "minimum": -1024, "maximum": 3071}, "default": [100, 1000], "description": "Of the maximum intensity projection, HU: transparent up to the first, white from the second, linear between"},
        "layers": {
          "type": "array",
          "default": [],
          "description": "What volume rendering shows of the CT",
          "items": {
            "type": "object",
            "additionalProperties": false,
            "required": ["preset"],
            "properties": {
              "preset": {"type": "string", "description": "Colour and opacity by Hounsfield units: bone, liver, muscle, skin, soft_tissue, vessels, or the path of a file of format acus-transfer-function"},
              "opacity": {"type": "number", "minimum": 0, "maximum": 1, "default": 1, "description": "1: as the preset says; 0: not shown"}
            }
          }
        },
        "surfaces": {
          "type": "array",
          "default": [{"tissue": "skin", "opacity": 0.25}, {"tissue": "bone"}, {"tissue": "liver", "opacity": 0.6}, {"tissue": "kidney"}, {"tissue": "vessel"}, {"tissue": "lesion"}],
          "description": "Tissues of the label map that are shown as surfaces; those that the patient does not have are omitted",
          "items": {
            "type": "object",
            "additionalProperties": false,
            "required": ["tissue"],
            "properties": {
              "tissue": {"type": "string", "description": "Name of a label; skin: the outer border of all that is labelled"},
              "opacity": {"type": "number", "minimum": 0, "maximum": 1, "default": 1, "description": "1 hides what is behind, 0 shows nothing"},
              "colour": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "integer", "minimum": 0, "maximum": 255}, "description": "Red, green, blue, 0 to 255; the standard one of the tissue if not given"}
            }
          }
        },
        "surface_grid_mm": {"type": "number", "minimum": 0.5, "maximum": 10, "default": 1.5, "description": "Detail of the surfaces, mm"},
        "needle": {"type": "boolean", "default": true, "description": "Show the needle"},
        "force_arrow_mm_per_n": {"type": "number", "minimum": 0, "maximum": 1000, "default": 0, "description": "Show the force of the needle on the tissue as an arrow from its tip, this long for 1 N, if there is effects/needle_force; 0: no arrow"},
        "probe": {"type": "boolean", "default": true, "description": "Show the probe and the plane that it sees"},
        "picture": {"type": "boolean", "default": true, "description": "Show the B-mode in that plane, if there is effects/ultrasound"},
        "pressed": {"type": "boolean", "default": true, "description": "Show the tissue as needle, probe or finger press it, if effects/tissue says that images show it"},
        "shadows": {"type": "boolean", "default": true, "description": "Needle and probe throw shadows on the patient"},
        "tool_shine": {"type": "number", "minimum": 0, "maximum": 1, "default": 0.35, "description": "What is seen of a tool behind tissue; 0: what the tissue lets through"},
        "supersampling": {"enum": [1, 2, 4], "default": 2, "description": "A pixel is the mean of this many each way: smooth edges"},
        "step_mm": {"type": "number", "minimum": 0.05, "maximum": 20, "default": 1, "description": "Distance of the samples on a ray, mm"},
        "inverse_iterations": {"type": "integer", "minimum": 1, "maximum": 1000, "default": 5, "description": "Of a patient who breathes: at most this many iterations to find where a sample was at rest"},
        "warp_tolerance_mm": {"type": "number", "minimum": 0, "maximum": 10, "default": 0.15, "description": "Of a patient who breathes, accuracy against time: where it is right to this, samples take the inverse from between knots about 6 mm apart; 0: every sample inverts for itself, at twice the time, mm"},
        "pixel_tolerance": {"type": "number", "minimum": 0, "maximum": 1, "default": 0, "description": "Accuracy against time: pixels between others that differ by no more than this share of full scale are interpolated; 0: every pixel has its ray"}
      }
    })json");
  }

  std::vector<PathSetting> Paths() const override {
    return {{"camera_path", PathKind::kPreset, kCameraPath}};
  }

  void Check(const json& settings, const std::string& where) const override {
    const json& camera = settings.at("camera");
    ACUS_REQUIRE(camera.contains("eye_mm") == camera.contains("focus_mm"), where,
                 "/camera: eye_mm and focus_mm go together; give both, or `from`");
    const json& window = settings.at("window_hu");
    ACUS_REQUIRE(window[0] < window[1], where, "/window_hu: from ", window[0].get<double>(), " to ",
                 window[1].get<double>(),
                 " HU; the first must be below the second, as in [100, 1000]");
    ACUS_REQUIRE(IsMaximumProjection(settings) || !settings.at("layers").empty() ||
                     !settings.at("surfaces").empty(),
                 where,
                 ": there is nothing to show; give a layer of the CT, or a surface, or "
                 "\"projection\": \"maximum\"");
  }

  void ResolveFiles(json& settings, const std::filesystem::path& folder) const override {
    if (!settings.contains("layers") || !settings["layers"].is_array()) return;
    for (json& layer : settings["layers"]) {
      if (!layer.is_object() || !layer.contains("preset") || !layer["preset"].is_string()) continue;
      const auto name = layer["preset"].get<std::string>();
      const auto file = volume_rendering::FindTransferFunction(name, folder);
      if (name != file.stem()) layer["preset"] = file.lexically_normal().string();
    }
  }

  std::optional<StageDeclaration> ImageStageOf(const json& settings) const override {
    StageDeclaration stage{.name = "view in 3D", .reads = {}, .writes = {kView}};
    const auto add = [](std::vector<PortRef>& to, std::initializer_list<PortRef> ports) {
      to.insert(to.end(), ports);
    };
    if (IsMaximumProjection(settings) || !settings.at("layers").empty()) {
      add(stage.reads, {ports::kCt});
    }
    if (!settings.at("surfaces").empty() || HasTissueLayer(settings)) {
      add(stage.reads, {ports::kLabels});
    }
    if (settings.at("needle")) {
      add(stage.reads, {ports::kNeedle, ports::kNeedlePreset});
      add(stage.optional_reads, {ports::kShape});
      if (settings.at("force_arrow_mm_per_n") > 0.0) add(stage.optional_reads, {ports::kForce});
    }
    if (settings.at("probe")) {
      add(stage.reads, {ports::kProbe, ports::kProbePreset});
      if (settings.at("picture")) add(stage.optional_reads, {ports::kBMode});
    }
    if (settings.contains("camera_path")) add(stage.reads, {kCameraPath});
    add(stage.optional_reads, {ports::kBreath});
    if (settings.at("pressed")) add(stage.optional_reads, {ports::kRestMap});
    return stage;
  }

  ImageTiming TimingOf(const json& settings) const override {
    return {.rate_hz = settings.at("rate_hz"), .is_live = false};
  }

  std::unique_ptr<const LoadedEffect> Load(const json& settings, const PortValues& /*scene*/,
                                           RunContext& context) const override {
    View3dSettings view = ReadView3dSettings(settings);
    if (!view.maximum_projection) {
      for (const auto& layer : view.layers) {
        context.provenance.AddInput(volume_rendering::FindTransferFunction(layer.preset, {}));
      }
    }
    if (!view.camera_path.empty()) {
      CameraPath::Read(view.camera_path);  // Errors of the file are reported before anything runs.
      context.provenance.AddInput(view.camera_path);
    }
    return std::make_unique<LoadedView>(std::move(view));
  }
};

}  // namespace

const Effect& View3d() {
  static const View3dEffect effect;
  return effect;
}

}  // namespace acus::effects
