// Rules that hold for every source file, read as text.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kSourceRulesRoot = ACUS_SOURCE_DIR;
const std::set<std::string> kTopLevel = {"apps",
                                         "configs",
                                         "developer",
                                         "docs",
                                         "lib",
                                         "pipelines",
                                         "testdata",
                                         "tests",
                                         "CHANGELOG.md",
                                         "CITATION.cff",
                                         "CMakeLists.txt",
                                         "LICENSE",
                                         "CMakePresets.json",
                                         "CONTRIBUTING.md",
                                         "README.md"};

struct Line {
  fs::path file;
  int number = 0;
  std::string text;
  std::string Where() const { return file.string() + ":" + std::to_string(number); }
};

/// All lines of the text files under `folders`, by extension; empty for all extensions.
std::vector<Line> Lines(const std::vector<std::string>& folders,
                        const std::set<std::string>& extensions) {
  std::vector<fs::path> files;
  for (const std::string& folder : folders) {
    if (fs::is_regular_file(kSourceRulesRoot / folder)) files.push_back(kSourceRulesRoot / folder);
    if (!fs::is_directory(kSourceRulesRoot / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(kSourceRulesRoot / folder)) {
      const bool wanted =
          extensions.empty() || extensions.contains(entry.path().extension().string());
      if (entry.is_regular_file() && wanted) files.push_back(entry.path());
    }
  }
  std::vector<Line> lines;
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    Line line{.file = file.lexically_relative(kSourceRulesRoot), .number = 0, .text = ""};
    while (std::getline(in, line.text)) {
      ++line.number;
      if (line.text.find('\0') != std::string::npos) break;  // Not text.
      lines.push_back(line);
    }
  }
  return lines;
}

/// What of `line` is code: without a comment.
std::string Code(const std::string& line) {
  const auto comment = line.find("//");
  // A URL in a string is not a comment.
  if (comment == std::string::npos || (comment > 0 && line[comment - 1] == ':')) return line;
  return line.substr(0, comment);
}

TEST(SourceRules, NothingIsDrawnFromAGeneratorThatDependsOnLibraryOrThread) {
  const std::regex forbidden(
      R"re(\bs?rand\s*\(|random_device|mt19937|default_random_engine|std::\w+_distribution\b|(Vector|Matrix|Array)\w*::Random\b|\.setRandom\b)re");
  for (const Line& line : Lines({"lib", "apps"}, {".h", ".cpp"})) {
    EXPECT_FALSE(std::regex_search(Code(line.text), forbidden))
        << line.Where() << ": use RandomStream: " << line.text;
  }
}

TEST(SourceRules, ModelsNeverAskTheClock) {
  const std::regex clock(
      R"re(system_clock|steady_clock|gettimeofday|clock_gettime|MonotonicNs\s*\(|\btime\s*\(\s*(NULL|nullptr|0))re");
  // Progress, deadlines and reported timing; nothing is computed from them. And what runs devices:
  // tracking, haptics, live and the sources of camera stamp what comes from outside at its arrival,
  // simulators plays recordings, and window draws at a rate.
  const std::regex allowed(
      R"re(^lib/acus/base/core/(progress_bar|cpu_time|monotonic_time|child_process|stop_deadline|shared_library)\.|^lib/acus/scene/simulation/stage_timing\.|^lib/acus/rig/(tracking|haptics)/|^lib/acus/run/live/|^lib/acus/window/|^lib/acus/rig/camera/(frame_source|mannequin_images|image_streams|video_capture|newest_frames|camera_tracker)\.)re");
  for (const Line& line : Lines({"lib"}, {".h", ".cpp"})) {
    if (std::regex_search(line.file.string(), allowed)) continue;
    EXPECT_FALSE(std::regex_search(Code(line.text), clock))
        << line.Where() << ": time comes from the samples: " << line.text;
  }
}

