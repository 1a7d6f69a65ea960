#include "acus/base/core/run_main.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

#include "acus/base/core/enough_stack.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/progress_bar.h"
#include "acus/base/core/shown_path.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/stop_deadline.h"
#include "acus/base/core/temporaries.h"
#include "acus/base/core/version.h"
#include "acus/base/core/words.h"

namespace acus {
namespace {

constexpr std::size_t kMaxMessageBytes = 8000;
constexpr const char* kNoMemory =
    "not enough memory for this input; close other programs, or make the input smaller or coarser";
constexpr const char* kOutputLost =
    "standard output cannot be written: the disk is full, or its reader has ended; output files "
    "are "
    "complete";

std::string program_name;  ///< Set once, when a program starts.
std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

extern "C" void RequestStop(int /*signal*/) {
  stop_requested.store(true);
  NotifyStop();
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

/// A message for a terminal: no control characters that a file may have smuggled in, and not so
/// long that it hides what matters.
std::string Printable(std::string_view text) {
  std::size_t size = std::min(text.size(), kMaxMessageBytes);
  // Not in the middle of a character of UTF-8.
  while (size > 0 && size < text.size() &&
         (static_cast<unsigned char>(text[size]) & 0xC0U) == 0x80U) {
    --size;
  }
  std::string out(text.substr(0, size));
  for (char& c : out) {
    const auto code = static_cast<unsigned char>(c);
    if ((code < 0x20 && c != '\n' && c != '\t') || code == 0x7F) c = '?';
  }
  if (out.size() == text.size()) return out;
  return Message(out, "... (", text.size() - out.size(), " bytes omitted)");
}

/// What is thrown where the system refuses something: which file, and why.
std::string RefusalText(const std::filesystem::filesystem_error& error) {
  return Message(error.path1().string(), ": ", error.code().message());
}

/// The exit handlers of libraries are not called: that of OpenBLAS waits for its threads, for ever
/// where they get no memory (ulimit -v). Outputs are complete by then.
void EndWithoutExitHandlersOfLibraries() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  static const bool is_registered = ::on_exit(
                                        [](int status, void* /*argument*/) {
                                          std::fflush(nullptr);
                                          ::_exit(status);
                                        },
                                        nullptr) == 0;
  static_cast<void>(is_registered);
#endif
}

/// Memory that a thread of a library cannot get ends the program like that of the main thread. In a
/// live session the signal of abort() sets the forces to zero, so it stays.
[[noreturn]] void EndOnUncaughtException() {
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    if (!NoStopDeadline::IsAlive()) {
      std::fprintf(stderr, "%s: %s\n", program_name.c_str(), kNoMemory);
      RemoveTemporaries();
      ::_exit(static_cast<int>(ExitCode::kInput));
    }
  } catch (...) {  // Nothing is known of it.
  }
  std::abort();
}

/// OpenCV and ITK have exceptions of their own for it.
bool SaysNoMemory(const std::exception& error) {
  const std::string_view what = error.what();
  return what.find("Insufficient memory") != std::string_view::npos ||
         what.find("Failed to allocate memory") != std::string_view::npos;
}

bool StandardOutputIsWritten() {
  std::cout.flush();
  return std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
}

/// Ctrl-C, a polite kill, and the end of the terminal - unless nohup said to outlive it.
void StopOnSignals() {
  std::signal(SIGINT, RequestStop);
  std::signal(SIGTERM, RequestStop);
  if (std::signal(SIGHUP, RequestStop) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);  // A reader that has gone is a failed write, not a death.
}

/// Calls `body`; what it throws becomes what `fail` makes of it.
int CodeOf(const std::function<ExitCode()>& body,
           const std::function<int(ExitCode, std::string_view)>& fail) {
  try {
    return static_cast<int>(body());
  } catch (const Cancelled& error) {
    return fail(ExitCode::kCancelled, error.what());
  } catch (const InputError& error) {
    return fail(ExitCode::kInput, error.what());
  } catch (const NoAnswerError& error) {
    return fail(ExitCode::kNoAnswer, error.what());
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::kInput, kNoMemory);
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(ExitCode::kInput, RefusalText(error));
  } catch (const std::system_error& error) {
    const bool is_limit = error.code() == std::errc::resource_unavailable_try_again;
    return is_limit ? fail(ExitCode::kInput,
                           "no thread can be started; memory or the number of threads is limited "
                           "(ulimit -v, ulimit -u)")
                    : fail(ExitCode::kInternal, Message("unexpected error: ", error.what()));
  } catch (const std::exception& error) {
    return SaysNoMemory(error)
               ? fail(ExitCode::kInput, kNoMemory)
               : fail(ExitCode::kInternal, Message("unexpected error: ", error.what()));
  }
}

}  // namespace

int RunMain(CLI::App& app, int argc, const char* const* argv,
            const std::function<ExitCode(RunContext&)>& body) {
  stop_requested.store(false);
  StopOnSignals();
  EndWithoutExitHandlersOfLibraries();
  program_name = app.get_name();
  std::set_terminate(EndOnUncaughtException);
  RunContext context;
  bool quiet = false;
  bool no_folders = false;
  std::optional<double> memory_gb;
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
  app.add_option("--memory-gb", memory_gb,
                 "Memory that one input file may take, GB; by default half of what is free")
      ->check(CLI::Range(0.001, 1e6));
  app.add_flag("--no-folders", no_folders,
               "Leave the folders of files out of what is written: names only");
  // The standard options may also stand behind a subcommand.
  for (CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; })) {
    subcommand->fallthrough();
  }

  const std::string name = app.get_name();
  const auto fail = [&name](ExitCode code, std::string_view text) {
    std::cerr << name << ": " << Printable(text) << '\n';
    return static_cast<int>(code);
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    const int code = app.exit(success);
    return StandardOutputIsWritten() ? code : fail(ExitCode::kInput, kOutputLost);
  } catch (const CLI::ParseError& error) {
    return fail(ExitCode::kCommandLine, Message(CommandLineProblem(app, argc, argv, error.what()),
                                                "\nRun '", name, " --help' for the options."));
  }

  context.provenance.program = name;
  context.provenance.seed = context.seed;
  context.provenance.command_line = name;
  ShowFolders(!no_folders);
  for (int i = 1; i < argc; ++i)
    context.provenance.command_line += " " + Quoted(ShownWord(argv[i]));

  context.stop = &stop_requested;
  SetInputMemory(memory_gb);
  ProgressBar bar(isatty(STDERR_FILENO) != 0);
  if (!quiet) {
    context.on_progress = [&bar](std::string_view task, double fraction) {
      bar.Show(task, fraction);
    };
    context.on_warning = [&](std::string_view text) {
      bar.Clear();
      std::cerr << name << ": warning: " << Printable(text) << '\n';
    };
  }
  int code = 0;
  CallWithEnoughStack([&] {
    const StopDeadline deadline(name);
    code = CodeOf([&] { return body(context); },
                  [&](ExitCode failure, std::string_view text) {
                    bar.Clear();
                    return fail(failure, text);
                  });
  });
  bar.Clear();
  if (code == 0 && !StandardOutputIsWritten()) return fail(ExitCode::kInput, kOutputLost);
  return code;
}

}  // namespace acus
