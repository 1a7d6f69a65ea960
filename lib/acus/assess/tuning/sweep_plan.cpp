#include "acus/assess/tuning/sweep_plan.h"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <set>

#include "acus/base/core/error.h"
#include "acus/base/core/provenance.h"
#include "acus/base/core/random.h"
#include "acus/base/core/words.h"
#include "acus/scene/simulation/effect_plan.h"

namespace acus::tuning {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxRounds =
    64;  ///< Rounds of random draws before the missing ones are enumerated.

/// The features of scenario and session, to check values without loading anything.
class SceneCheck {
 public:
  SceneCheck(const SweptScene& scene, const session::Session& session)
      : scene_(scene),
        available_({.needle_poses = !session.needle.empty(),
                    .probe_poses = !session.probe.empty(),
                    .breath = !session.breath.empty()}) {}

  /// Empty, or why the scene does not allow a setting.
  std::string WhyNot(const std::vector<Knob>& knobs, const Setting& setting) const {
    std::vector<scenario::Override> changes = scene_.changes;
    const auto more = OverridesOf(knobs, setting);
    changes.insert(changes.end(), more.begin(), more.end());
    try {
      const auto scenario = scenario::ReadScenario(scene_.scenario, changes);
      simulation::PlanEffects(scenario, available_);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }

 private:
  const SweptScene& scene_;
  simulation::AvailableInputs available_;
};

/// The parameters to vary, with the values that the scene allows.
std::vector<Knob> ChosenKnobs(const std::vector<Knob>& all, const SceneCheck& check,
                              SweepPlan& plan) {
  std::vector<std::string> asked = plan.request.knobs;
  const bool named = !asked.empty();
  if (!named) {
    for (const Knob& knob : all) {
      if (!knob.values.empty()) asked.push_back(knob.name);
    }
  }
  std::vector<Knob> chosen;
  for (const std::string& text : asked) {
    Knob knob = KnobFromText(all, text);
    ACUS_REQUIRE(std::ranges::find(chosen, knob.name, &Knob::name) == chosen.end(), "--knob ",
                 knob.name, ": is given twice; give all its values at once, with commas");
    const bool values_named = text.find('=') != text.npos;
    std::erase_if(knob.values, [&](const json& value) {
      const std::string why = check.WhyNot(all, {{knob.name, value}});
      ACUS_REQUIRE(why.empty() || !values_named, "--knob ", knob.name, "=", ValueText(value), ": ",
                   why);
      if (!why.empty()) plan.left_out.push_back({knob.name, ValueText(value), why});
      return !why.empty();
    });
    ACUS_REQUIRE(knob.values.size() >= 2 || !named, "--knob ", knob.name,
                 ": this scene can take only one of its values. ",
                 plan.left_out.empty() ? "" : plan.left_out.back().why);
    if (knob.values.size() >= 2) chosen.push_back(std::move(knob));
  }
  ACUS_REQUIRE(!chosen.empty(), plan.request.scene.scenario.string(),
               ": calls for nothing that can be simulated coarser or finer");
  return chosen;
}

/// Letters, digits, dots and dashes; for other text the beginning of its hash.
std::string FileWord(const std::string& text) {
  const bool plain = !text.empty() && text.size() <= 24 && text.front() != '.' &&
                     std::ranges::all_of(text, [](unsigned char c) {
                       return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
                     });
  return plain ? text : Sha256OfText(text).substr(0, 12);
}

/// The settings of one sweep, the most expensive last.
void AddSweep(const std::string& knob, const std::vector<Setting>& settings,
              const std::vector<std::string>& words, int repetition, bool shared_reference,
              SweepPlan& plan) {
  const auto name = [&](std::size_t i) { return Message(knob, "-", words[i], "-r", repetition); };
  const std::size_t last = settings.size() - 1;
  const auto add = [&](std::size_t i) {
    Case one;
    one.name = name(i);
    one.knob = knob;
    one.setting = settings[i];
    one.repetition = repetition;
    one.is_reference = i == last && (repetition == 0 || !shared_reference);
    one.reference = shared_reference ? knob : Message(knob, "-r", repetition);
    one.reference_case = shared_reference ? Message(knob, "-", words[last], "-r0") : name(last);
    one.reference_setting = settings[last];
    plan.cases.push_back(std::move(one));
  };
  add(last);
  for (std::size_t i = 0; i < last; ++i) add(i);
}

/// "4.0.2": the index of the value of each knob.
std::string IndicesWord(const std::vector<int>& indices) {
  std::string word;
  for (const int index : indices) word += Message(word.empty() ? "" : ".", index);
  return FileWord(word);
}

/// All combinations, or a subset, the most expensive of all last.
void Combine(SweepPlan& plan, std::vector<Setting>& settings, std::vector<std::string>& words) {
  std::vector<int> sizes;
  plan.combinations = 1.0;
  for (const Knob& knob : plan.knobs) {
    sizes.push_back(static_cast<int>(knob.values.size()));
    plan.combinations *= sizes.back();
  }
  plan.is_subset = plan.combinations > plan.request.most_combinations;
  std::vector<std::vector<int>> chosen = SpreadCombinations(
      sizes, plan.is_subset ? plan.request.most_combinations : static_cast<int>(plan.combinations),
      plan.request.seed);
  // The scenario's setting, and the most expensive of all: always included.
  std::vector<int> most_expensive;
  std::vector<int> scenario;
  for (const Knob& knob : plan.knobs) {
    most_expensive.push_back(static_cast<int>(knob.values.size()) - 1);
    const auto own = std::ranges::find_if(
        knob.values, [&](const json& v) { return SameValue(v, knob.scenario_value); });
    if (own != knob.values.end()) scenario.push_back(static_cast<int>(own - knob.values.begin()));
  }
  std::erase(chosen, most_expensive);
  if (scenario.size() == plan.knobs.size() && scenario != most_expensive) {
    std::erase(chosen, scenario);
    chosen.insert(chosen.begin(), scenario);
  }
  chosen.push_back(most_expensive);
  for (const std::vector<int>& indices : chosen) {
    Setting setting;
    for (std::size_t k = 0; k < plan.knobs.size(); ++k) {
      setting[plan.knobs[k].name] = plan.knobs[k].values[static_cast<std::size_t>(indices[k])];
    }
    settings.push_back(std::move(setting));
    words.push_back(IndicesWord(indices));
  }
}

/// Enumerates, the last knob the fastest. False after the last combination; it is the first again.
bool NextCombination(const std::vector<int>& sizes, std::vector<int>& indices) {
  std::size_t k = sizes.size();
  while (k > 0 && ++indices[k - 1] == sizes[k - 1]) indices[--k] = 0;
  return k > 0;
}

/// Distinguishes builds without a commit: changed sources, unpacked archives.
std::string ProgramHash() {
  return Sha256OfPath("/proc/self/exe").substr(0, 12);
}

}  // namespace

Case JointCase(const SweepPlan& plan, const std::vector<int>& indices, int repetition) {
  const auto name = [](const std::vector<int>& l, int r) {
    return Message("jointly-", IndicesWord(l), "-r", r);
  };
  std::vector<int> most_expensive;
  Case one;
  for (std::size_t k = 0; k < plan.knobs.size(); ++k) {
    const Knob& knob = plan.knobs[k];
    most_expensive.push_back(static_cast<int>(knob.values.size()) - 1);
    one.setting[knob.name] = knob.values[static_cast<std::size_t>(indices[k])];
    one.reference_setting[knob.name] = knob.MostExpensive();
  }
  one.name = name(indices, repetition);
  one.knob = "jointly";
  one.repetition = repetition;
  one.is_reference = indices == most_expensive && (repetition == 0 || !plan.one_reference);
  one.reference = plan.one_reference ? "jointly" : Message("jointly-r", repetition);
  one.reference_case = name(most_expensive, plan.one_reference ? 0 : repetition);
  return one;
}

std::vector<std::vector<int>> SpreadCombinations(const std::vector<int>& sizes, int count,
                                                 std::uint64_t seed) {
  double all = 1.0;
  for (const int size : sizes) all *= size;
  std::vector<std::vector<int>> chosen;
  if (count >= all) {
    std::vector<int> indices(sizes.size(), 0);
    do {
      chosen.push_back(indices);
    } while (NextCombination(sizes, indices));
    return chosen;
  }
  std::set<std::vector<int>> taken;
  for (std::uint64_t round = 0; round < kMaxRounds && static_cast<int>(chosen.size()) < count;
       ++round) {
    // The values of each parameter in equal shares and in a separate random order; duplicates are
    // dropped, and the next round fills up. It begins at any value: a few missing combinations have
    // to reach all of them.
    const int wanted = count - static_cast<int>(chosen.size());
    std::vector<std::vector<int>> columns;
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      RandomStream random(seed, Message("combinations of knob ", k), round);
      std::vector<int> column(static_cast<std::size_t>(wanted));
      const std::uint64_t first = round == 0 ? 0 : random.Next();
      for (std::size_t i = 0; i < column.size(); ++i) {
        column[i] = static_cast<int>((first + i) % static_cast<std::uint64_t>(sizes[k]));
      }
      for (std::size_t i = column.size(); i > 1; --i) {
        std::swap(column[i - 1], column[random.Next() % i]);
      }
      columns.push_back(std::move(column));
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(wanted); ++i) {
      std::vector<int> indices;
      for (const auto& column : columns) indices.push_back(column[i]);
      if (taken.insert(indices).second) chosen.push_back(std::move(indices));
    }
  }
  // Nearly all combinations are required, or the rounds would have found them: the rest in order.
  std::vector<int> indices(sizes.size(), 0);
  while (static_cast<int>(chosen.size()) < count) {
    if (taken.insert(indices).second) chosen.push_back(indices);
    NextCombination(sizes, indices);
  }
  return chosen;
}

