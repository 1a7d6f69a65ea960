// The options of acus-register, one group for each task.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "acus/patient/registration/tasks.h"

namespace CLI {
class App;
}

namespace acus::registration {

/// A subcommand, what it runs with the folder to make, and which options of the program it reads.
struct Command {
  CLI::App* app = nullptr;
  std::function<std::string(const std::filesystem::path& folder, RunContext& context)> run = {};
  std::vector<std::string> shared_options = {};
};

/// Adds the options of all tasks to the program; they write into what the result holds.
/// @param others  Subcommands of modules above this one, whose options `app` has already.
/// @returns runs the task that the command line chose: see Run().
std::function<std::string(RunContext& context)> AddTasks(CLI::App& app,
                                                         const std::vector<Command>& others = {});

}  // namespace acus::registration