TEST(SourceRules, TheLibraryIsSilent) {
  const std::regex prints(R"re(std::(cout|cerr|clog)\b|\bf?printf\s*\(|\bputs\s*\()re");
  const std::regex allowed(
      R"re(^lib/acus/base/core/(progress_bar|run_main|error|stop_deadline)\.)re");
  for (const Line& line : Lines({"lib"}, {".h", ".cpp"})) {
    if (std::regex_search(line.file.string(), allowed)) continue;
    EXPECT_FALSE(std::regex_search(Code(line.text), prints))
        << line.Where() << ": report through RunContext: " << line.text;
  }
}

TEST(SourceRules, ArithmeticIsNotRelaxed) {
  const std::regex relaxed(
      R"re(-ffast-math|-Ofast|-funsafe-math|-ffp-contract=(fast|on)|-march=native)re");
  for (const Line& line : Lines({"CMakeLists.txt", "lib", "apps", "pipelines", "developer"}, {})) {
    EXPECT_FALSE(std::regex_search(line.text, relaxed)) << line.Where() << ": " << line.text;
  }
  for (const Line& line : Lines({"tests"}, {".txt", ".cmake"})) {
    EXPECT_FALSE(std::regex_search(line.text, relaxed)) << line.Where() << ": " << line.text;
  }
}

TEST(SourceRules, TheRootHoldsOnlyWhatItShould) {
  for (const auto& entry : fs::directory_iterator(kSourceRulesRoot)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(".") || name.starts_with("build")) continue;
    EXPECT_TRUE(kTopLevel.contains(name)) << name << " does not belong into the root";
  }
}

TEST(SourceRules, NothingPointsIntoOneMachineOrToTheNetwork) {
  const std::regex machine(R"re((^|[\s"'=(:])/(work|home|root|mnt|media|srv|Users)/)re");
  const std::regex url(R"re(https?://([A-Za-z0-9.-]+))re");
  // Name spaces and citations: nothing is fetched from them.
  const std::set<std::string> allowed_hosts = {"json-schema.org", "www.w3.org", "doi.org",
                                               "w3id.org", "schema.org"};
  std::vector<std::string> folders(kTopLevel.begin(), kTopLevel.end());
  folders.emplace_back(".ci");
  std::erase(folders, "LICENSE");  // Its text is not ours, and names where it comes from.
  for (const Line& line : Lines(folders, {})) {
    EXPECT_FALSE(std::regex_search(line.text, machine)) << line.Where() << ": " << line.text;
    for (std::sregex_iterator match(line.text.begin(), line.text.end(), url), end; match != end;
         ++match) {
      EXPECT_TRUE(allowed_hosts.contains((*match)[1])) << line.Where() << ": " << line.text;
    }
  }
}

TEST(SourceRules, NothingIsMarkedAsUnfinished) {
  const std::regex unfinished(
      "\\b(TO"
      "DO|FIX"
      "ME|XX"
      "X|HA"
      "CK)\\b");
  std::vector<std::string> folders(kTopLevel.begin(), kTopLevel.end());
  for (const Line& line : Lines(folders, {})) {
    EXPECT_FALSE(std::regex_search(line.text, unfinished)) << line.Where() << ": " << line.text;
  }
}

TEST(SourceRules, ScriptsParse) {
  for (const char* folder : {"pipelines", "developer", ".ci", "tests/cli"}) {
    for (const auto& entry : fs::directory_iterator(kSourceRulesRoot / folder)) {
      std::ifstream in(entry.path());
      std::string first;
      std::getline(in, first);
      if (first.find("bash") == std::string::npos || !first.starts_with("#!")) continue;
      const std::string path = "'" + entry.path().string() + "'";
      EXPECT_EQ(std::system(("bash -n " + path).c_str()), 0) << path;
      EXPECT_EQ(std::system(("! command -v shellcheck >/dev/null || shellcheck " + path).c_str()),
                0)
          << path;
      const bool is_executable =
          (fs::status(entry.path()).permissions() & fs::perms::owner_exec) != fs::perms::none;
      EXPECT_TRUE(is_executable || entry.path().extension() == ".sh") << path << " cannot be run";
    }
  }
}

}  // namespace
