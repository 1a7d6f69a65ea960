#include "acus/run/live/session_request.h"

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::live {
namespace {

constexpr const char* kWhere = "request";

}  // namespace

SessionRequest ParseSessionRequest(const std::string& line) {
  const auto parsed = nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
  ACUS_REQUIRE(parsed.is_object(), kWhere, ": is no JSON object in one line: ", line.substr(0, 80));
  const auto request = config::CheckedConfig(parsed, "acus-session-request", kWhere);
  const auto path = [&](const char* key) {
    return std::filesystem::path(request.at(key).get<std::string>());
  };
  return {.output = path("output"),
          .scenario = path("scenario"),
          .exercise = path("exercise"),
          .hand = path("hand"),
          .duration_s = request.at("duration_s"),
          .trial = request.at("trial"),
          .caption = request.at("caption"),
          .left_handed = request.at("left_handed"),
          .screenshot = path("screenshot")};
}

}  // namespace acus::live
