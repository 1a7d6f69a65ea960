#include "acus/run/replay/pain_sound.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/data/sound/cry.h"

namespace acus::replay {
namespace {

constexpr std::string_view kPain = "pain_reaction";

}  // namespace

std::optional<sound::Sound> PainSoundOf(const scenario::Scenario& scenario, RunContext& context) {
  const auto pain = std::ranges::find_if(
      scenario.listed, [](const auto& called) { return called.effect->key() == kPain; });
  if (pain == scenario.listed.end()) return std::nullopt;
  const auto name = pain->settings.at("sound").get<std::string>();
  if (name == "none") return std::nullopt;
  sound::Sound sound;
  if (name == "cry") {
    sound = sound::Cry();
  } else {
    try {
      sound = sound::ReadSound(name);
    } catch (const InputError& error) {
      throw InputError(Message(scenario.file.string(), ": /effects/pain_reaction/sound: ",
                               error.what(), " (or \"none\" or \"cry\")"));
    }
    context.provenance.AddInput(name);
  }
  const double latency_s = pain->settings.at("latency_s");
  const auto silent = static_cast<std::size_t>(std::llround(latency_s * sound.rate_hz));
  sound.samples.insert(sound.samples.begin(), silent, 0);
  return sound;
}

int ReactionsIn(const simulation::Scene& scene, const simulation::StepOutput& output) {
  for (const simulation::ListedEffect& effect : scene.listed.all()) {
    if (effect.key != kPain || effect.step == nullptr) continue;
    for (std::size_t n = 0; n < effect.columns.size(); ++n) {
      if (effect.columns[n].name != "reactions") continue;
      return static_cast<int>(output.effect[effect.first_column + n]);
    }
  }
  return 0;
}

void WritePainSound(const std::filesystem::path& folder, const sound::Sound& sound,
                    const simulation::Scene& scene, const StepLog& log) {
  std::vector<double> times_s;
  int before = 0;
  const std::int64_t begin_ns = log.steps.empty() ? 0 : log.steps.front().time_ns;
  const auto seconds = [begin_ns](const simulation::StepOutput& step) {
    return 1e-9 * static_cast<double>(step.time_ns - begin_ns);
  };
  for (const simulation::StepOutput& step : log.steps) {
    const int now = ReactionsIn(scene, step);
    if (now > before) times_s.push_back(seconds(step));
    before = now;
  }
  const double duration_s = log.steps.empty() ? 0.0 : seconds(log.steps.back());
  sound::WriteWav(folder / "pain_reaction.wav", sound::TrackOf(sound, times_s, duration_s));
}

}  // namespace acus::replay
