#include "acus/base/config/schema_check.h"

#include <set>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

#include "acus/base/core/error.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/words.h"

namespace acus::config {
namespace {

using nlohmann::json;

/// Follows "$ref": "#/definitions/x" to its target.
const json& Resolved(const json& root, const json& schema) {
  const json* node = &schema;
  while (node->is_object() && node->contains("$ref")) {
    const std::string reference = node->at("$ref").get<std::string>();
    ACUS_ASSERT(reference.starts_with("#"));
    node = &root.at(json::json_pointer(reference.substr(1)));
  }
  return *node;
}

/// The part of the schema that a step into an object or array leads to; null if there is none.
const json* Child(const json& root, const json& schema, const std::string& step) {
  const json& node = Resolved(root, schema);
  if (node.contains("properties") && node["properties"].contains(step)) {
    return &Resolved(root, node["properties"][step]);
  }
  for (const char* key : {"items", "additionalProperties"}) {
    if (node.contains(key) && node[key].is_object()) return &Resolved(root, node[key]);
  }
  return nullptr;
}

/// A place in the document, as valijson reports it: "<root>", "[key]", "[0]".
struct Place {
  std::string pointer;
  const json* value;
  const json* schema;  ///< Null if the schema says nothing of it.
};

Place Locate(const json& schema, const json& document, const std::vector<std::string>& context) {
  Place place{"", &document, &schema};
  for (std::size_t i = 1; i < context.size(); ++i) {
    const std::string step = context[i].substr(1, context[i].size() - 2);
    place.pointer += "/" + step;
    if (place.value != nullptr && place.value->is_array()) {
      const std::size_t index = std::stoul(step);
      place.value = index < place.value->size() ? &(*place.value)[index] : nullptr;
    } else if (place.value != nullptr && place.value->contains(step)) {
      place.value = &(*place.value)[step];
    } else {
      place.value = nullptr;
    }
    if (place.schema != nullptr) place.schema = Child(schema, *place.schema, step);
  }
  return place;
}

std::string Given(const json* value) {
  if (value == nullptr) return "";
  std::string text = value->dump();
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return ", got " + text;
}

/// What stands between the last two single quotes.
std::string LastQuoted(const std::string& text) {
  const auto end = text.rfind('\'');
  const auto begin = text.rfind('\'', end - 1) + 1;
  return text.substr(begin, end - begin);
}

/// "at least 0 and at most 200"
std::string Range(const json& schema) {
  std::string text;
  const std::pair<const char*, const char*> bounds[] = {{"minimum", "at least "},
                                                        {"exclusiveMinimum", "above "},
                                                        {"maximum", "at most "},
                                                        {"exclusiveMaximum", "below "}};
  for (const auto& [key, words] : bounds) {
    if (schema.contains(key)) text += (text.empty() ? "" : " and ") + (words + schema[key].dump());
  }
  return text;
}

std::string Lowered(std::string text) {
  text[0] = static_cast<char>(std::tolower(text[0]));
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string Explain(const std::string& description, const Place& place) {
  const auto says = [&](const char* phrase) {
    return description.find(phrase) != description.npos;
  };
  if (says("Object contains a property")) {
    const std::string key = LastQuoted(description);
    std::vector<std::string> known;
    if (place.schema != nullptr && place.schema->contains("properties")) {
      for (const auto& [name, unused] : (*place.schema)["properties"].items())
        known.push_back(name);
    }
    const auto nearest = NearestSpelling(key, known);
    return Message(place.pointer, "/", key, ": unknown key; ",
                   nearest ? Message("did you mean \"", *nearest, "\"?")
                           : Message("known here: ", Joined(known)));
  }
  if (says("Missing required property")) {
    return Message(place.pointer, "/", LastQuoted(description), ": missing; it is required");
  }
  if (says("Value type not permitted") && place.schema != nullptr &&
      place.schema->contains("type")) {
    return Message(place.pointer, ": expected ", (*place.schema)["type"].dump(),
                   Given(place.value));
  }
  if (says("enum values") && place.schema != nullptr && place.schema->contains("enum")) {
    return Message(place.pointer, ": must be one of ", (*place.schema)["enum"].dump(),
                   Given(place.value));
  }
  if (says("Expected number") && place.schema != nullptr) {
    return Message(place.pointer, ": must be ", Range(*place.schema), Given(place.value));
  }
  return Message(place.pointer.empty() ? "/" : place.pointer, ": ", Lowered(description),
                 Given(place.value));
}

}  // namespace

std::vector<std::string> Problems(const json& schema, const json& document) {
  valijson::Schema compiled;
  valijson::SchemaParser parser;
  parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(schema), compiled);
  // Strong types: "1" is not a number, and true is not 1.
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  valijson::ValidationResults results;
  if (validator.validate(compiled, valijson::adapters::NlohmannJsonAdapter(document), &results)) {
    return {};
  }
  std::vector<std::string> problems;
  std::set<std::string> seen;
  for (const auto& error : results) {
    // Each problem is reported again by every enclosing object; the innermost report says it all.
    if (error.description.starts_with("Failed to validate")) continue;
    const std::string text = Explain(error.description, Locate(schema, document, error.context));
    if (seen.insert(text).second) problems.push_back(text);
  }
  if (problems.empty()) problems.push_back("/: does not fit the schema");
  return problems;
}

namespace {

void Fill(const json& root, const json& schema, json& node) {
  if (node.is_object()) {
    if (schema.contains("properties")) {
      for (const auto& [key, property] : schema["properties"].items()) {
        const json& child = Resolved(root, property);
        if (!node.contains(key)) {
          if (property.contains("default")) {
            node[key] = property["default"];
          } else if (child.contains("default")) {
            node[key] = child["default"];
          }
        }
      }
    }
    for (auto& [key, value] : node.items()) {
      if (const json* child = Child(root, schema, key)) Fill(root, *child, value);
    }
  } else if (node.is_array()) {
    for (json& item : node) {
      if (const json* child = Child(root, schema, "0")) Fill(root, *child, item);
    }
  }
}

}  // namespace

void FillDefaults(const json& schema, json& document) {
  Fill(schema, Resolved(schema, schema), document);
}

}  // namespace acus::config
