#include "acus/scene/effects/planes/planes.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/imaging/slicing/slab.h"
#include "acus/scene/effects/planes/plane_poses.h"
#include "acus/scene/effects/ports.h"

namespace acus::effects {
namespace {

using nlohmann::json;

constexpr Port<image::GrayImage> kPlanes{"planes"};

struct PlaneSettings {
  std::vector<PatientPlane> planes;
  image::ImageGeometry geometry;  ///< One plane; its centre is the point that the plane contains.
  slicing::SlabSettings slab;
  std::optional<Eigen::Vector3d> centre_in_ct_mm;  ///< Nothing: the needle's tip.
  bool needle = true;
};

PlaneSettings ReadPlaneSettings(const json& object) {
  PlaneSettings settings;
  for (const json& name : object.at("planes")) {
    settings.planes.push_back(PatientPlaneOf(name.get<std::string>()));
  }
  const double mm_per_px = object.at("mm_per_px");
  settings.geometry = {.width_px = object.at("width_px"),
                       .height_px = object.at("height_px"),
                       .lateral_mm_per_px = mm_per_px,
                       .axial_mm_per_px = mm_per_px};
  settings.geometry.depth_of_top_row_mm = -0.5 * mm_per_px * (settings.geometry.height_px - 1);
  settings.slab.thickness_mm = object.at("thickness_mm");
  settings.slab.value =
      object.at("slab") == "maximum" ? slicing::SlabValue::kMaximum : slicing::SlabValue::kMean;
  settings.slab.window = {object.at("window").at("centre_hu"), object.at("window").at("width_hu")};
  if (object.contains("centre_mm")) {
    const json& place = object.at("centre_mm");
    settings.centre_in_ct_mm = Eigen::Vector3d(place[0], place[1], place[2]);
  }
  settings.needle = object.at("needle");
  return settings;
}

/// Columns of the layout: one row of up to three planes, else two rows.
int ColumnsOf(std::size_t planes) {
  return planes == 4 ? 2 : static_cast<int>(planes);
}

class PlanesStage final : public ImageStage {
 public:
  PlanesStage(const PlaneSettings& settings, const volume::CtVolume& ct, int num_threads)
      : settings_(settings), num_threads_(num_threads) {
    for (std::size_t n = 0; n < settings.planes.size(); ++n) {
      slabs_.emplace_back(ct, settings.geometry, settings.slab);
    }
    const volume::Geometry& grid = ct.geometry;
    middle_in_ct_mm_ = grid.ct_from_index() * (0.5 * (grid.size - 1).cast<double>()).matrix();
  }

  Activity Render(const ImageMoment& moment, const PortValues& ports, EffectPixels& out) override {
    if (!HasChanged(moment.changes)) return Activity::kUnchanged;
    std::optional<image::NeedleInImage> needle;
    Eigen::Vector3d through = settings_.centre_in_ct_mm.value_or(middle_in_ct_mm_);
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();
    if (moment.needle != nullptr) {
      const image::NeedleInImage& seen = *moment.needle;
      const bool bent = seen.shape.num_points >= 2;
      const Eigen::Vector3d tip = bent ? seen.shape.At(0) : seen.tip_in_ct_mm;
      axis = bent ? Eigen::Vector3d(tip - seen.shape.At(1)).normalized() : seen.axis_in_ct;
      if (!settings_.centre_in_ct_mm) through = tip;
      if (settings_.needle) needle = seen;
    }
    const int columns = ColumnsOf(slabs_.size());
    const int rows = (static_cast<int>(slabs_.size()) + columns - 1) / columns;
    const int width = settings_.geometry.width_px;
    const int height = settings_.geometry.height_px;
    out.gray.Resize(columns * width, rows * height);
    for (std::size_t n = 0; n < slabs_.size(); ++n) {
      slabs_[n].Render(PoseOf(settings_.planes[n], through, axis), needle, plane_, num_threads_,
                       ports.Find(ports::kRestMap));
      MarkMiddle(plane_);
      const int column = static_cast<int>(n) % columns;
      const int row = static_cast<int>(n) / columns;
      for (int r = 0; r < height; ++r) {
        std::copy_n(plane_.pixels.begin() + static_cast<std::ptrdiff_t>(r) * width, width,
                    out.gray.pixels.begin() +
                        static_cast<std::ptrdiff_t>(row * height + r) * out.gray.width +
                        static_cast<std::ptrdiff_t>(column) * width);
      }
    }
    return Activity::kActive;
  }

  bool NeedsRestMap(const ImageChanges& changes) const override { return HasChanged(changes); }

  std::optional<ImageText> Text() const override {
    ImageText text;
    for (const PatientPlane plane : settings_.planes) {
      text.above += (text.above.empty() ? "" : ", ") + std::string(TitleOf(plane));
    }
    if (settings_.slab.thickness_mm > 0.0) {
      text.below = RoundedText(settings_.slab.thickness_mm, 3) + " mm, " +
                   (settings_.slab.value == slicing::SlabValue::kMean ? "mean" : "maximum");
    }
    return text;
  }

 private:
  bool HasChanged(const ImageChanges& changes) const {
    return changes.tissue || (NeedleMatters() && changes.needle);
  }
  bool NeedleMatters() const { return settings_.needle || !settings_.centre_in_ct_mm; }

