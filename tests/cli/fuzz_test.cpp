// Whole programs on broken files: each must end with a right exit code, one message, and nothing
// left behind. Mutations are drawn from a seed, so that a failure can be made again.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "acus/base/core/random.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using Bytes = std::string;

constexpr auto kTimeout = std::chrono::seconds(60);
constexpr int kTruncations = 8;
constexpr int kFlips = 8;

/// One way into a program. `copied` (a file or folder of the small patient) is copied into a fresh
/// folder, `broken` (in it) is mutated, and the words of `command` are run there.
struct Entrance {
  const char* name;
  std::vector<const char*> copied;
  const char* broken;
  std::string command;
};

void PrintTo(const Entrance& entrance, std::ostream* out) {
  *out << entrance.name;
}

const std::vector<const char*> kReplayed = {"scenario.json", "session", "ct.nrrd",
                                            "labels.seg.nrrd", "ct_from_reference.tfm"};
const char* const kReplay =
    "acus-replay scenario.json session --ct ct.nrrd --labels labels.seg.nrrd "
    "--transform ct_from_reference.tfm --no-film --png none -o out";

const std::vector<const char*> kCompared = {"reference_run", "new_run"};
const char* const kCompare = "acus-compare reference_run new_run --complete";

const Entrance kEntrances[] = {
    {"phantom_config",
     {"phantom.json"},
     "phantom.json",
     "acus-phantom patient lumbar --config phantom.json -o out"},
    {"phantom_scene",
     {"labels.seg.nrrd"},
     "labels.seg.nrrd",
     "acus-phantom scene labels.seg.nrrd -o out"},
    {"register_csv",
     {"markers_mannequin.csv", "markers_ct.csv"},
     "markers_ct.csv",
     "acus-register --from markers_mannequin.csv --to markers_ct.csv -o out"},
    {"register_target",
     {"markers_mannequin.csv", "markers_ct.csv", "target_ct.csv"},
     "target_ct.csv",
     "acus-register --from markers_mannequin.csv --to markers_ct.csv --target target_ct.csv -o "
     "out"},
    {"register_pivot",
     {"poses"},
     "poses/pose_03.txt",
     "acus-register pivot poses/pose_03.txt poses -o out"},
    {"segment_ct", {"ct.nrrd"}, "ct.nrrd", "acus-segment ct.nrrd -o out"},
    {"segment_config",
     {"ct.nrrd", "segmentation.json"},
     "segmentation.json",
     "acus-segment ct.nrrd --config segmentation.json -o out"},
    {"mesh_labels",
     {"labels.seg.nrrd", "coarse_mesh.json"},
     "labels.seg.nrrd",
     "acus-mesh labels.seg.nrrd --config coarse_mesh.json -o out"},
    {"mesh_config",
     {"labels.seg.nrrd", "coarse_mesh.json"},
     "coarse_mesh.json",
     "acus-mesh labels.seg.nrrd --config coarse_mesh.json -o out"},
    {"mesh_surface", {"block.stl"}, "block.stl", "acus-mesh --surface block.stl -o out"},
    {"mesh_tetrahedra",
     {"box.vtu"},
     "box.vtu",
     "acus-mesh --mesh box.vtu --condense --corridor-from 7,7,25 --corridor-to 7,7,10 -o out"},
    {"fit_curve",
     {"force_curves/skin_and_fascia_1.csv"},
     "force_curves/skin_and_fascia_1.csv",
     "acus-fit force_curves/skin_and_fascia_1.csv --models none -o out"},
    {"replay_scenario", kReplayed, "scenario.json", kReplay},
    {"replay_needle", kReplayed, "session/needle.csv", kReplay},
    {"replay_session", kReplayed, "session/session.json", kReplay},
    {"replay_ct", kReplayed, "ct.nrrd", kReplay},
    {"replay_labels", kReplayed, "labels.seg.nrrd", kReplay},
    {"replay_transform", kReplayed, "ct_from_reference.tfm", kReplay},
    {"dataset_config",
     {"dataset.json", "scenario.json", "ct.nrrd", "labels.seg.nrrd", "corridor_ct.csv"},
     "dataset.json",
     "acus-dataset dataset.json -o out"},
    {"compare_forces", kCompared, "new_run/forces.csv", kCompare},
    {"compare_images", kCompared, "new_run/images.igs.mha", kCompare},
    {"compare_metrics", kCompared, "new_run/metrics.json", kCompare},
};

