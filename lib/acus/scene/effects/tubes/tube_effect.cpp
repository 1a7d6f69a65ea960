#include "acus/scene/effects/tubes/tube_effect.h"

#include "acus/data/volume/labels.h"
#include "acus/scene/effects/tubes/centrelines.h"

namespace acus::effects {
namespace {

using nlohmann::json;

constexpr const char* kKey = "centrelines";

std::vector<Centreline> LinesOf(const json& settings, const PortValues& scene,
                                RunContext& context) {
  if (!settings.contains(kKey)) {
    return CentrelinesOf(scene.Get(ports::kLabels),
                         volume::LabelOf(settings.at("tissue").get<std::string>()));
  }
  const std::filesystem::path file = settings.at(kKey).get<std::string>();
  auto lines = ReadCentrelines(file);
  context.provenance.AddInput(file);
  return lines;
}

}  // namespace

std::vector<PathSetting> TubePaths(const ports::FilePort& centrelines) {
  return {{kKey, PathKind::kFile, centrelines}};
}

StageDeclaration TubeStage(std::string_view name, const ports::FilePort& centrelines,
                           const json& settings) {
  StageDeclaration stage{.name = name, .reads = {}, .writes = {ports::kTissueMotion}};
  stage.reads.push_back(settings.contains(kKey) ? PortRef(centrelines) : PortRef(ports::kLabels));
  stage.is_goal = false;
  return stage;
}

std::vector<Knob> TubeKnobs(const std::string& prefix, const std::string& one,
                            const std::string& all) {
  return {{.name = prefix + "_point_spacing_mm",
           .title = "points along the centreline of " + one,
           .unit = "mm",
           .key = "point_spacing_mm",
           .values = {32, 16, 8, 4, 2, 1}},
          {.name = prefix + "_warp_spacing_mm",
           .title = "knots at which images evaluate the motion of " + all,
           .unit = "mm",
           .key = "warp_spacing_mm",
           .acts_on = ActsOn::kImage,
           .values = {8, 4, 2, 1, 0.5}}};
}

std::vector<Tube> TubesOf(const json& settings, const PortValues& scene, double largest_strain,
                          RunContext& context) {
  std::vector<Tube> tubes;
  for (const Centreline& line : LinesOf(settings, scene, context)) {
    tubes.emplace_back(Resampled(line, settings.at("point_spacing_mm")), settings.at("reach_mm"),
                       largest_strain);
  }
  return tubes;
}

}  // namespace acus::effects