  /// Short lines at the borders that point to the point that the planes have in common, and a rim.
  static void MarkMiddle(image::GrayImage& plane) {
    constexpr int kMarkPx = 8;
    constexpr std::uint8_t kMark = 200;
    constexpr std::uint8_t kRim = 70;
    const auto set = [&](int column, int row, std::uint8_t grey) {
      plane.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(plane.width) +
                   static_cast<std::size_t>(column)] = grey;
    };
    for (int c = 0; c < plane.width; ++c) {
      set(c, 0, kRim);
      set(c, plane.height - 1, kRim);
    }
    for (int r = 0; r < plane.height; ++r) {
      set(0, r, kRim);
      set(plane.width - 1, r, kRim);
    }
    for (int n = 0; n < kMarkPx; ++n) {
      set(n, plane.height / 2, kMark);
      set(plane.width - 1 - n, plane.height / 2, kMark);
      set(plane.width / 2, n, kMark);
      set(plane.width / 2, plane.height - 1 - n, kMark);
    }
  }

  PlaneSettings settings_;
  int num_threads_;
  std::deque<slicing::SlabRenderer> slabs_;
  Eigen::Vector3d middle_in_ct_mm_;
  image::GrayImage plane_;
};

class LoadedPlanes final : public LoadedEffect {
 public:
  explicit LoadedPlanes(PlaneSettings settings) : settings_(std::move(settings)) {}

  std::unique_ptr<ImageStage> NewImageStage(const PortValues& scene,
                                            const RunContext& context) const override {
    return std::make_unique<PlanesStage>(settings_, scene.Get(ports::kCt), context.num_threads);
  }

 private:
  PlaneSettings settings_;
};

class PlanesEffect final : public Effect {
 public:
  std::string_view key() const override { return "planes"; }
  std::string_view title() const override { return "CT planes"; }

  json Schema() const override {
    return json::parse(R"json({
      "type": "object",
      "additionalProperties": false,
      "description": "Slices or slabs of the CT through the needle's tip, as breath and tools have moved the tissue: shown live, and a video, planes.mp4",
      "properties": {
        "planes": {
          "type": "array",
          "minItems": 1,
          "maxItems": 4,
          "default": ["axial", "coronal", "sagittal", "oblique"],
          "description": "Which, in this order; four are two rows of two",
          "items": {"enum": ["axial", "coronal", "sagittal", "oblique"], "description": "oblique: along the needle, which points downwards, as near to axial as it can"}
        },
        "width_px": {"type": "integer", "minimum": 32, "maximum": 1024, "default": 256, "description": "Of each plane, pixels"},
        "height_px": {"type": "integer", "minimum": 32, "maximum": 1024, "default": 256, "description": "Of each plane, pixels"},
        "mm_per_px": {"type": "number", "minimum": 0.05, "maximum": 10, "default": 0.8, "description": "Size of a pixel, mm"},
        "thickness_mm": {"type": "number", "minimum": 0, "maximum": 200, "default": 0, "description": "Of a slab; 0: one slice, mm"},
        "slab": {"enum": ["mean", "maximum"], "default": "mean", "description": "What a slab shows of the HU along its normal"},
        "window": {
          "type": "object",
          "additionalProperties": false,
          "default": {},
          "description": "Which HU are shown as which grey",
          "properties": {
            "centre_hu": {"type": "number", "minimum": -1024, "maximum": 4000, "default": 40, "description": "Level: HU of middle grey. Soft tissue 40, lung -600, bone 400"},
            "width_hu": {"type": "number", "minimum": 1, "maximum": 8000, "default": 400, "description": "Window: HU from black to white. Soft tissue 400, lung 1500, bone 1800"}
          }
        },
        "centre_mm": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}, "description": "Place that all planes go through, x y z in CT space (LPS, mm), in place of the needle's tip"},
        "needle": {"type": "boolean", "default": true, "description": "Draw the needle at 4000 HU"},
        "rate_hz": {"type": "number", "exclusiveMinimum": 0, "maximum": 200, "default": 10, "description": "Images per second of session time; at moments of the other images, so the nearest fraction of image_rate_hz"}
      }
    })json");
  }

  void Check(const json& settings, const std::string& where) const override {
    std::vector<json> seen;
    for (const json& plane : settings.at("planes")) {
      ACUS_REQUIRE(std::ranges::find(seen, plane) == seen.end(), where, "/planes: ", plane,
                   " is there twice; give each plane once");
      seen.push_back(plane);
    }
  }

  std::optional<StageDeclaration> ImageStageOf(const json& settings) const override {
    StageDeclaration stage{.name = "CT planes", .reads = {ports::kCt}, .writes = {kPlanes}};
    stage.optional_reads = {ports::kRestMap};
    if (settings.at("needle") || !settings.contains("centre_mm")) {
      stage.reads.insert(stage.reads.end(), {ports::kNeedle, ports::kNeedlePreset});
      stage.optional_reads.emplace_back(ports::kShape);
    }
    return stage;
  }

  ImageTiming TimingOf(const json& settings) const override {
    return {.rate_hz = settings.at("rate_hz")};
  }

  std::unique_ptr<const LoadedEffect> Load(const json& settings, const PortValues& /*scene*/,
                                           RunContext& /*context*/) const override {
    return std::make_unique<LoadedPlanes>(ReadPlaneSettings(settings));
  }
};

}  // namespace

const Effect& Planes() {
  static const PlanesEffect effect;
  return effect;
}

}  // namespace acus::effects