fs::path Inputs() {
  return fs::path(ACUS_BUILD_DIR) / "tests" / "cli" / "inputs";
}

Bytes ReadBytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void WriteBytes(const fs::path& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

struct Mutation {
  std::string name;
  Bytes bytes;
};

/// Half of the flips go into the first KiB, where headers are: elsewhere they only change values.
Bytes Flipped(Bytes bytes, RandomStream& random) {
  const int count = 1 + static_cast<int>(random.Uniform(0.0, 8.0));
  for (int i = 0; i < count; ++i) {
    const std::size_t span =
        random.Uniform() < 0.5 ? std::min<std::size_t>(1024, bytes.size()) : bytes.size();
    const auto at = static_cast<std::size_t>(random.Uniform() * static_cast<double>(span));
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << static_cast<int>(random.Uniform(0.0, 8.0))));
  }
  return bytes;
}

std::vector<Mutation> Mutations(const std::string& name, const Bytes& valid) {
  std::vector<Mutation> mutations = {{"empty", ""},
                                     {"words", "These are words.\n"},
                                     {"zeros", Bytes(4096, '\0')},
                                     {"image", "\x89PNG\r\n\x1a\n" + Bytes(100, 'x')}};
  for (int i = 0; i < kTruncations; ++i) {
    RandomStream random(1, "truncate " + name, static_cast<std::uint64_t>(i));
    const auto size =
        static_cast<std::size_t>(random.Uniform(0.0, static_cast<double>(valid.size())));
    mutations.push_back({"cut to " + std::to_string(size), valid.substr(0, size)});
  }
  for (int i = 0; i < kFlips; ++i) {
    RandomStream random(1, "flip " + name, static_cast<std::uint64_t>(i));
    mutations.push_back({"flips " + std::to_string(i), Flipped(valid, random)});
  }
  return mutations;
}

std::set<fs::path> Listing(const fs::path& folder) {
  std::set<fs::path> paths;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) paths.insert(entry.path());
  return paths;
}

struct Outcome {
  int exit_code = -1;  ///< 128 + signal if it was killed.
  bool timed_out = false;
  std::string messages;
};

/// Runs `command` in `folder`; its output goes to files beside the folder.
Outcome RunIn(const fs::path& folder, const std::string& command) {
  const fs::path log = folder.string() + ".stderr";
  const pid_t child = fork();
  if (child == 0) {
    setpgid(0, 0);
    const std::string line = "cd '" + folder.string() + "' && exec " + std::string(ACUS_BUILD_DIR) +
                             "/bin/" + command + " >/dev/null 2>'" + log.string() + "' </dev/null";
    execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    _exit(127);
  }
  Outcome outcome;
  int status = 0;
  const auto end = std::chrono::steady_clock::now() + kTimeout;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) {
      outcome.timed_out = true;
      kill(-child, SIGKILL);
      waitpid(child, &status, 0);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.messages = ReadBytes(log);
  return outcome;
}

/// Lines that begin with the program's name and are not warnings.
int NumMessages(const std::string& text, const std::string& program) {
  std::istringstream in(text);
  int count = 0;
  for (std::string line; std::getline(in, line);) {
    count += line.starts_with(program + ": ") && !line.starts_with(program + ": warning: ");
  }
  return count;
}

