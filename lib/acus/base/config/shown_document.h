// A JSON document as it may stand in an output: without folders, if they are not to be shown.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace acus::config {

/// Every text that is an absolute path becomes what ShownPath() makes of it.
nlohmann::json ShownDocument(nlohmann::json document);

}  // namespace acus::config
