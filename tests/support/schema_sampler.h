// Random documents that a JSON schema allows, its extremes among them.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "acus/base/core/random.h"

namespace acus::testing_support {

/// Draws what our schemas are made of: objects, enums, constants, booleans, numbers and whole
/// numbers with ranges. Strings and arrays are drawn from `choices` by their JSON pointer, and left
/// out where there is none; so is whatever has an empty list of choices.
class SchemaSampler {
 public:
  using Choices = std::map<std::string, std::vector<nlohmann::json>>;

  SchemaSampler(nlohmann::json schema, Choices choices)
      : schema_(std::move(schema)), choices_(std::move(choices)) {}

  nlohmann::json Draw(std::uint64_t seed) const {
    RandomStream random(seed, "schema");
    return *DrawNode(schema_, "", random);
  }

  /// A key that takes numbers, and the ends of what it may be.
  struct Range {
    nlohmann::json::json_pointer pointer;
    nlohmann::json low;
    nlohmann::json high;
  };

  /// All of them but those that have choices, in order of name.
  std::vector<Range> Ranges() const {
    std::vector<Range> ranges;
    AddRanges(schema_, "", ranges);
    return ranges;
  }

  /// A document with as little as can be besides these keys: what is required on the way to them,
  /// drawn.
  nlohmann::json Least(
      const std::vector<std::pair<nlohmann::json::json_pointer, nlohmann::json>>& values,
      std::uint64_t seed) const {
    RandomStream random(seed, "schema");
    nlohmann::json document = DrawRequired(schema_, "", random);
    for (const auto& [pointer, value] : values) {
      std::vector<nlohmann::json::json_pointer> ancestors;
      for (auto at = pointer.parent_pointer(); !at.empty(); at = at.parent_pointer()) {
        ancestors.insert(ancestors.begin(), at);
      }
      for (const auto& at : ancestors) {
        if (document.contains(at)) continue;
        document[at] = DrawRequired(NodeAt(at.to_string()), at.to_string(), random);
      }
      document[pointer] = value;
    }
    return document;
  }

  /// What an enum allows at a place; empty if it is none there or is chosen. Choices count.
  std::vector<nlohmann::json> ValuesAt(const std::string& pointer) const {
    if (const auto own = choices_.find(pointer); own != choices_.end()) return own->second;
    const Json node = NodeAt(pointer);
    return node.value("enum", std::vector<nlohmann::json>{});
  }

 private:
  using Json = nlohmann::json;

  Json NodeAt(const std::string& pointer) const {
    const Json* node = &schema_;
    std::istringstream parts(pointer);
    std::string part;
    std::getline(parts, part, '/');
    while (std::getline(parts, part, '/')) {
      if (!node->contains("properties") || !(*node)["properties"].contains(part))
        return Json::object();
      node = &(*node)["properties"][part];
    }
    return *node;
  }

  Json DrawRequired(const Json& node, const std::string& pointer, RandomStream& random) const {
    Json object = Json::object();
    for (const Json& key : node.value("required", Json::array())) {
      const std::string name = key;
      const auto value = DrawNode(node["properties"][name], pointer + "/" + name, random);
      if (value) object[name] = *value;
    }
    return object;
  }

  void AddRanges(const Json& node, const std::string& pointer, std::vector<Range>& ranges) const {
    if (choices_.contains(pointer)) return;
    const std::string type = node.value("type", "");
    if (type == "object" && node.contains("properties")) {
      for (const auto& [key, property] : node["properties"].items()) {
        AddRanges(property, pointer + "/" + key, ranges);
      }
    }
    if ((type != "number" && type != "integer") || node.contains("enum")) return;
    const auto [low, high] = Ends(node);
    const Json::json_pointer at(pointer);
    if (type == "integer") {
      ranges.push_back({at, static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)});
    } else {
      ranges.push_back({at, low, high});
    }
  }

  /// Smallest and largest; where the smallest is excluded, little more than it.
  static std::pair<double, double> Ends(const Json& node) {
    const bool open = node.contains("exclusiveMinimum");
    double low = open ? node["exclusiveMinimum"].get<double>() : node.value("minimum", 0.0);
    const double high = node.value("maximum", 1e6);
    if (open) low = low == 0.0 ? 1e-4 * high : low * (1.0 + 1e-9);
    return {low, high};
  }

  std::optional<Json> DrawNode(const Json& node, const std::string& pointer,
                               RandomStream& random) const {
    if (const auto own = choices_.find(pointer); own != choices_.end()) {
      if (own->second.empty()) return std::nullopt;
      return own->second[random.Next() % own->second.size()];
    }
    if (node.contains("const")) return node["const"];
    if (node.contains("enum")) return node["enum"][random.Next() % node["enum"].size()];
    const std::string type = node.value("type", "");
    if (type == "boolean") return random.Next() % 2 == 0;
    if (type == "number" || type == "integer") return DrawNumber(node, type == "integer", random);
    if (type == "object") return DrawObject(node, pointer, random);
    return std::nullopt;
  }

  Json DrawObject(const Json& node, const std::string& pointer, RandomStream& random) const {
    Json object = Json::object();
    const Json required = node.value("required", Json::array());
    if (!node.contains("properties")) return object;
    for (const auto& [key, property] : node["properties"].items()) {
      // Drawn in any case, so that one property more does not change all that follow.
      const auto value = DrawNode(property, pointer + "/" + key, random);
      const bool wanted = random.Uniform() < 0.5;
      const bool is_required = std::find(required.begin(), required.end(), key) != required.end();
      if (value && (wanted || is_required)) object[key] = *value;
    }
    return object;
  }

  /// Each end of the range once in ten draws; over decades where the range spans them.
  static Json DrawNumber(const Json& node, bool is_integer, RandomStream& random) {
    const auto [low, high] = Ends(node);
    const double kind = random.Uniform();
    double value = random.Uniform(low, high);
    if (kind < 0.1) value = low;
    if (kind > 0.9) value = high;
    if (low > 0.0 && high / low > 50.0 && kind >= 0.1 && kind <= 0.9) {
      value = low * std::pow(high / low, random.Uniform());
    }
    if (is_integer) return static_cast<std::int64_t>(std::floor(value));
    return value;
  }

  Json schema_;
  Choices choices_;
};

/// The same failure in fewer keys: takes out one key after the other, deepest last, as long as it
/// `fails` without it.
inline nlohmann::json Shrunk(nlohmann::json document,
                             const std::function<bool(const nlohmann::json&)>& fails) {
  for (bool smaller = true; smaller;) {
    smaller = false;
    std::vector<nlohmann::json::json_pointer> objects = {nlohmann::json::json_pointer("")};
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const nlohmann::json object = document.at(objects[i]);
      for (const auto& [key, value] : object.items()) {
        nlohmann::json without = document;
        without.at(objects[i]).erase(key);
        if (fails(without)) {
          document = std::move(without);
          smaller = true;
        } else if (value.is_object()) {
          objects.push_back(objects[i] / key);
        }
      }
    }
  }
  return document;
}

}  // namespace acus::testing_support
