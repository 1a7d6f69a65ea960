#include "acus/run/entry/presets.h"

#include <algorithm>
#include <fstream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/words.h"

namespace acus::entry {
namespace {

namespace fs = std::filesystem;

/// The first sentence of the first comment, on one line.
std::string FirstSentence(const fs::path& file) {
  std::ifstream in(file);
  std::string text;
  for (std::string line; std::getline(in, line);) {
    const std::size_t start = line.find_first_not_of(" \t{");
    const bool is_comment = start != line.npos && line.compare(start, 2, "//") == 0;
    if (!is_comment && !text.empty()) break;
    if (!is_comment) {
      if (start != line.npos) return {};  // The document begins without a comment.
      continue;
    }
    const std::size_t words = line.find_first_not_of(" /", start);
    if (words == line.npos) break;
    text += (text.empty() ? "" : " ") + line.substr(words);
  }
  for (std::size_t end = text.find('.'); end != text.npos; end = text.find('.', end + 1)) {
    if (end + 1 == text.size() || text[end + 1] == ' ') return text.substr(0, end);
  }
  return text;
}

std::string SummaryOf(const fs::path& file) {
  try {
    const auto document = config::ReadJson(file);
    for (const char* key : {"description", "name"}) {
      if (document.is_object() && document.contains(key) && document[key].is_string()) {
        return document[key].get<std::string>();
      }
    }
    return FirstSentence(file);
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace

std::vector<std::string> PresetKinds(const fs::path& configs) {
  std::error_code error;
  std::vector<std::string> kinds;
  for (const auto& entry : fs::directory_iterator(configs, error)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory() && name != "schema") kinds.push_back(name);
  }
  ACUS_REQUIRE(!error && !kinds.empty(), configs.string(),
               ": no folder of presets; install Acus whole, or set ACUS_CONFIGS to such a folder");
  std::ranges::sort(kinds);
  return kinds;
}

std::vector<Preset> PresetsOf(const fs::path& configs, const std::string& kind) {
  const auto kinds = PresetKinds(configs);
  if (!std::ranges::binary_search(kinds, kind)) {
    const auto nearest = NearestSpelling(kind, kinds);
    throw InputError(Message("there are no presets of the kind '", kind, "'; kinds: ",
                             Joined(kinds), nearest ? ". Did you mean " + *nearest + "?" : ""));
  }
  std::vector<Preset> presets;
  for (const auto& entry : fs::directory_iterator(configs / kind)) {
    if (entry.path().extension() != ".json") continue;
    presets.push_back({kind + "/" + entry.path().filename().string(), SummaryOf(entry.path())});
  }
  std::ranges::sort(presets, {}, &Preset::name);
  return presets;
}

}  // namespace acus::entry
