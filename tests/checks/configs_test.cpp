// Every file of configs/ is valid, and every schema tells the user all that he must know.
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "acus/base/config/json_file.h"
#include "acus/base/config/schema_check.h"
#include "acus/scene/effects/effect_list.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::vector<fs::path> JsonFiles() {
  std::vector<fs::path> files;
  for (const char* folder : {"configs", "testdata"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(ACUS_SOURCE_DIR) / folder)) {
      const bool is_schema = entry.path().string().find("/schema/") != std::string::npos;
      if (entry.path().extension() == ".json" && !is_schema) files.push_back(entry.path());
    }
  }
  return files;
}

/// With the parts of all effects.
json SchemaOf(const std::string& name) {
  json schema = json::parse(config::SchemaText(name));
  return name == "acus-scenario" ? effects::WithEffects(std::move(schema)) : schema;
}

TEST(Configs, FitTheSchemaThatTheirFormatNames) {
  for (const fs::path& path : JsonFiles()) {
    const json document = config::ReadJson(path);
    ASSERT_TRUE(document.is_object() && document.contains("format")) << path;
    const auto format = document["format"].get<std::string>();
    EXPECT_NO_THROW({
      try {
        const std::string name = format.substr(0, format.find('/'));
        config::CheckedConfig(document, name, path.string(), SchemaOf(name));
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
        throw;
      }
    });
  }
}

/// Walks through a schema; `pointer` is where in the schema, for messages.
void CheckSchema(const json& root, const json& node, const std::string& pointer) {
  if (!node.is_object()) return;
  if (node.contains("properties")) {
    EXPECT_TRUE(node.contains("additionalProperties"))
        << pointer << ": say whether unknown keys are allowed (additionalProperties)";
    for (const auto& [key, property] : node["properties"].items()) {
      const std::string where = pointer + "/properties/" + key;
      const bool is_tag = property.contains("const");
      EXPECT_TRUE(is_tag || property.contains("$ref") || property.contains("description"))
          << where << ": needs a description, with the unit";
      if (property.contains("default")) {
        json schema = property;
        if (root.contains("definitions")) schema["definitions"] = root["definitions"];
        const auto problems = config::Problems(schema, property["default"]);
        EXPECT_TRUE(problems.empty()) << where << ": the default is not valid: " << problems[0];
      }
      if (node.contains("required")) {
        for (const json& required : node["required"]) {
          EXPECT_FALSE(required == key && property.contains("default"))
              << where << ": is required, so its default is never used";
        }
      }
    }
    if (node.contains("required")) {
      for (const json& required : node["required"]) {
        EXPECT_TRUE(node["properties"].contains(required.get<std::string>()))
            << pointer << ": requires " << required << ", which it does not describe";
      }
    }
  }
  for (const auto& [key, child] : node.items()) {
    if (key == "default" || key == "enum" || key == "const" || key == "examples") continue;
    if (child.is_object()) CheckSchema(root, child, pointer + "/" + key);
    if (child.is_array()) {
      for (std::size_t i = 0; i < child.size(); ++i) {
        CheckSchema(root, child[i], pointer + "/" + key + "/" + std::to_string(i));
      }
    }
  }
}

TEST(Schemas, DescribeEveryKeyAndHaveValidDefaults) {
  ASSERT_FALSE(config::SchemaNames().empty());
  for (const std::string& name : config::SchemaNames()) {
    const json schema = SchemaOf(name);
    EXPECT_EQ(schema["properties"]["format"]["const"], name + "/1") << name;
    CheckSchema(schema, schema, name);
  }
}

}  // namespace
}  // namespace acus
