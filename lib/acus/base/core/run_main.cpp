#include "acus/base/core/run_main.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <iostream>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include "acus/base/core/progress_bar.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/version.h"
#include "acus/base/core/words.h"

namespace acus {
namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

extern "C" void RequestStop(int /*signal*/) {
  stop_requested.store(true);
}

std::string Quoted(std::string_view argument) {
  const bool plain = !argument.empty() && argument.find_first_of(" \t\n'\"\\$*?") == argument.npos;
  if (plain) return std::string(argument);
  std::string quoted = "'";
  for (const char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The long options of `app` and of its subcommands, and the subcommands' names.
void CollectWords(const CLI::App& app, std::vector<std::string>& options,
                  std::vector<std::string>& subcommands) {
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  }
  for (const CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; })) {
    subcommands.push_back(subcommand->get_name());
    CollectWords(*subcommand, options, subcommands);
  }
}

/// What is wrong with the command line. The parser complains of the first thing that is missing,
/// even where the cause is a mistyped word: that is looked for first.
std::string CommandLineProblem(const CLI::App& app, int argc, const char* const* argv,
                               const std::string& parser_says) {
  std::vector<std::string> options;
  std::vector<std::string> subcommands;
  CollectWords(app, options, subcommands);
  const auto is_known = [](const std::vector<std::string>& words, const std::string& word) {
    return std::ranges::find(words, word) != words.end();
  };
  const auto hint = [](const std::optional<std::string>& nearest) {
    return nearest ? " Did you mean " + *nearest + "?" : "";
  };
  for (int i = 1; i < argc; ++i) {
    const std::string given = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
    if (given == "--") break;
    if (given.starts_with("--") && !is_known(options, given)) {
      return "unknown option " + given + "." + hint(NearestSpelling(given, options));
    }
  }
  if (!subcommands.empty() && argc > 1 && argv[1][0] != '-' && !is_known(subcommands, argv[1])) {
    return Message("unknown command '", argv[1], "'; known: ", Joined(subcommands), ".",
                   hint(NearestSpelling(argv[1], subcommands)));
  }
  return parser_says;
}

/// Ctrl-C, a polite kill, and the end of the terminal - unless nohup said to outlive it.
void StopOnSignals() {
  std::signal(SIGINT, RequestStop);
  std::signal(SIGTERM, RequestStop);
  if (std::signal(SIGHUP, RequestStop) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

}  // namespace

int RunMain(CLI::App& app, int argc, const char* const* argv,
            const std::function<ExitCode(RunContext&)>& body) {
  RunContext context;
  bool quiet = false;
  context.num_threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  app.set_version_flag("--version", app.get_name() + " " + Version());
  app.add_option("--threads", context.num_threads, "Threads to use; results never depend on it")
      ->check(CLI::Range(1, 1024))
      ->default_str("all cores");
  app.add_option("--seed", context.seed, "Seed of everything that is drawn at random")
      ->check(CLI::Range(std::int64_t{0}, std::numeric_limits<std::int64_t>::max(), "0 or above"))
      ->capture_default_str();
  app.add_flag("--quiet", quiet, "No progress, only errors");
  app.add_flag("--overwrite", context.overwrite, "Replace an output folder made by an earlier run");
  // The standard options may also stand behind a subcommand.
  for (CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; })) {
    subcommand->fallthrough();
  }

  const std::string name = app.get_name();
  const auto fail = [&name](ExitCode code, std::string_view text) {
    std::cerr << name << ": " << text << '\n';
    return static_cast<int>(code);
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    return fail(ExitCode::kCommandLine, Message(CommandLineProblem(app, argc, argv, error.what()),
                                                "\nRun '", name, " --help' for the options."));
  }

  context.provenance.program = name;
  context.provenance.seed = context.seed;
  context.provenance.command_line = name;
  for (int i = 1; i < argc; ++i) context.provenance.command_line += " " + Quoted(argv[i]);

  stop_requested.store(false);
  StopOnSignals();
  context.stop = &stop_requested;
  ProgressBar bar(isatty(STDERR_FILENO) != 0);
  if (!quiet) {
    context.on_progress = [&bar](std::string_view task, double fraction) {
      bar.Show(task, fraction);
    };
    context.on_warning = [&](std::string_view text) {
      bar.Clear();
      std::cerr << name << ": warning: " << text << '\n';
    };
  }
  try {
    const ExitCode code = body(context);
    bar.Clear();
    return static_cast<int>(code);
  } catch (const Cancelled& error) {
    bar.Clear();
    return fail(ExitCode::kCancelled, error.what());
  } catch (const InputError& error) {
    bar.Clear();
    return fail(ExitCode::kInput, error.what());
  } catch (const NoAnswerError& error) {
    bar.Clear();
    return fail(ExitCode::kNoAnswer, error.what());
  } catch (const std::bad_alloc&) {
    bar.Clear();
    return fail(ExitCode::kInternal, "not enough memory for this input");
  } catch (const std::exception& error) {
    bar.Clear();
    return fail(ExitCode::kInternal, Message("unexpected error: ", error.what()));
  }
}

}  // namespace acus
