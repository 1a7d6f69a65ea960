// docs/reference/commands and docs/reference/config.md are made from the programs and schemas.
// This test compares them; with ACUS_WRITE_DOCS set it writes them instead (developer/docs).
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/scene/effects/effect_list.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kReference = fs::path(ACUS_SOURCE_DIR) / "docs" / "reference";

void ExpectGenerated(const fs::path& file, const std::string& text) {
  if (std::getenv("ACUS_WRITE_DOCS") != nullptr) {
    WriteTextFile(file, text);
    return;
  }
  ASSERT_TRUE(fs::exists(file)) << file << " is missing; run developer/docs";
  EXPECT_TRUE(ReadTextFile(file) == text) << file << " is out of date; run developer/docs";
}

/// Trailing blanks of a line mean something in Markdown, and nothing here.
std::string WithoutTrailingBlanks(const std::string& text) {
  std::istringstream in(text);
  std::string out;
  for (std::string line; std::getline(in, line);) {
    const auto end = line.find_last_not_of(" \t\r");
    out += (end == line.npos ? "" : line.substr(0, end + 1)) + "\n";
  }
  while (out.ends_with("\n\n")) out.pop_back();
  return out;
}

std::string HelpOf(const std::string& program, const std::string& subcommand) {
  const std::string command =
      std::string(ACUS_BUILD_DIR) + "/bin/" + program + " " + subcommand + " --help";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) text += buffer.data();
  EXPECT_FALSE(text.empty()) << command;
  return WithoutTrailingBlanks(text);
}

/// The names under "Subcommands:" of a help text.
std::vector<std::string> Subcommands(const std::string& help) {
  std::vector<std::string> names;
  std::istringstream in(help);
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (inside && (line.empty() || line[0] != ' ')) inside = false;
    if (inside && line.starts_with("  ") && line[2] != ' ') {
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
    }
    if (line == "Subcommands:") inside = true;
  }
  return names;
}

std::vector<std::string> Programs() {
  std::vector<std::string> programs;
  std::istringstream names(ACUS_PROGRAMS);
  for (std::string name; std::getline(names, name, ',');) programs.push_back(name);
  return programs;
}

TEST(Docs, CommandsAreThoseOfTheHelp) {
  for (const std::string& program : Programs()) {
    const std::string help = HelpOf(program, "");
    std::string page = "# " + program + "\n\n<!-- Made by developer/docs from --help. -->\n\n";
    page += "```\n" + help + "```\n";
    for (const std::string& name : Subcommands(help)) {
      page += "\n## " + program + " " + name + "\n\n```\n" + HelpOf(program, name) + "```\n";
    }
    ExpectGenerated(kReference / "commands" / (program + ".md"), page);
  }
}

TEST(Docs, NoPageIsLeftOfAProgramThatIsGone) {
  const fs::path folder = kReference / "commands";
  if (!fs::exists(folder)) return;
  const auto programs = Programs();
  for (const auto& entry : fs::directory_iterator(folder)) {
    EXPECT_NE(std::find(programs.begin(), programs.end(), entry.path().stem().string()),
              programs.end())
        << entry.path();
  }
}

/// A cell of a Markdown table.
std::string Cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != text.npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string TypeOf(const json& schema) {
  if (schema.contains("enum")) {
    std::string text;
    for (const json& value : schema["enum"]) text += (text.empty() ? "" : ", ") + value.dump();
    return "one of " + text;
  }
  if (schema.contains("const")) return schema["const"].dump();
  if (!schema.contains("type")) return "any";
  const json& type = schema["type"];
  if (type == "array") {
    std::string size;
    if (schema.contains("minItems") && schema.value("maxItems", -1) == schema["minItems"]) {
      size = " of " + schema["minItems"].dump();
    }
    return "array" + size;
  }
  return type.is_string() ? type.get<std::string>() : type.dump();
}

std::string RangeOf(const json& schema) {
  std::string text;
  const std::array<std::pair<const char*, const char*>, 4> bounds = {{{"minimum", ">= "},
                                                                      {"exclusiveMinimum", "> "},
                                                                      {"maximum", "<= "},
                                                                      {"exclusiveMaximum", "< "}}};
  for (const auto& [key, sign] : bounds) {
    if (schema.contains(key)) text += (text.empty() ? "" : ", ") + (sign + schema[key].dump());
  }
  return text;
}

const json& Resolved(const json& root, const json& schema) {
  if (!schema.contains("$ref")) return schema;
  return root.at(json::json_pointer(schema["$ref"].get<std::string>().substr(1)));
}

/// One row for each key of `schema`, and below it those of the objects inside.
void AddRows(const json& root, const json& schema, const std::string& prefix, std::string& table) {
  if (schema.contains("properties")) {
    for (const auto& [key, property] : schema["properties"].items()) {
      const json& child = Resolved(root, property);
      const auto required = schema.value("required", json::array());
      const bool is_required = std::find(required.begin(), required.end(), key) != required.end();
      const json fallback = property.value("default", child.value("default", json()));
      const bool has_default = property.contains("default") || child.contains("default");
      const std::string description =
          property.value("description", child.value("description", std::string()));
      table += "| `" + prefix + key + "` | " + Cell(TypeOf(child)) + " | " + RangeOf(child) +
               " | " +
               (is_required   ? "required"
                : has_default ? "`" + Cell(fallback.dump()) + "`"
                              : "") +
               " | " + Cell(description) + " |\n";
      AddRows(root, child, prefix + key + "/", table);
    }
  }
  if (schema.contains("items"))
    AddRows(root, Resolved(root, schema["items"]), prefix + "#/", table);
  if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object()) {
    AddRows(root, Resolved(root, schema["additionalProperties"]), prefix + "NAME/", table);
  }
}

TEST(Docs, ConfigsAreThoseOfTheSchemas) {
  std::string page =
      "# Configuration files\n\n<!-- Made by developer/docs from configs/schema. -->\n\n"
      "Every JSON file begins with its `format`. Unknown keys, wrong types and values out of "
      "range\n"
      "are refused, all at once, with the place in the file. Comments (`//`) are allowed. Units "
      "are\n"
      "in the names. In the first column `#` stands for the number of an array item and `NAME` "
      "for\n"
      "a name of your choice.\n";
  for (const std::string& name : config::SchemaNames()) {
    json schema = json::parse(config::SchemaText(name));
    if (name == "acus-scenario") schema = effects::WithEffects(std::move(schema));
    page += "\n## " + name + "\n\n" + schema.value("title", std::string()) + "\n\n";
    if (schema.contains("description")) page += schema["description"].get<std::string>() + "\n\n";
    page += "| key | type | range | default | meaning |\n|---|---|---|---|---|\n";
    AddRows(schema, schema, "", page);
  }
  ExpectGenerated(kReference / "config.md", page);
}

}  // namespace
}  // namespace acus
