#include "acus/scene/effects/pain_reaction/pain_reaction.h"

#include <array>
#include <bitset>

#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "acus/scene/effects/loaded_step.h"
#include "acus/scene/effects/pain_reaction/jerk.h"
#include "acus/scene/effects/ports.h"

namespace acus::effects {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

/// Tissue that is numb by a local anaesthetic.
struct Anaesthesia {
  Vector3d centre_in_ct_mm = Vector3d::Zero();
  double radius_mm = 0.0;  ///< 0: none.

  bool Covers(const Vector3d& place_in_ct_mm) const noexcept {
    return (place_in_ct_mm - centre_in_ct_mm).norm() < radius_mm;
  }
};

struct PainSettings {
  std::bitset<256> hurts;
  double amplitude_mm = 0.0;
  double pause_s = 0.0;
  Anaesthesia anaesthesia;
};

struct PainState {
  volume::Label tissue = 0;      ///< At the tip in the last step.
  std::int32_t count = 0;        ///< Reactions so far.
  double pain_s = 0.0;           ///< Session time of the last pain, with a count above 0.
  std::array<double, 3> away{};  ///< Direction of the movement, unit length, CT space.
  double shift_mm = 0.0;         ///< Current displacement along `away`.
};

/// Triggers a reaction where the tip enters a tissue that hurts. It runs after the tools, whose
/// forces follow the movement from the next step on.
class PainStage final : public StepStageOf<PainState> {
 public:
  PainStage(const PainSettings& settings, const Jerk& jerk) : settings_(settings), jerk_(jerk) {}

  Activity Step(PainState& state, const StepTime& time, PortValues& ports,
                std::span<double> columns) const noexcept override {
    const Eigen::Isometry3d& needle = ports.Get(ports::kNeedle).ct_from_tool;
    const volume::Label tissue = ports.Get(ports::kTissue);
    const bool enters = tissue != state.tissue && settings_.hurts.test(tissue);
    state.tissue = tissue;
    const double rest_s = jerk_.DurationS() + settings_.pause_s;
    const bool is_calm = state.count == 0 || time.session_s - state.pain_s >= rest_s;
    if (enters && is_calm && needle.matrix().allFinite() &&
        !settings_.anaesthesia.Covers(needle.translation())) {
      const Vector3d away = needle.linear().col(2).normalized();
      state.away = {away.x(), away.y(), away.z()};
      state.pain_s = time.session_s;
      ++state.count;
    }
    const double share = state.count > 0 ? jerk_.At(time.session_s - state.pain_s) : 0.0;
    state.shift_mm = settings_.amplitude_mm * share;
    columns[0] = state.shift_mm;
    columns[1] = state.count;
    return share > 0.0 ? Activity::kActive : Activity::kIdle;
  }

  Vector3d RestInCtMm(const PainState& state,
                      const Vector3d& place_in_ct_mm) const noexcept override {
    return place_in_ct_mm - state.shift_mm * Vector3d::Map(state.away.data());
  }

  bool IsSameMotion(const PainState& a, const PainState& b) const noexcept override {
    return a.shift_mm == b.shift_mm && a.away == b.away;
  }

 private:
  PainSettings settings_;
  Jerk jerk_;
};

class PainReactionEffect final : public Effect {
 public:
  std::string_view key() const override { return "pain_reaction"; }
  std::string_view title() const override { return "Reaction to pain"; }

  json Schema() const override {
    return json::parse(R"json({
      "type": "object",
      "additionalProperties": false,
      "description": "A patient who jerks away when the needle enters a tissue that hurts; felt by needle and probe, seen in the images",
      "properties": {
        "tissues": {"type": "array", "items": {"type": "string"}, "default": ["skin", "bone"], "description": "Tissues that hurt when the needle's tip enters them"},
        "anaesthesia_at_mm": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}, "default": [0, 0, 0], "description": "Middle of a local anaesthesia, x y z in CT space (LPS, mm)"},
        "anaesthesia_radius_mm": {"type": "number", "minimum": 0, "maximum": 500, "default": 0, "description": "Nothing hurts within this distance of it; 0: no anaesthesia"},
        "amplitude_mm": {"type": "number", "minimum": 0, "maximum": 50, "default": 4, "description": "How far the patient moves, along the needle and away from it"},
        "latency_s": {"type": "number", "minimum": 0, "maximum": 5, "default": 0.15, "description": "From the pain to the beginning of the movement"},
        "rise_s": {"type": "number", "minimum": 0.02, "maximum": 10, "default": 0.25, "description": "Duration of the movement away"},
        "return_s": {"type": "number", "minimum": 0.02, "maximum": 60, "default": 1.5, "description": "Duration of the movement back"},
        "pause_s": {"type": "number", "minimum": 0, "maximum": 600, "default": 2, "description": "After a reaction the patient feels no other one for this time"},
        "sound": {"type": "string", "default": "none", "description": "What is heard with the movement: none; cry, a synthetic one; or a sound file of yours (WAV, AIFF, FLAC or Ogg; 1 or 2 channels, at most 60 s). Live through the loudspeaker, in replays as pain_reaction.wav"}
      }
    })json");
  }

  void Check(const json& settings, const std::string& where) const override {
    for (const json& tissue : settings.at("tissues")) {
      try {
        volume::LabelOf(tissue.get<std::string>());
      } catch (const InputError& error) {
        throw InputError(where + "/tissues: " + error.what());
      }
    }
  }

  void ResolveFiles(json& settings, const std::filesystem::path& folder) const override {
    if (!settings.contains("sound") || !settings["sound"].is_string()) return;
    const auto sound = settings["sound"].get<std::string>();
    if (sound == "none" || sound == "cry") return;
    settings["sound"] = (folder / sound).lexically_normal().string();
  }

  std::optional<StageDeclaration> StepStageOf(const json& /*settings*/) const override {
    return StageDeclaration{.name = "pain reaction",
                            .reads = {ports::kNeedle, ports::kTissue},
                            .writes = {ports::kTissueMotion}};
  }

  std::vector<Column> Columns() const override {
    return {{"shift_mm", "How far the patient has jerked away", "mm"},
            {"reactions", "Reactions to pain so far", ""}};
  }

  std::unique_ptr<const LoadedEffect> Load(const json& settings, const PortValues& /*scene*/,
                                           RunContext& /*context*/) const override {
    PainSettings pain;
    for (const json& tissue : settings.at("tissues")) {
      pain.hurts.set(volume::LabelOf(tissue.get<std::string>()));
    }
    pain.hurts.reset(0);  // Outside the body.
    pain.amplitude_mm = settings.at("amplitude_mm");
    pain.pause_s = settings.at("pause_s");
    const json& place = settings.at("anaesthesia_at_mm");
    pain.anaesthesia = {Vector3d(place[0], place[1], place[2]),
                        settings.at("anaesthesia_radius_mm")};
    return std::make_unique<LoadedStep<PainStage>>(PainStage(
        pain, Jerk(settings.at("latency_s"), settings.at("rise_s"), settings.at("return_s"))));
  }
};

}  // namespace

const Effect& PainReaction() {
  static const PainReactionEffect effect;
  return effect;
}

}  // namespace acus::effects
