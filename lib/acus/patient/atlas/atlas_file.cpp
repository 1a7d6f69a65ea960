#include "acus/patient/atlas/atlas_file.h"

#include <map>

#include "acus/base/config/json_file.h"

namespace acus::atlas {

namespace fs = std::filesystem;

namespace {

std::vector<AtlasPatient> PatientsIn(const fs::path& folder, RunContext& context) {
  const fs::path file = folder / "atlas.json";
  const nlohmann::json document = config::ReadConfig(file, "acus-atlas");
  std::vector<AtlasPatient> patients;
  for (const auto& node : document.at("patients")) {
    const auto place = [&](const char* key) {
      const fs::path path = folder / node.at(key).get<std::string>();
      ACUS_REQUIRE(fs::exists(path), file.string(), ": /patients/", patients.size(), "/", key, ": ",
                   path.string(), " does not exist");
      return path;
    };
    const std::string mapping = node.at("mapping");
    patients.push_back(
        {.name = node.at("name"),
         .ct = place("ct"),
         .series = node.at("series"),
         .labels = {.file = place("labels"),
                    .mapping = mapping.empty() ? "" : config::FindConfig(mapping, folder),
                    .ct = place("ct"),
                    .series = node.at("series")}});
  }
  context.provenance.AddInput(file);
  for (const AtlasPatient& patient : patients) {
    for (const fs::path& path : {patient.ct, patient.labels.file, patient.labels.mapping}) {
      if (!path.empty()) context.provenance.AddInput(path);
    }
  }
  return patients;
}

}  // namespace

std::vector<AtlasPatient> ReadAtlas(const std::vector<fs::path>& folders, RunContext& context) {
  std::vector<AtlasPatient> all;
  std::map<fs::path, fs::path> listed;  // CTs, and the atlas of each.
  for (const fs::path& folder : folders) {
    for (AtlasPatient& patient : PatientsIn(folder, context)) {
      const auto [first, is_new] = listed.emplace(fs::canonical(patient.ct), folder);
      ACUS_REQUIRE(is_new || !patient.series.empty(), (folder / "atlas.json").string(),
                   ": the CT of patient \"", patient.name, "\" is in the atlas already, by ",
                   (first->second / "atlas.json").string(),
                   "; a patient may count once: remove one of the two");
      all.push_back(std::move(patient));
    }
  }
  return all;
}

}  // namespace acus::atlas
