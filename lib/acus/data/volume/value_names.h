// What files say of the values in a label map.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace acus::volume {

/// One value of a label map, as its file describes it.
struct ValueName {
  std::string text;                ///< As the file gives it; may be empty.
  std::vector<std::string> codes;  ///< SNOMED CT, the most specific first; may be empty.
  std::string side = {};  ///< "left" or "right" by a code; empty: only in the text, if at all.
};

using ValueNames = std::map<std::int32_t, ValueName>;

}  // namespace acus::volume
