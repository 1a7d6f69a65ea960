#include "acus/scene/scenario/scenario_document.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/scene/scenario/scenario.h"
#include "support/temporary_folder.h"

namespace acus::scenario {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// All places of a schema that hold a free text; items of lists are not places.
void TextPlaces(const json& schema, const std::string& pointer, std::set<std::string>& out) {
  if (schema.value("type", "") == "string" && !schema.contains("enum")) out.insert(pointer);
  if (!schema.contains("properties")) return;
  for (const auto& [key, property] : schema["properties"].items()) {
    TextPlaces(property, pointer + "/" + key, out);
  }
}

TEST(ScenarioDocument, DecidesForEveryTextWhetherItIsAPath) {
  std::set<std::string> places;
  TextPlaces(ScenarioSchema(), "", places);
  for (const auto& pointers : {PathPointers(), PresetPointers()}) {
    for (const std::string_view pointer : pointers) {
      EXPECT_EQ(places.erase(std::string(pointer)), 1U) << pointer << " is no text of the schema";
    }
  }
  // A new one belongs here, or among the paths: else a scenario written elsewhere would not find
  // it.
  const std::set<std::string> no_paths = {
      "/name", "/patient/series", "/session/reference_frame", "/effects/tissue/fe_3d/element",
      "/effects/breathing/column", "/effects/needle_force/recording",
      "/effects/pulsating_vessels/tissue",
      // Names in the table of the effect.
      "/effects/fluid/syringe", "/effects/fluid/bore", "/effects/fluid/epidural",
      "/effects/fluid/space", "/effects/fluid/subarachnoid", "/effects/fluid/vessel",
      // Or a file, which the effect finds by itself.
      "/effects/pain_reaction/sound", "/effects/peristalsis/tissue", "/evidence/asked",
      "/evidence/machine", "/evidence/acus_version", "/evidence/session/name"};
  EXPECT_EQ(places, no_paths);
}

TEST(ScenarioDocument, DigitsAreTextWhereTheScenarioHasAText) {
  EXPECT_EQ(ParseOverride("/patient/series=978824805941").value, "978824805941");
  EXPECT_EQ(ParseOverride("/patient/series=1.20").value, "1.20");
  EXPECT_EQ(ParseOverride("/name=true").value, "true");
  EXPECT_EQ(ParseOverride("/name=\"7\"").value, "7");
  EXPECT_EQ(ParseOverride("/image_rate_hz=12").value, 12);
  EXPECT_EQ(ParseOverride("/effects/ultrasound/needle=false").value, false);
  EXPECT_TRUE(ParseOverride("/patient/series=null").value.is_null());
}

TEST(ScenarioDocument, FindsItsFilesFromAnotherFolder) {
  setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  fs::create_directories(folder / "patient");
  fs::create_directories(folder / "chosen" / "deep");
  for (const char* name :
       {"patient/ct.nrrd", "patient/labels.seg.nrrd", "patient/own_table.json"}) {
    WriteTextFile(folder / name, "");
  }
  WriteTextFile(folder / "patient" / "scene.json", R"({"format": "acus-scenario/1",
    "patient": {"ct": "ct.nrrd", "labels": "../patient/labels.seg.nrrd"},
    "effects": {"needle_force": {"table": "own_table.json"}, "ct_slice": {},
                "ultrasound": {"model": "beams", "display": ""}}})");
  const std::vector<Override> changes = {ParseOverride("/image_rate_hz=12"),
                                         ParseOverride("/effects/ct_slice=null")};
  const json written = ForAnyFolder(ScenarioDocument(folder / "patient" / "scene.json", changes),
                                    folder / "patient");
  config::WriteJson(folder / "chosen" / "deep" / "scenario.json", written);
  const Scenario before = ReadScenario(folder / "patient" / "scene.json", changes);
  const Scenario after = ReadScenario(folder / "chosen" / "deep" / "scenario.json", {});
  EXPECT_EQ(after.patient.ct, before.patient.ct);
  EXPECT_EQ(after.patient.labels, before.patient.labels);
  EXPECT_EQ(after.needle_force->table, before.needle_force->table);
  EXPECT_EQ(after.needle, before.needle);
  EXPECT_EQ(after.image_rate_hz, 12.0);
  EXPECT_FALSE(after.ct_slice.has_value());
  EXPECT_EQ(written["effects"]["ultrasound"]["display"], "");
  // What was not said is still not said, and presets are still presets.
  EXPECT_FALSE(written.contains("needle"));
  EXPECT_FALSE(written.contains("evidence"));
}

TEST(ScenarioDocument, PresetsStayPresetsEvenIfThereIsNoneOfThatName) {
  const testing_support::TemporaryFolder folder;
  for (const char* name : {"needles/trocar_18g.json", "needles/not_there.json"}) {
    EXPECT_EQ(ForAnyFolder(json{{"needle", name}}, folder.path()).at("needle"), name);
  }
  WriteTextFile(folder / "own.json", "");
  EXPECT_EQ(ForAnyFolder(json{{"needle", "own.json"}}, folder.path()).at("needle"),
            (folder / "own.json").string());
}

TEST(ScenarioDocument, TakesPathsOfChangesFromTheWorkingFolder) {
  const testing_support::TemporaryFolder temporary;
  const fs::path file = temporary.path() / "scene.json";
  WriteTextFile(file,
                R"({"format": "acus-scenario/1", "effects": {"breathing": {"motion": "m"}}})");
  for (const char* pointer : {"/patient/ct", "/effects/breathing/motion"}) {
    const std::vector<Override> changes = {ParseOverride(std::string(pointer) + "=given")};
    const json document = ScenarioDocument(file, changes);
    EXPECT_EQ(document[json::json_pointer(pointer)], (fs::current_path() / "given").string());
  }
}

}  // namespace
}  // namespace acus::scenario
