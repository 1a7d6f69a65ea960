#include "acus/scene/effects/fluoroscopy/fluoroscopy_effect.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/imaging/fluoroscopy/fluoroscope.h"
#include "acus/scene/effects/ports.h"

namespace acus::effects {
namespace {

using nlohmann::json;

constexpr ports::FilePort kCArm{"C-arm"};
constexpr Port<image::GrayImage> kFluoroscopy{"fluoroscopy image"};

/// "LAO 30  CRAN 10": the detector towards the patient's left and head.
std::string AnglesText(const fluoroscopy::CArmPose& pose) {
  const auto degrees = [](double rad) {
    return static_cast<int>(std::lround(std::abs(rad) * 180.0 / std::numbers::pi));
  };
  return Message(pose.lao_rad < 0.0 ? "RAO " : "LAO ", degrees(pose.lao_rad),
                 pose.cranial_rad < 0.0 ? "  CAUD " : "  CRAN ", degrees(pose.cranial_rad));
}

fluoroscopy::CArmPose PoseOf(const json& settings, const volume::Geometry& ct) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  fluoroscopy::CArmPose pose{
      .isocentre_in_ct_mm = ct.ct_from_index() * (0.5 * (ct.size - 1).cast<double>()).matrix(),
      .lao_rad = kRadians * settings.at("lao_deg").get<double>(),
      .cranial_rad = kRadians * settings.at("cranial_deg").get<double>()};
  if (settings.contains("isocentre_mm")) {
    const json& place = settings.at("isocentre_mm");
    pose.isocentre_in_ct_mm = Eigen::Vector3d(place[0], place[1], place[2]);
  }
  return pose;
}

class FluoroscopyStage final : public ImageStage {
 public:
  FluoroscopyStage(const volume::CtVolume& ct, const fluoroscopy::CArm& c_arm,
                   const fluoroscopy::CArmPose& pose, bool shows_needle, int num_threads)
      : fluoroscope_(ct, c_arm, pose, num_threads),
        pose_(pose),
        shows_needle_(shows_needle),
        num_threads_(num_threads) {}

  Activity Render(const ImageMoment& moment, const PortValues& ports, EffectPixels& out) override {
    const bool patient_changed = moment.changes.tissue;
    if (!patient_changed && !(shows_needle_ && moment.changes.needle)) return Activity::kUnchanged;
    std::optional<image::NeedleInImage> needle;
    if (moment.needle != nullptr) needle = *moment.needle;
    if (patient_changed) {
      fluoroscope_.Render(needle, out.gray, num_threads_, ports.Find(ports::kRestMap));
    } else {
      fluoroscope_.RenderNeedle(needle, out.gray);
    }
    return Activity::kActive;
  }

  /// Where the patient has not moved, only the needle's shadow is rendered.
  bool NeedsRestMap(const ImageChanges& changes) const override { return changes.tissue; }

  std::optional<Eigen::Affine3d> ct_from_image() const override {
    return fluoroscope_.geometry().ct_from_image();
  }

  std::optional<ImageText> Text() const override {
    ImageText text{.above = AnglesText(pose_), .left = {}, .right = {}, .below = c_arm().name};
    // Marks the patient's sides, as long as the projection separates left from right.
    if (std::abs(std::sin(pose_.lao_rad)) < 0.8) {
      const bool from_front = std::cos(pose_.lao_rad) > 0.0;
      text.left = from_front ? "R" : "L";
      text.right = from_front ? "L" : "R";
    }
    return text;
  }

 private:
  const fluoroscopy::CArm& c_arm() const { return fluoroscope_.c_arm(); }

  fluoroscopy::Fluoroscope fluoroscope_;
  fluoroscopy::CArmPose pose_;
  bool shows_needle_;
  int num_threads_;
};

class LoadedFluoroscopy final : public LoadedEffect {
 public:
  LoadedFluoroscopy(fluoroscopy::CArm c_arm, const fluoroscopy::CArmPose& pose, bool shows_needle)
      : c_arm_(std::move(c_arm)), pose_(pose), shows_needle_(shows_needle) {}

  std::unique_ptr<ImageStage> NewImageStage(const PortValues& scene,
                                            const RunContext& context) const override {
    return std::make_unique<FluoroscopyStage>(scene.Get(ports::kCt), c_arm_, pose_, shows_needle_,
                                              context.num_threads);
  }

 private:
  fluoroscopy::CArm c_arm_;
  fluoroscopy::CArmPose pose_;
  bool shows_needle_;
};

class FluoroscopyEffect final : public Effect {
 public:
  std::string_view key() const override { return "fluoroscopy"; }
  std::string_view title() const override { return "Fluoroscopy"; }

  json Schema() const override {
    return json::parse(R"json({
      "type": "object",
      "additionalProperties": false,
      "description": "X-ray images of a C-arm: the CT and the needle, in fluoroscopy.mp4 and fluoroscopy.igs.mha",
      "properties": {
        "c_arm": {"type": "string", "default": "c_arms/mobile.json", "description": "C-arm preset (acus-c-arm)"},
        "isocentre_mm": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}, "description": "Where the arm turns about, x y z in CT space (LPS, mm). Omitted: the middle of the CT"},
        "lao_deg": {"type": "number", "minimum": -180, "maximum": 180, "default": 0, "description": "Detector towards the patient's left (negative: right, RAO), degrees; 0: in front of him, 90: beside him"},
        "cranial_deg": {"type": "number", "minimum": -90, "maximum": 90, "default": 0, "description": "Detector towards the head (negative: feet, caudal), degrees"},
        "rate_hz": {"type": "number", "exclusiveMinimum": 0, "maximum": 60, "default": 8, "description": "Images per second of session time"},
        "needle": {"type": "boolean", "default": true, "description": "Show the needle's shadow"}
      }
    })json");
  }

  std::vector<PathSetting> Paths() const override { return {{"c_arm", PathKind::kPreset, kCArm}}; }

  std::optional<StageDeclaration> ImageStageOf(const json& settings) const override {
    StageDeclaration stage{
        .name = "fluoroscopy", .reads = {ports::kCt, kCArm}, .writes = {kFluoroscopy}};
    stage.optional_reads = {ports::kRestMap};
    if (settings.at("needle")) {
      stage.reads.insert(stage.reads.end(), {ports::kNeedle, ports::kNeedlePreset});
      stage.optional_reads.emplace_back(ports::kShape);
    }
    return stage;
  }

  ImageTiming TimingOf(const json& settings) const override {
    return {.rate_hz = settings.at("rate_hz"), .has_own_moments = true};
  }

  std::unique_ptr<const LoadedEffect> Load(const json& settings, const PortValues& scene,
                                           RunContext& context) const override {
    const std::filesystem::path c_arm = settings.at("c_arm").get<std::string>();
    auto loaded = std::make_unique<LoadedFluoroscopy>(
        fluoroscopy::ReadCArm(c_arm), PoseOf(settings, scene.Get(ports::kCt).geometry),
        settings.at("needle"));
    context.provenance.AddInput(c_arm);
    return loaded;
  }
};

}  // namespace

const Effect& Fluoroscopy() {
  static const FluoroscopyEffect effect;
  return effect;
}

}  // namespace acus::effects
