// The JSON Schemas of configs/schema, compiled in. Generated source: see lib/acus.cmake.
#pragma once

#include <span>
#include <string_view>

namespace acus::config {

struct EmbeddedSchema {
  std::string_view name;
  std::string_view text;
};

std::span<const EmbeddedSchema> EmbeddedSchemas();

}  // namespace acus::config