SweepPlan MakePlan(const SweepRequest& request, const RunContext& context) {
  SweepPlan plan;
  plan.request = request;
  const auto scenario = scenario::ReadScenario(request.scene.scenario, request.scene.changes);
  const session::Session session = ReadSessionOf(request.scene, scenario, context);
  const SceneCheck check(request.scene, session);
  const std::string why = check.WhyNot({}, {});
  ACUS_REQUIRE(why.empty(), why);
  const double rate_hz = RecordedRateHz(session);
  plan.knobs = ChosenKnobs(KnobsOf(scenario, rate_hz), check, plan);
  plan.scenario_name = scenario.name.empty() ? request.scene.scenario.string() : scenario.name;
  std::int64_t last_ns = session.start_ns();
  for (const auto* stream : {&session.needle, &session.probe}) {
    if (!stream->empty()) last_ns = std::max(last_ns, stream->back().time_ns);
  }
  plan.seconds = 1e-9 * static_cast<double>(last_ns - session.start_ns()) - request.scene.from_s;
  plan.step_period_ms = rate_hz > 0.0 ? 1e3 / rate_hz : 0.0;
  if (scenario.ultrasound || scenario.ct_slice) plan.image_period_ms = 1e3 / scenario.image_rate_hz;

  // If the scene has nothing random, all repetitions have the same reference.
  plan.one_reference = SeedChanges(scenario, 0).empty();
  const bool shared = plan.one_reference;
  std::vector<Setting> joint;
  std::vector<std::string> joint_words;
  if (request.jointly) Combine(plan, joint, joint_words);
  for (int repetition = 0; repetition < request.repetitions; ++repetition) {
    if (request.jointly) {
      AddSweep("jointly", joint, joint_words, repetition, shared, plan);
      continue;
    }
    for (const Knob& knob : plan.knobs) {
      std::vector<Setting> settings;
      std::vector<std::string> words;
      for (const json& value : knob.values) {
        settings.push_back({{knob.name, value}});
        words.push_back(FileWord(ValueText(value)));
      }
      AddSweep(knob.name, settings, words, repetition, shared, plan);
    }
  }
  return plan;
}

json IdentityOf(const SweepPlan& plan) {
  const SweptScene& scene = plan.request.scene;
  json changes = json::array();
  for (const auto& change : scene.changes) changes.push_back({change.pointer, change.value});
  json knobs = json::array();
  for (const Knob& knob : plan.knobs) {
    knobs.push_back({{"knob", knob.name}, {"levels", knob.values}});
  }
  const auto scenario = scenario::ReadScenario(scene.scenario, scene.changes);
  return {{"format", "acus-tradeoff-plan/1"},
          {"build", Message(Version(), ", program ", ProgramHash())},
          {"scenario", scenario.effective},
          {"changes", changes},
          {"session", {{"path", scene.session.string()}, {"sha256", Sha256OfPath(scene.session)}}},
          {"from_s", scene.from_s},
          {"to_s", scene.to_s},
          {"most_images", scene.most_images},
          {"jointly", plan.request.jointly},
          {"most_combinations", plan.request.most_combinations},
          {"seed", plan.request.seed},
          {"knobs", knobs}};
}

}  // namespace acus::tuning
