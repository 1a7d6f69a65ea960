#include "acus/patient/phantom/planning/scene_request.h"

#include <CLI/CLI.hpp>

#include "acus/patient/phantom/planning/approach_window.h"

namespace acus::phantom {

void SceneRequest::AddOptions(CLI::App& app) {
  app.add_option("--target", target,
                 "A structure of the label map, such as liver, kidney_left or spinal_canal (its\n"
                 "deepest point that a free path reaches), a point x,y,z (CT, LPS, mm), or the\n"
                 "canal between two vertebrae, such as L3-L4 (of vertebrae.csv beside the map)");
  app.add_option("--window", window, "From where; default: as usual for the target")
      ->check(CLI::IsMember(WindowNames()));
}

std::vector<NamedLevel> SceneRequest::Levels() const {
  return vertebrae.empty() ? std::vector<NamedLevel>() : ReadSpinalLevels(vertebrae);
}

void SceneRequest::FindVertebrae(const std::filesystem::path& labels_file, RunContext& context) {
  const std::filesystem::path beside = labels_file.parent_path() / "vertebrae.csv";
  if (NamesSpinalLevel(target)) ReadSpinalLevel(target, beside);
  if (!std::filesystem::exists(beside)) return;
  vertebrae = beside;
  context.provenance.AddInput(vertebrae);
}

}  // namespace acus::phantom
