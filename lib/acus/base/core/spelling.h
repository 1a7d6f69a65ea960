// "Did you mean ...?"
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace acus {

/// The word of `known` nearest to `given` by edit distance, if it is near enough to be a typing
/// mistake (at most a third of the letters, at least one).
std::optional<std::string> NearestSpelling(std::string_view given,
                                           std::span<const std::string> known);

}  // namespace acus
