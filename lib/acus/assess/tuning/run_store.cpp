#include "acus/assess/tuning/run_store.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/provenance.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kPlan = "plan.json";
/// The prefix of AtomicFile for unfinished files: .partial-PROCESS-NUMBER-NAME
constexpr std::string_view kPartial = ".partial-";

/// True if the folder does not exist, or another process has just begun to create the store in it.
bool IsFree(const fs::path& folder) {
  if (!fs::exists(folder)) return true;
  if (!fs::is_directory(folder)) return false;
  return std::ranges::all_of(fs::directory_iterator(folder), [](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    return name == kPlan || name == "runs" || name == "references" || name.starts_with(kPartial);
  });
}

/// "/seconds: 2 there, 5 now": the first difference of two plans.
std::string FirstDifference(const json& there, const json& now) {
  for (const json& change : json::diff(there, now)) {
    const std::string path = change.at("path");
    const json::json_pointer pointer(path);
    const auto text = [&pointer](const json& plan) {
      if (!plan.contains(pointer)) return std::string("nothing");
      std::string value = plan.at(pointer).dump();
      if (value.size() > 80) value = value.substr(0, 77) + "...";
      return value;
    };
    return Message(path, ": ", text(there), " there, ", text(now), " now");
  }
  return "they are the same";
}

/// The build in a plan.
std::string BuildOf(const json& plan) {
  return plan.is_object() && plan.contains("build") ? plan["build"].dump() : "an unnamed one";
}

}  // namespace

RunStore::RunStore(fs::path folder, const json& plan, bool overwrite) : folder_(std::move(folder)) {
  const fs::path plan_file = folder_ / kPlan;
  const bool has_plan = fs::is_regular_file(plan_file);
  ACUS_REQUIRE(has_plan || IsFree(folder_), folder_.string(),
               ": exists and is no folder of a sweep (it has no ", kPlan, "); name another one");
  if (has_plan && overwrite) fs::remove_all(folder_);
  if (!fs::exists(plan_file)) config::WriteJson(plan_file, plan);
  const json there = config::ReadJson(plan_file);
  // As written: names of files may contain bytes that JSON may not.
  const json now = json::parse(plan.dump(-1, ' ', false, json::error_handler_t::replace));
  ACUS_REQUIRE(BuildOf(there) == BuildOf(now), folder_.string(),
               ": holds runs of another build of Acus (", BuildOf(there), " there, ", BuildOf(now),
               " now), whose errors and times may differ; continue with the build that made them, "
               "name another folder, or replace it with --overwrite");
  ACUS_REQUIRE(there == now, folder_.string(), ": holds the runs of another sweep (",
               FirstDifference(there, now),
               "); name another folder, or replace it with --overwrite");
  std::error_code failed;
  for (const char* name : {"runs", "references"}) {
    fs::create_directories(folder_ / name, failed);
    ACUS_REQUIRE(!failed, (folder_ / name).string(), ": cannot be made: ", failed.message());
  }
}

std::optional<Measured> RunStore::Find(const std::string& case_name) const {
  const fs::path file = folder_ / "runs" / (case_name + ".json");
  if (!fs::is_regular_file(file)) return std::nullopt;
  return RunFromText(ReadTextFile(file));
}

void RunStore::Keep(const std::string& case_name, const Measured& measured) const {
  WriteTextFile(folder_ / "runs" / (case_name + ".json"), RunText(measured));
}

void RunStore::Forget(const std::string& case_name) const {
  fs::remove(folder_ / "runs" / (case_name + ".json"));
}

void RunStore::Tidy() const {
  for (const char* name : {"", "runs", "references"}) {
    for (const auto& entry : fs::directory_iterator(folder_ / name)) {
      const std::string file = entry.path().filename().string();
      int process = 0;
      if (!file.starts_with(kPartial)) continue;
      std::from_chars(file.data() + kPartial.size(), file.data() + file.size(), process);
      std::error_code ignored;
      const bool alive = process <= 0 || ::kill(process, 0) == 0 || errno != ESRCH;
      if (!alive) fs::remove_all(entry.path(), ignored);
    }
  }
}

fs::path RunStore::ReferenceFile(const std::string& reference_name) const {
  return folder_ / "references" / (reference_name + ".bin");
}

std::string RunText(const Measured& measured) {
  const std::string body = ToJson(measured).dump();
  return Message("{\"sha256\": \"", Sha256OfText(body), "\", \"run\": ", body, "}\n");
}

std::optional<Measured> RunFromText(const std::string& text) {
  // Prefix, 64 digits, infix, body, suffix: the sum is over the unchanged bytes.
  const std::string prefix = "{\"sha256\": \"";
  const std::string infix = "\", \"run\": ";
  const std::size_t body_at = prefix.size() + 64 + infix.size();
  if (text.size() < body_at + 2 || !text.starts_with(prefix) || !text.ends_with("}\n") ||
      text.compare(prefix.size() + 64, infix.size(), infix) != 0) {
    return std::nullopt;
  }
  const std::string body = text.substr(body_at, text.size() - body_at - 2);
  if (Sha256OfText(body) != text.substr(prefix.size(), 64)) return std::nullopt;
  const json document = json::parse(body, nullptr, /*allow_exceptions=*/false);
  if (document.is_discarded()) return std::nullopt;
  return MeasuredFromJson(document, "run");
}

}  // namespace acus::tuning
