// acus: all programs and workflows under one name, and their presets.
#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>
#include <span>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/base/core/text_table.h"
#include "acus/run/entry/commands.h"
#include "acus/run/entry/presets.h"

namespace {

void PrintKinds(const std::filesystem::path& configs, bool names) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& kind : acus::entry::PresetKinds(configs)) {
    rows.push_back({kind, std::to_string(acus::entry::PresetsOf(configs, kind).size())});
    if (names) std::cout << kind << '\n';
  }
  if (!names) std::cout << acus::TextTable({"kind", "presets"}, rows);
}

void PrintPresets(const std::filesystem::path& configs, const std::string& kind, bool names) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& preset : acus::entry::PresetsOf(configs, kind)) {
    rows.push_back({preset.name, preset.summary});
    if (names) std::cout << preset.name << '\n';
  }
  if (!names) std::cout << acus::TextTable({"preset", "what it is"}, rows);
}

/// The command that the first word names: it takes the place of this program.
std::optional<acus::entry::Command> NamedCommand(std::span<char* const> arguments) {
  return arguments.size() < 2 ? std::nullopt : acus::entry::FindCommand(arguments[1]);
}

}  // namespace

int main(int argc, char** argv) {
  const std::span<char* const> arguments(argv, static_cast<std::size_t>(argc));
  if (const auto command = NamedCommand(arguments)) {
    const std::string problem = acus::entry::Become(*command, arguments);
    std::cerr << "acus: " << problem << '\n';
    return static_cast<int>(acus::ExitCode::kCommandLine);
  }
  std::string kind;
  bool names = false;
  CLI::App app{"Ultrasound-guided needle insertion, simulated: every program by one name.", "acus"};
  app.require_subcommand(1);
  CLI::App* list = app.add_subcommand("list", "Print the presets that come with Acus");
  list->add_option("kind", kind, "Presets of this kind; without it the kinds");
  list->add_flag("--names", names, "Only names, one a line");
  // They never get here; a mistyped one finds its name among them.
  for (const auto& command : acus::entry::Commands()) {
    app.add_subcommand(std::string(command.name))->group("");
  }
  app.footer(acus::entry::CommandList() +
             "\n'acus COMMAND --help' explains each.\n\n"
             "EXAMPLE\n"
             "  acus list needles\n"
             "  acus doctor\n"
             "  acus phantom patient lumbar -o patient");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext&) {
    const auto configs = acus::config::ConfigsFolder();
    kind.empty() ? PrintKinds(configs, names) : PrintPresets(configs, kind, names);
    return acus::ExitCode::kOk;
  });
}
