#include "acus/base/config/shown_document.h"

#include <nlohmann/json.hpp>

#include "acus/base/core/shown_path.h"

namespace acus::config {

nlohmann::json ShownDocument(nlohmann::json document) {
  if (document.is_string()) {
    const auto& text = document.get_ref<const std::string&>();
    if (text.starts_with('/')) return ShownPath(text);
  }
  if (document.is_structured()) {
    for (auto& child : document) child = ShownDocument(std::move(child));
  }
  return document;
}

}  // namespace acus::config
