#include "acus/scene/effects/pulsating_vessels/pulsating_vessels.h"

#include <algorithm>

#include "acus/scene/effects/loaded_step.h"
#include "acus/scene/effects/ports.h"
#include "acus/scene/effects/pulsating_vessels/pulse.h"
#include "acus/scene/effects/tubes/tube_effect.h"

namespace acus::effects {
namespace {

using nlohmann::json;

constexpr ports::FilePort kCentrelines{"vessels' centrelines"};

struct PulseState {
  double strain = 0.0;  ///< Current strain of all radii.
};

class VesselStage final : public StepStageOf<PulseState> {
 public:
  VesselStage(std::vector<Tube> vessels, const Pulse& pulse, double strain, double warp_spacing_mm)
      : vessels_(std::move(vessels)),
        pulse_(pulse),
        strain_(strain),
        warp_spacing_mm_(warp_spacing_mm) {
    for (const Tube& vessel : vessels_) {
      largest_radius_mm_ = std::max(largest_radius_mm_, vessel.LargestRadiusMm());
    }
  }

  Activity Step(PulseState& state, const StepTime& time, PortValues& /*ports*/,
                std::span<double> columns) const noexcept override {
    state.strain = strain_ * pulse_.At(time.session_s);
    columns[0] = largest_radius_mm_ * state.strain;
    return state.strain > 0.0 ? Activity::kActive : Activity::kIdle;
  }

  Eigen::Vector3d RestInCtMm(const PulseState& state,
                             const Eigen::Vector3d& place_in_ct_mm) const noexcept override {
    Eigen::Vector3d rest_mm = place_in_ct_mm;
    for (const Tube& vessel : vessels_) rest_mm = vessel.RestMm(rest_mm, state.strain);
    return rest_mm;
  }

  bool IsSameMotion(const PulseState& a, const PulseState& b) const noexcept override {
    return a.strain == b.strain;
  }

  double MotionSpacingMm() const noexcept override { return warp_spacing_mm_; }

 private:
  std::vector<Tube> vessels_;
  Pulse pulse_;
  double strain_;
  double warp_spacing_mm_;
  double largest_radius_mm_ = 0.0;
};

class PulsatingVesselsEffect final : public Effect {
 public:
  std::string_view key() const override { return "pulsating_vessels"; }
  std::string_view title() const override { return "Pulsating vessels"; }

  json Schema() const override {
    return json::parse(R"({
      "type": "object",
      "additionalProperties": false,
      "description": "Arteries whose walls move with the heart, and the tissue around them; felt by needle and probe, seen in the images",
      "properties": {
        "tissue": {"type": "string", "default": "vessel", "description": "Tissue of the label map whose centrelines are followed; not read if centrelines are given"},
        "centrelines": {"type": "string", "description": "CSV of centrelines (vessel,x_mm,y_mm,z_mm,radius_mm; CT space), in place of the label map"},
        "heart_rate_per_min": {"type": "number", "exclusiveMinimum": 0, "maximum": 300, "default": 70, "description": "Beats per minute"},
        "rise_share": {"type": "number", "minimum": 0.02, "maximum": 0.9, "default": 0.15, "description": "Share of the heart's cycle in which the wall moves out"},
        "radial_strain": {"type": "number", "minimum": 0, "maximum": 0.3, "default": 0.08, "description": "Motion of the wall at the peak of systole, as a share of the radius. Abdominal aorta: 0.04 to 0.12"},
        "reach_mm": {"type": "number", "minimum": 1, "maximum": 100, "default": 15, "description": "Tissue moves up to this far beyond the wall"},
        "point_spacing_mm": {"type": "number", "minimum": 0.5, "maximum": 50, "default": 4, "description": "Distance of points along a centreline"},
        "warp_spacing_mm": {"type": "number", "minimum": 0.1, "maximum": 50, "default": 2, "description": "The images evaluate the motion at knots this far apart, and interpolate"}
      }
    })");
  }

  std::vector<PathSetting> Paths() const override { return TubePaths(kCentrelines); }

  std::optional<StageDeclaration> StepStageOf(const json& settings) const override {
    return TubeStage("pulse", kCentrelines, settings);
  }

  std::vector<Column> Columns() const override {
    return {{"wall_mm", "How far the wall of the largest vessel has moved out", "mm"}};
  }

  std::vector<Knob> Knobs() const override {
    return TubeKnobs("vessel", "a pulsating vessel", "vessels");
  }

  std::unique_ptr<const LoadedEffect> Load(const json& settings, const PortValues& scene,
                                           RunContext& context) const override {
    const double strain = settings.at("radial_strain");
    std::vector<Tube> vessels = TubesOf(settings, scene, strain, context);
    if (vessels.empty()) {
      context.Warn("effects/pulsating_vessels: the label map has no vessel of tissue \"" +
                   settings.at("tissue").get<std::string>() +
                   "\" that can be followed over five slices; nothing pulsates");
    }
    const Pulse pulse(settings.at("heart_rate_per_min"), settings.at("rise_share"));
    return std::make_unique<LoadedStep<VesselStage>>(VesselStage(
        std::move(vessels), pulse, strain, settings.at("warp_spacing_mm").get<double>()));
  }
};

}  // namespace

const Effect& PulsatingVessels() {
  static const PulsatingVesselsEffect effect;
  return effect;
}

}  // namespace acus::effects
