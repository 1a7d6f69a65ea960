#include "acus/run/entry/commands.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iomanip>
#include <sstream>
#include <system_error>
#include <unistd.h>

#include "acus/base/core/error.h"

namespace acus::entry {
namespace {

namespace fs = std::filesystem;

constexpr Command kCommands[] = {
    {"phantom", CommandKind::kProgram, "Synthetic patients, CTs and sessions with exact truth"},
    {"segment", CommandKind::kProgram, "CT to tissues, skin and bone"},
    {"mesh", CommandKind::kProgram, "Tissues to a mesh, and its compliance"},
    {"breathing", CommandKind::kProgram, "4D CT to a motion model"},
    {"import", CommandKind::kProgram, "Recordings of other software to a session"},
    {"fit", CommandKind::kProgram, "Force curves to parameters of forces and tissue"},
    {"camera", CommandKind::kProgram, "Calibrate cameras, track facets"},
    {"register", CommandKind::kProgram, "Landmarks, tools and images to the CT"},
    {"replay", CommandKind::kProgram, "A session through a scenario: images, forces, report"},
    {"rf", CommandKind::kProgram, "Raw ultrasound data: simulate, read, beamform"},
    {"launcher", CommandKind::kProgram, "A window that starts sessions"},
    {"live", CommandKind::kProgram, "A session with devices and windows"},
    {"devices", CommandKind::kProgram, "Stand in for trackers and cameras"},
    {"compare", CommandKind::kProgram, "Two runs against tolerances"},
    {"regression", CommandKind::kProgram, "A suite of sessions against what is expected"},
    {"training", CommandKind::kProgram, "Trainees against the goals of an exercise"},
    {"study", CommandKind::kProgram, "Groups of trainees: plan, statistics, export"},
    {"dataset", CommandKind::kProgram, "Labelled images of many patients, for training"},
    {"tradeoff", CommandKind::kProgram, "What accuracy costs in time"},
    {"demo", CommandKind::kWorkflow, "From a CT to a report"},
    {"live-session", CommandKind::kWorkflow, "A training session from start to report"},
    {"training-day", CommandKind::kWorkflow, "A window for a day of sessions of many trainees"},
    {"papers", CommandKind::kWorkflow, "Figures and tables of the four papers"},
    {"cohort", CommandKind::kWorkflow, "Many patients, on one machine or on Slurm"},
    {"provenance", CommandKind::kWorkflow, "How a file of a cohort came about"},
    {"trends", CommandKind::kWorkflow, "Cohorts and suites over versions, as a page"},
    {"sweep", CommandKind::kWorkflow, "A sweep of accuracy and time, several runs at a time"},
    {"doctor", CommandKind::kWorkflow, "What is installed, and how fast this machine is"},
};

void AppendList(std::ostream& out, std::string_view headline, CommandKind kind) {
  out << headline << ":\n";
  for (const Command& command : kCommands) {
    if (command.kind != kind) continue;
    out << "  " << std::left << std::setw(14) << command.name << command.summary << '\n';
  }
}

}  // namespace

std::span<const Command> Commands() {
  return kCommands;
}

std::string CommandList() {
  std::ostringstream out;
  AppendList(out, "Programs (acus NAME is acus-NAME)", CommandKind::kProgram);
  AppendList(out, "Workflows", CommandKind::kWorkflow);
  return std::move(out).str();
}

fs::path FileOf(const Command& command, const fs::path& program) {
  const fs::path bin = program.parent_path();
  if (command.kind == CommandKind::kProgram) return bin / ("acus-" + std::string(command.name));
  return bin.parent_path() / "share" / "acus" / "pipelines" / command.name;
}

std::optional<Command> FindCommand(std::string_view name) {
  const auto* found = std::ranges::find(kCommands, name, &Command::name);
  if (found == std::end(kCommands)) return std::nullopt;
  return *found;
}

std::string Become(const Command& command, std::span<char* const> arguments) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error)
    return Message("/proc/self/exe: ", error.message(), "; other programs are found by it");
  // Workflows find their parts relative to their file, so links are resolved.
  const fs::path file = fs::weakly_canonical(FileOf(command, program), error);
  if (!fs::exists(file, error)) {
    return Message(file.string(), ": missing, but 'acus ", command.name,
                   "' runs it; install Acus whole, or build it");
  }
  std::string name = file.string();
  std::vector<char*> words = {name.data()};
  for (std::size_t i = 2; i < arguments.size(); ++i) words.push_back(arguments[i]);
  words.push_back(nullptr);
  ::execv(name.c_str(), words.data());
  return Message(name, ": cannot be run: ", std::strerror(errno));
}

}  // namespace acus::entry
