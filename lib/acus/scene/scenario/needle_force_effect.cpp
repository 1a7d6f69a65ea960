#include "acus/scene/scenario/needle_force_effect.h"

#include <map>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::scenario {
namespace {

/// The file of needle_force.model measured, and which of its laws.
void ReadMeasured(const nlohmann::json& effect, const std::filesystem::path& folder,
                  const std::string& file, NeedleForceEffect& force) {
  const std::string where = file + ": /effects/needle_force";
  const bool is_measured = force.model == NeedleForceModelKind::kMeasured;
  ACUS_REQUIRE(is_measured == effect.contains("measured"), where,
               is_measured ? ": model \"measured\" needs the file of the fit, measured: the "
                             "measured.json that acus-fit writes"
                           : "/measured: only model \"measured\" reads it; set the model, or "
                             "leave it out");
  if (!is_measured) return;
  force.measured = config::FindConfig(effect.at("measured").get<std::string>(), folder);
  force.recording = effect.at("recording");
  force.seed = effect.at("seed");
  ACUS_REQUIRE(force.seed == 0 || force.recording == "mean", where, "/seed: is ", force.seed,
               ", which draws from all recordings, but recording is '", force.recording,
               "'; leave one of the two out");
}

}  // namespace

NeedleForceEffect ReadNeedleForce(const nlohmann::json& effect, const std::filesystem::path& folder,
                                  const std::string& file) {
  static const std::map<std::string, NeedleForceModelKind> kModels = {
      {"layered", NeedleForceModelKind::kLayered},
      {"alamilla", NeedleForceModelKind::kAlamilla},
      {"vidal", NeedleForceModelKind::kVidal},
      {"measured", NeedleForceModelKind::kMeasured},
      {"tissue", NeedleForceModelKind::kTissue}};
  static const std::map<std::string, GuidanceKind> kGuidance = {
      {"own", GuidanceKind::kOwn},
      {"none", GuidanceKind::kNone},
      {"vidal", GuidanceKind::kVidal},
      {"virtual_fixture", GuidanceKind::kVirtualFixture}};
  NeedleForceEffect force;
  force.model = kModels.at(effect.at("model"));
  force.guidance = kGuidance.at(effect.at("guidance"));
  force.table = config::FindConfig(effect.at("table").get<std::string>(), folder);
  force.direct_method = effect.at("wall").get<std::string>() == "direct";
  ACUS_REQUIRE(!force.direct_method || force.model == NeedleForceModelKind::kAlamilla, file,
               ": /effects/needle_force/wall is \"direct\": only the model alamilla has the direct "
               "method; leave it out, or take that model");
  ReadMeasured(effect, folder, file, force);
  force.skin_nick_radius_mm = effect.at("skin_nick_radius_mm");
  const bool goes_by_membranes = force.model != NeedleForceModelKind::kMeasured &&
                                 force.model != NeedleForceModelKind::kTissue;
  ACUS_REQUIRE(force.skin_nick_radius_mm == 0.0 || goes_by_membranes, file,
               ": /effects/needle_force/skin_nick_radius_mm: only the models layered, alamilla "
               "and vidal have a nick in the skin; leave it out");
  return force;
}

}  // namespace acus::scenario
