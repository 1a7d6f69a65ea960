// Numbers of things in messages: "1 gap", "3 gaps".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace acus {

/// The number and its noun, in the singular for one. `noun` takes an s in the plural, at its end or
/// where it has a '#': "gap", "step# of the needle".
inline std::string Counted(std::int64_t number, std::string_view noun) {
  const std::string plural = number == 1 ? "" : "s";
  const auto mark = noun.find('#');
  if (mark == std::string_view::npos)
    return std::to_string(number) + ' ' + std::string(noun) + plural;
  return std::to_string(number) + ' ' + std::string(noun.substr(0, mark)) + plural +
         std::string(noun.substr(mark + 1));
}

}  // namespace acus
