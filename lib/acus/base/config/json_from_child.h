// Values read in a separate process, by libraries that crash or never end on broken files.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "acus/base/core/child_process.h"

namespace acus::config {

/// What `work` returns, run in a separate process within `limits`.
/// @param failure  The message if it crashes or exceeds them: "a.h5: cannot be read; the file is
///     damaged". What happened follows in brackets.
/// @throws InputError with that message, or with that of the exception that `work` throws.
nlohmann::json JsonFromChild(const core::ChildLimits& limits, const std::string& failure,
                             const std::function<nlohmann::json()>& work);

}  // namespace acus::config
