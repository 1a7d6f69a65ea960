#include "acus/data/session/session_io.h"

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/session/pose_csv.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kSchema = "acus-session";

/// A stream lies beside session.json: a name that leads elsewhere would read files unasked.
fs::path StreamPath(const fs::path& folder, const fs::path& file, const std::string& where) {
  ACUS_REQUIRE(!file.empty() && file == file.filename() && file != ".." && file != ".", where,
               ": is \"", file.string(), "\"; the name of a file beside session.json is needed");
  const fs::path path = folder / file;
  ACUS_REQUIRE(fs::is_regular_file(path), where, ": there is no file ", path.string());
  return path;
}

}  // namespace

Session ReadSession(const fs::path& folder, const RunContext& context) {
  const fs::path description = folder / "session.json";
  ACUS_REQUIRE(fs::is_regular_file(description), folder.string(),
               ": has no session.json, so it is not a session folder");
  const json document = config::ReadConfig(description, kSchema);
  Session session;
  session.name = document.at("name").get<std::string>();
  session.reference_frame = document.at("reference_frame").get<std::string>();
  const json& streams = document.at("streams");
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const std::string where = Message(description.string(), ": /streams/", i);
    const std::string tool = streams[i].at("tool").get<std::string>();
    PoseStream& stream = tool == "needle" ? session.needle : session.probe;
    ACUS_REQUIRE(stream.empty(), where, "/tool: \"", tool, "\" is given twice; remove one of them");
    stream = ReadPoseCsv(
        StreamPath(folder, streams[i].at("file").get<std::string>(), where + "/file"), context);
  }
  const auto signal = [&](const char* key) {
    return StreamPath(folder, document.at(key).get<std::string>(),
                      Message(description.string(), ": /", key));
  };
  if (document.contains("breathing")) session.breath = ReadBreathCsv(signal("breathing"), context);
  if (document.contains("commands")) {
    session.commands = ReadCommandsCsv(signal("commands"), context);
  }
  return session;
}

json SessionDescription(const StreamNames& streams, const std::string& name,
                        const std::string& reference_frame) {
  json document = {{"format", "acus-session/1"},
                   {"name", name},
                   {"reference_frame", reference_frame},
                   {"streams", json::array()}};
  if (streams.needle) document["streams"].push_back({{"tool", "needle"}, {"file", kNeedleFile}});
  if (streams.probe) document["streams"].push_back({{"tool", "probe"}, {"file", kProbeFile}});
  if (streams.breathing) document["breathing"] = kBreathingFile;
  if (streams.commands) document["commands"] = kCommandsFile;
  if (streams.tracker) document["tracker"] = kTrackerFile;
  return document;
}

void WriteSession(const fs::path& folder, const Session& session, const RunContext& context) {
  ACUS_REQUIRE(!session.needle.empty() || !session.probe.empty(), folder.string(),
               ": the session has neither needle nor probe samples; nothing is written");
  AtomicFolder output(folder, context.overwrite);
  if (!session.needle.empty()) WritePoseCsv(output.path() / kNeedleFile, session.needle);
  if (!session.probe.empty()) WritePoseCsv(output.path() / kProbeFile, session.probe);
  if (!session.breath.empty()) {
    std::string text = std::string(kBreathHeader) + '\n';
    for (const BreathSample& sample : session.breath) AppendBreathRow(text, sample);
    WriteAll(output.path() / kBreathingFile, text);
  }
  if (!session.commands.empty()) {
    std::string text = std::string(kCommandHeader) + '\n';
    for (const Command& command : session.commands) AppendCommandRow(text, command);
    WriteAll(output.path() / kCommandsFile, text);
  }
  config::WriteJson(output.path() / "session.json",
                    SessionDescription({.needle = !session.needle.empty(),
                                        .probe = !session.probe.empty(),
                                        .breathing = !session.breath.empty(),
                                        .commands = !session.commands.empty(),
                                        .tracker = false},
                                       session.name, session.reference_frame));
  config::WriteJson(output.path() / "provenance.json", context.provenance.ToJson());
  output.Commit();
}

}  // namespace acus::session
