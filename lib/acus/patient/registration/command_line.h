// The options of acus-register, one group for each task.
#pragma once

#include <functional>
#include <string>

#include "acus/patient/registration/tasks.h"

namespace CLI {
class App;
}

namespace acus::registration {

/// Adds the options of all tasks to the program; they write into what the result holds.
/// @returns runs the task that the command line chose: see Run().
std::function<std::string(RunContext& context)> AddTasks(CLI::App& app);

}  // namespace acus::registration
