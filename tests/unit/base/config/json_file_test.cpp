#include "acus/base/config/json_file.h"

#include <gmock/gmock.h>

#include "acus/base/config/schema_check.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::config {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Lt;
using testing::Not;
using testing::SizeIs;
using testing::ThrowsMessage;

const json kSchema = json::parse(R"({
  "type": "object", "additionalProperties": false, "required": ["name"],
  "properties": {
    "name": {"type": "string"},
    "depth_mm": {"type": "number", "minimum": 0, "maximum": 200, "default": 80},
    "mode": {"enum": ["fast", "exact"], "default": "fast"},
    "friction": {"$ref": "#/definitions/friction"},
    "layers": {"type": "array", "items": {"$ref": "#/definitions/friction"}}
  },
  "definitions": {"friction": {
    "type": "object", "additionalProperties": false, "default": {},
    "properties": {"coulomb_n_per_mm": {"type": "number", "default": 0.01}}}}
})");

TEST(Problems, AreAllReportedAtOnceWithPlaceValueAndRemedy) {
  const json document = json::parse(R"({
    "depth_mm": 300, "mode": "slow", "friction": {"coulomb_n_per_m": 1}, "layers": [{}, {"coulomb_n_per_mm": "x"}]})");
  const auto problems = Problems(kSchema, document);
  EXPECT_THAT(
      problems,
      testing::UnorderedElementsAre(
          HasSubstr("/name: missing"),
          AllOf(HasSubstr("/depth_mm: "), HasSubstr("200"), HasSubstr("got 300")),
          AllOf(HasSubstr("/mode: must be one of"), HasSubstr("got \"slow\"")),
          HasSubstr("/friction/coulomb_n_per_m: unknown key; did you mean \"coulomb_n_per_mm\"?"),
          AllOf(HasSubstr("/layers/1/coulomb_n_per_mm: expected \"number\""),
                HasSubstr("got \"x\""))));
}

TEST(Problems, LongValuesAreCutAndShortOnesAreNot) {
  const auto problem = [](const json& mode) {
    return Problems(kSchema, json{{"name", "a"}, {"mode", mode}}).at(0);
  };
  EXPECT_THAT(problem("slow"), AllOf(HasSubstr("got \"slow\""), Not(HasSubstr("..."))));
  EXPECT_THAT(problem(std::string(500, 'x')), AllOf(HasSubstr("xxx..."), SizeIs(Lt(200))));
}

TEST(FillDefaults, ReachesIntoObjectsAndItems) {
  json document = json::parse(R"({"name": "a", "layers": [{}]})");
  FillDefaults(kSchema, document);
  EXPECT_EQ(document["depth_mm"], 80);
  EXPECT_EQ(document["friction"]["coulomb_n_per_mm"], 0.01);
  EXPECT_EQ(document["layers"][0]["coulomb_n_per_mm"], 0.01);
}

TEST(ReadJson, RefusesDuplicateKeysAndSaysWhereSyntaxBreaks) {
  const testing_support::TemporaryFolder folder;
  const auto path = folder / "config.json";
  const auto read = [&](std::string_view text) {
    return [&path, text] {
      WriteTextFile(path, text);
      ReadJson(path);
    };
  };
  EXPECT_THAT(read(R"({"a": 1, "b": {"a": 2}, "a": 3})"),
              ThrowsMessage<InputError>(HasSubstr("key 'a' is given twice")));
  EXPECT_NO_THROW(read(R"({"a": 1, "b": {"a": 2}} // fine)")());
  EXPECT_THAT(read("{\n\"a\": }"), ThrowsMessage<InputError>(HasSubstr(
                                       "config.json: is not valid JSON: parse error at line 2")));
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += R"({"a":)";
  EXPECT_THAT(read(deep), ThrowsMessage<InputError>(HasSubstr("nested more than 100 deep")));
}

TEST(FindConfig, FindsALoopOfLinksWhereItIs) {
  const testing_support::TemporaryFolder folder;
  std::filesystem::create_symlink("loop.json", folder / "loop.json");
  EXPECT_EQ(FindConfig("loop.json", folder.path()), folder / "loop.json");
  EXPECT_THAT([&] { ReadJson(folder / "loop.json"); },
              ThrowsMessage<InputError>(HasSubstr("symbolic links")));
}

TEST(FindConfig, NamesThePresetThatWasMeant) {
  setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  const testing_support::TemporaryFolder folder;
  for (const char* name :
       {"liver_biopsy_awake", "liver_biopsy_awkae.json", "x/liver_biopsy_awake"}) {
    EXPECT_THAT(
        [&] { FindConfig(name, folder.path()); },
        ThrowsMessage<InputError>(HasSubstr("did you mean scenarios/liver_biopsy_awake.json?")))
        << name;
  }
  // Exercises and scenarios share names: the folder says which is meant; without it all are.
  EXPECT_THAT([&] { FindConfig("exercises/lumbar_punctur.json", folder.path()); },
              ThrowsMessage<InputError>(HasSubstr("did you mean exercises/lumbar_puncture.json?")));
  EXPECT_THAT([&] { FindConfig("lumbar_punctur", folder.path()); },
              ThrowsMessage<InputError>(HasSubstr("did you mean exercises/lumbar_puncture.json or "
                                                  "scenarios/lumbar_puncture.json?")));
  EXPECT_THAT([&] { FindConfig("devices/liver_biopsy", folder.path()); },
              ThrowsMessage<InputError>(testing::Not(HasSubstr("did you mean"))));
  EXPECT_THAT([&] { FindConfig("nothing_like_this_at_all.json", folder.path()); },
              ThrowsMessage<InputError>(testing::Not(HasSubstr("did you mean"))));
}

TEST(WriteJson, WritesValidJsonWhateverBytesANameHolds) {
  const testing_support::TemporaryFolder folder;
  const auto path = folder / "bytes.json";
  WriteJson(path, {{"file", "p\xFFt.csv"}});
  EXPECT_EQ(ReadJson(path).at("file"), "p\uFFFDt.csv");
}

TEST(WriteJson, EndsWithALineAndRefusesNumbersThatJsonLacks) {
  const testing_support::TemporaryFolder folder;
  const auto path = folder / "a.json";
  WriteJson(path, {{"depth_mm", 80}});
  EXPECT_EQ(ReadTextFile(path), "{\n  \"depth_mm\": 80\n}\n");
  EXPECT_THAT(
      [&] {
        WriteJson(path, {{"depth_mm", {1.0, std::nan("")}}});
      },
      ThrowsMessage<InputError>(HasSubstr("a.json: ")));
  EXPECT_EQ(ReadJson(path).at("depth_mm"), 80);
}

TEST(CheckedConfig, WantsTheFormatOfItsSchema) {
  json document = {{"format", "acus-needle/1"}};
  const auto check = [&] { CheckedConfig(document, "acus-scenario", "s.json"); };
  EXPECT_THAT(check, ThrowsMessage<InputError>(
                         HasSubstr("must be \"acus-scenario/1\", got \"acus-needle/1\"")));
  document.erase("format");
  EXPECT_THAT(check, ThrowsMessage<InputError>(HasSubstr("got nothing")));
}

TEST(Schemas, AreValidJsonWithDescribedStrictObjects) {
  ASSERT_FALSE(SchemaNames().empty());
  for (const std::string& name : SchemaNames()) {
    const json schema = json::parse(SchemaText(name));
    EXPECT_EQ(schema.at("additionalProperties"), false) << name;
    EXPECT_EQ(schema.at("properties").at("format").at("const"), name + "/1");
  }
}

}  // namespace
}  // namespace acus::config
