#include "acus/scene/effects/peristalsis/peristalsis.h"

#include "acus/scene/effects/loaded_step.h"
#include "acus/scene/effects/peristalsis/contraction_wave.h"
#include "acus/scene/effects/ports.h"
#include "acus/scene/effects/tubes/tube_effect.h"

namespace acus::effects {
namespace {

using nlohmann::json;

constexpr ports::FilePort kBowelCentrelines{"bowel's centrelines"};

struct PeristalsisState {
  double waves = 0.0;  ///< Number of waves that have begun.
};

class PeristalsisStage final : public StepStageOf<PeristalsisState> {
 public:
  PeristalsisStage(std::vector<Tube> loops, const ContractionWave& wave, double contraction,
                   double warp_spacing_mm)
      : loops_(std::move(loops)),
        wave_(wave),
        is_still_(loops_.empty() || contraction == 0.0),
        warp_spacing_mm_(warp_spacing_mm) {}

  Activity Step(PeristalsisState& state, const StepTime& time, PortValues& /*ports*/,
                std::span<double> columns) const noexcept override {
    if (is_still_) return Activity::kIdle;
    state.waves = wave_.WavesAt(time.session_s);
    columns[0] = state.waves;
    return Activity::kActive;
  }

  Eigen::Vector3d RestInCtMm(const PeristalsisState& state,
                             const Eigen::Vector3d& place_in_ct_mm) const noexcept override {
    Eigen::Vector3d rest_mm = place_in_ct_mm;
    if (is_still_) return rest_mm;
    Tube::Nearest near;
    for (const Tube& loop : loops_) {
      if (!loop.FindNearest(rest_mm, near)) continue;
      rest_mm = loop.RestMm(rest_mm, near, wave_.StrainAt(near.along_mm, state.waves));
    }
    return rest_mm;
  }

  bool IsSameMotion(const PeristalsisState& a, const PeristalsisState& b) const noexcept override {
    return a.waves == b.waves;
  }

  double MotionSpacingMm() const noexcept override { return warp_spacing_mm_; }

 private:
  std::vector<Tube> loops_;
  ContractionWave wave_;
  bool is_still_;
  double warp_spacing_mm_;
};

class PeristalsisEffect final : public Effect {
 public:
  std::string_view key() const override { return "peristalsis"; }
  std::string_view title() const override { return "Peristalsis"; }

  json Schema() const override {
    return json::parse(R"json({
      "type": "object",
      "additionalProperties": false,
      "description": "Bowel whose wall contracts in waves that travel along it; felt by needle and probe, seen in the images",
      "properties": {
        "tissue": {"type": "string", "default": "bowel", "description": "Tissue of the label map whose centrelines are followed; not read if centrelines are given"},
        "centrelines": {"type": "string", "description": "CSV of centrelines (vessel,x_mm,y_mm,z_mm,radius_mm; CT space), in place of the label map; waves travel from the first point on"},
        "waves_per_min": {"type": "number", "exclusiveMinimum": 0, "maximum": 60, "default": 9, "description": "Contractions per minute: small bowel 8 to 12, colon 3"},
        "speed_mm_per_s": {"type": "number", "exclusiveMinimum": 0, "maximum": 500, "default": 12, "description": "Speed of a contraction along the bowel"},
        "length_mm": {"type": "number", "exclusiveMinimum": 0, "maximum": 1000, "default": 40, "description": "Length of the part that is contracted"},
        "contraction": {"type": "number", "minimum": 0, "maximum": 0.9, "default": 0.3, "description": "Largest motion of the wall inwards, as a share of the radius"},
        "reach_mm": {"type": "number", "minimum": 1, "maximum": 100, "default": 10, "description": "Tissue moves up to this far beyond the wall"},
        "point_spacing_mm": {"type": "number", "minimum": 0.5, "maximum": 50, "default": 4, "description": "Distance of points along a centreline"},
        "warp_spacing_mm": {"type": "number", "minimum": 0.1, "maximum": 50, "default": 2, "description": "The images evaluate the motion at knots this far apart, and interpolate"}
      }
    })json");
  }

  std::vector<PathSetting> Paths() const override { return TubePaths(kBowelCentrelines); }

  std::optional<StageDeclaration> StepStageOf(const json& settings) const override {
    return TubeStage("peristalsis", kBowelCentrelines, settings);
  }

  std::vector<Column> Columns() const override {
    return {{"waves", "Contractions that have begun", ""}};
  }

  std::vector<Knob> Knobs() const override { return TubeKnobs("bowel", "moving bowel", "bowel"); }

  std::unique_ptr<const LoadedEffect> Load(const json& settings, const PortValues& scene,
                                           RunContext& context) const override {
    const double contraction = settings.at("contraction");
    std::vector<Tube> loops = TubesOf(settings, scene, 0.0, context);
    if (loops.empty()) {
      context.Warn("effects/peristalsis: the label map has no tissue \"" +
                   settings.at("tissue").get<std::string>() +
                   "\" that can be followed over five slices; nothing moves");
    }
    const ContractionWave wave(settings.at("waves_per_min"), settings.at("speed_mm_per_s"),
                               settings.at("length_mm"), contraction);
    return std::make_unique<LoadedStep<PeristalsisStage>>(
        PeristalsisStage(std::move(loops), wave, contraction, settings.at("warp_spacing_mm")));
  }
};

}  // namespace

const Effect& Peristalsis() {
  static const PeristalsisEffect effect;
  return effect;
}

}  // namespace acus::effects
