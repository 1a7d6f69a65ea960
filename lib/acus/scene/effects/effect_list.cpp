#include "acus/scene/effects/effect_list.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/scene/effects/fluid/fluid_effect.h"
#include "acus/scene/effects/fluoroscopy/fluoroscopy_effect.h"
#include "acus/scene/effects/pain_reaction/pain_reaction.h"
#include "acus/scene/effects/peristalsis/peristalsis.h"
#include "acus/scene/effects/planes/planes.h"
#include "acus/scene/effects/pulsating_vessels/pulsating_vessels.h"
#include "acus/scene/effects/view_3d/view_3d.h"

namespace acus::effects {
namespace {

std::vector<const Effect*>& List() {
  static std::vector<const Effect*> list = {
      &PainReaction(), &PulsatingVessels(), &Peristalsis(), &FluidThroughNeedle(),
      &Fluoroscopy(),  &View3d(),           &Planes()};
  return list;
}

}  // namespace

bool CalledEffect::StepWrites(PortRef port) const {
  const auto stage = step();
  return stage && std::ranges::find(stage->writes, port) != stage->writes.end();
}

std::vector<const Effect*> AllEffects() {
  return List();
}

void RegisterEffect(const Effect& effect) {
  const std::string_view key = effect.key();
  ACUS_REQUIRE(
      !key.empty() && key.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == key.npos,
      "effect '", key, "': a key has lower-case letters, digits and '_' only");
  ACUS_REQUIRE(std::ranges::find(List(), key, &Effect::key) == List().end(), "effect '", key,
               "': there is one of that key already");
  List().push_back(&effect);
}

nlohmann::json WithEffects(nlohmann::json base) {
  nlohmann::json& properties = base.at("properties").at("effects").at("properties");
  for (const Effect* effect : List()) {
    ACUS_REQUIRE(!properties.contains(effect->key()), "effect '", effect->key(),
                 "': the schema has one of that key already");
    properties[std::string(effect->key())] = effect->Schema();
  }
  return base;
}

}  // namespace acus::effects
