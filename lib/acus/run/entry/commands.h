// The commands of `acus`: its programs and workflows under one name.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace acus::entry {

enum class CommandKind {
  kProgram,   ///< acus-NAME, beside the running program.
  kWorkflow,  ///< ../share/acus/pipelines/NAME beside it: several programs in order.
};

struct Command {
  std::string_view name;
  CommandKind kind;
  std::string_view summary;  ///< One line for a list, without a full stop.
};

/// All commands, programs first, each kind in the order of its use.
std::span<const Command> Commands();

/// "NAME  summary" for each, under a headline for each kind.
std::string CommandList();

/// The file that `command` runs. @param program  Path of the running program, as the system gives
/// it.
std::filesystem::path FileOf(const Command& command, const std::filesystem::path& program);

/// The command of that name; nothing if there is none.
std::optional<Command> FindCommand(std::string_view name);

/// Replaces the process by `command`, with the arguments of the running program from the second on.
/// Returns only on failure: the reason.
std::string Become(const Command& command, std::span<char* const> arguments);

}  // namespace acus::entry