/// Runs one entrance in a fresh folder, after `change` has been made to its broken file.
void Check(const Entrance& entrance, const std::string& what,
           const std::function<void(const fs::path&)>& change, const std::set<int>& allowed,
           const std::string& message = "") {
  // One folder for each test, since tests run side by side.
  std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  std::ranges::replace(test, '/', '.');
  const fs::path folder = fs::path(ACUS_BUILD_DIR) / "tests" / "cli" / "fuzz" / test;
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (const char* name : entrance.copied) {
    fs::create_directories((folder / name).parent_path());
    fs::copy(Inputs() / name, folder / name, fs::copy_options::recursive);  // Follows links.
  }
  change(folder / entrance.broken);
  const auto before = Listing(folder);
  const Outcome outcome = RunIn(folder, entrance.command);
  const std::string program = entrance.command.substr(0, entrance.command.find(' '));

  SCOPED_TRACE(what + ": " + entrance.command + "\n" + outcome.messages.substr(0, 2000));
  EXPECT_FALSE(outcome.timed_out);
  EXPECT_NE(outcome.messages.find(message), std::string::npos) << "the message lacks " << message;
  EXPECT_TRUE(allowed.contains(outcome.exit_code)) << "exit code " << outcome.exit_code;
  if (outcome.exit_code != 0) {
    EXPECT_EQ(NumMessages(outcome.messages, program), 1);
    EXPECT_EQ(Listing(folder), before) << "something was left behind";
  } else {
    for (const auto& path : Listing(folder)) {
      EXPECT_EQ(path.string().find(".partial"), std::string::npos) << path;
    }
  }
}

/// Changes the cell at a row and column (0-based, header excluded) of a CSV file.
Bytes WithCell(const Bytes& csv, int row, int column, const std::string& text) {
  std::istringstream in(csv);
  Bytes out;
  int number = -1;
  for (std::string line; std::getline(in, line); ++number) {
    if (number == row) {
      std::size_t begin = 0;
      for (int i = 0; i < column; ++i) begin = line.find(',', begin) + 1;
      line.replace(begin, line.find(',', begin) - begin, text);
    }
    out += line + "\n";
  }
  return out;
}

TEST(SessionFuzz, WhatCannotBeIsNamedByFileAndRow) {
  const Entrance entrance{"replay_needle_rows", kReplayed, "session/needle.csv", kReplay};
  const Bytes valid = ReadBytes(Inputs() / entrance.broken);
  const struct {
    const char* what;
    int column;
    const char* text;
  } kCells[] = {{"time goes backwards", 0, "0.0001"},  {"time is NaN", 0, "nan"},
                {"position is NaN", 1, "nan"},         {"position is infinite", 2, "inf"},
                {"position is too large", 3, "1e999"}, {"quaternion is not of length 1", 4, "3.5"},
                {"quaternion is NaN", 7, "NaN"},       {"status is unknown", 8, "PERHAPS"},
                {"cell is a word", 2, "ten"}};
  for (const auto& cell : kCells) {
    Check(
        entrance, cell.what,
        [&](const fs::path& file) {
          WriteBytes(file, WithCell(valid, 99, cell.column, cell.text));
        },
        {3}, "session/needle.csv:101: ");
  }
}

class ProgramFuzz : public testing::TestWithParam<Entrance> {};

TEST_P(ProgramFuzz, TheValidFileIsTaken) {
  Check(GetParam(), "valid", [](const fs::path&) {}, {0});
}

TEST_P(ProgramFuzz, AMissingFileIsNamed) {
  Check(GetParam(), "missing", [](const fs::path& file) { fs::remove(file); }, {2, 3, 4});
}

TEST_P(ProgramFuzz, ABrokenFileNeverCrashesNorLeavesAnything) {
  const Bytes valid = ReadBytes(Inputs() / GetParam().broken);
  ASSERT_FALSE(valid.empty()) << GetParam().broken;
  for (const Mutation& mutation : Mutations(GetParam().name, valid)) {
    // Cut or flipped files can still be valid; the others cannot.
    const bool may_be_valid = mutation.name.starts_with("flip") || mutation.name.starts_with("cut");
    Check(
        GetParam(), mutation.name, [&](const fs::path& file) { WriteBytes(file, mutation.bytes); },
        may_be_valid ? std::set{0, 2, 3, 4} : std::set{2, 3});
    if (HasFailure()) return;
  }
}

std::string NameOf(const testing::TestParamInfo<Entrance>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Programs, ProgramFuzz, testing::ValuesIn(kEntrances), NameOf);

}  // namespace
}  // namespace acus
