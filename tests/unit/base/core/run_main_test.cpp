#include "acus/base/core/run_main.h"

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <gmock/gmock.h>
#include <iostream>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace acus {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

struct Result {
  int code = -1;
  std::string stdout_text;
  std::string stderr_text;
};

/// A program with one needed file, and a subcommand if asked for.
Result RunThing(std::vector<const char*> arguments, bool with_subcommand,
                const std::function<ExitCode(RunContext&)>& body) {
  CLI::App app{"Does a thing", "acus-thing"};
  std::string file;
  if (with_subcommand) {
    app.require_subcommand(1);
    app.add_subcommand("patient", "")->add_option("--depth_mm", file, "");
    app.add_subcommand("scene", "");
  } else {
    app.add_option("FILE", file, "What to read")->required();
  }
  arguments.insert(arguments.begin(), "acus-thing");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Result result;
  result.code = RunMain(app, static_cast<int>(arguments.size()), arguments.data(), body);
  result.stdout_text = testing::internal::GetCapturedStdout();
  result.stderr_text = testing::internal::GetCapturedStderr();
  return result;
}

Result RunThing(std::vector<const char*> arguments,
                const std::function<ExitCode(RunContext&)>& body) {
  return RunThing(std::move(arguments), false, body);
}

ExitCode Nothing(RunContext& /*context*/) {
  return ExitCode::kOk;
}

template <typename Error>
Result RunThrowing(const Error& error) {
  return RunThing({"in.csv"}, [&](RunContext&) -> ExitCode { throw error; });
}

TEST(RunMain, TurnsEachKindOfErrorIntoItsExitCodeAndOneMessage) {
  EXPECT_EQ(RunThrowing(InputError("a.csv:3: no")).code, 3);
  EXPECT_EQ(RunThrowing(InputError("a.csv:3: no")).stderr_text, "acus-thing: a.csv:3: no\n");
  EXPECT_EQ(RunThrowing(NoAnswerError("did not converge")).code, 4);
  EXPECT_EQ(RunThrowing(std::runtime_error("what?")).code, 1);
  EXPECT_THAT(RunThrowing(std::runtime_error("what?")).stderr_text, HasSubstr("unexpected"));
  EXPECT_EQ(RunThrowing(std::bad_alloc()).code, 3);
  EXPECT_THAT(RunThrowing(std::bad_alloc()).stderr_text, HasSubstr("memory"));
  EXPECT_EQ(RunThrowing(Cancelled()).code, 130);
}

// What OpenCV and ITK throw in place of std::bad_alloc.
TEST(RunMain, KnowsTheLibrariesWordsForTooLittleMemory) {
  const std::string wanted = RunThrowing(std::bad_alloc()).stderr_text;
  for (const char* text :
       {"OpenCV(4.6.0) alloc.cpp:73: error: (-4:Insufficient memory) Failed to allocate 2132040 "
        "bytes in function 'OutOfMemoryError'",
        "Failed to allocate memory for image."}) {
    EXPECT_EQ(RunThrowing(std::runtime_error(text)).code, 3);
    EXPECT_EQ(RunThrowing(std::runtime_error(text)).stderr_text, wanted);
  }
}

TEST(RunMain, TakesWhatTheSystemRefusesForAnInputError) {
  const auto loop = std::make_error_code(std::errc::too_many_symbolic_link_levels);
  const Result files = RunThrowing(std::filesystem::filesystem_error("status", "a.json", loop));
  EXPECT_EQ(files.code, 3);
  EXPECT_EQ(files.stderr_text, "acus-thing: a.json: Too many levels of symbolic links\n");
  const auto again = std::make_error_code(std::errc::resource_unavailable_try_again);
  const Result threads = RunThrowing(std::system_error(again));
  EXPECT_EQ(threads.code, 3);
  EXPECT_THAT(threads.stderr_text, HasSubstr("thread"));
  EXPECT_EQ(RunThrowing(std::system_error(loop)).code, 1);
}

TEST(RunMain, PrintsNoMegabytesAndNoControlCharacters) {
  const Result result =
      RunThrowing(InputError("a.csv: '\x1b[2J\r\x7f" + std::string(5'000'000, 'x')));
  EXPECT_LT(result.stderr_text.size(), 8200U);
  EXPECT_THAT(result.stderr_text, StartsWith("acus-thing: a.csv: '?[2J??xxx"));
  EXPECT_THAT(result.stderr_text, HasSubstr("bytes omitted)\n"));
  std::string umlauts = "a";
  for (int i = 0; i < 8000; ++i) umlauts += "\xc3\xa4";
  const std::string cut = RunThrowing(InputError(umlauts)).stderr_text;
  EXPECT_NE(cut.find("\xc3\xa4... ("), cut.npos) << "cut inside a character";
}

/// Ends the process as a program does, with what RunMain returns.
[[noreturn]] void ExitLikeAProgram(const std::function<ExitCode(RunContext&)>& body) {
  CLI::App app{"Does a thing", "acus-thing"};
  const char* const arguments[] = {"acus-thing"};
  std::exit(RunMain(app, 1, arguments, body));
}

[[noreturn]] void PrintToAFullDisk() {
  static_cast<void>(std::freopen("/dev/full", "w", stdout));
  ExitLikeAProgram([](RunContext&) {
    std::cout << "result\n";
    return ExitCode::kOk;
  });
}

[[noreturn]] void ExitWithALibraryThatHangs() {
  std::atexit([] { std::_Exit(77); });
  ExitLikeAProgram([](RunContext&) { return ExitCode::kNoAnswer; });
}

TEST(RunMainDeathTest, FailsWhereStandardOutputCannotBeWritten) {
  EXPECT_EXIT(PrintToAFullDisk(), ::testing::ExitedWithCode(3),
              "standard output cannot be written");
}

TEST(RunMainDeathTest, EndsWithoutTheExitHandlersOfLibraries) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers report in such a handler";
#endif
  EXPECT_EXIT(ExitWithALibraryThatHangs(), ::testing::ExitedWithCode(4), "");
}

[[noreturn]] void LackMemoryInAThread() {
  ExitLikeAProgram([](RunContext&) {
    std::thread([] { throw std::bad_alloc(); }).join();
    return ExitCode::kOk;
  });
}

TEST(RunMainDeathTest, TakesMemoryThatAThreadLacksForAnInputError) {
  EXPECT_EXIT(LackMemoryInAThread(), ::testing::ExitedWithCode(3), "acus-thing: not enough memory");
}

TEST(RunMain, OmitsFoldersFromTheCommandLineIfRequested) {
  const Result result = RunThing({"patients/Jane/in.csv", "--no-folders"}, [](RunContext& context) {
    EXPECT_EQ(context.provenance.command_line, "acus-thing in.csv --no-folders");
    return ExitCode::kOk;
  });
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(RunThing({"Jane/in.csv"},
                     [](RunContext& context) {
                       EXPECT_EQ(context.provenance.command_line, "acus-thing Jane/in.csv");
                       return ExitCode::kOk;
                     })
                .code,
            0);
}

TEST(RunMain, GivesTheStandardOptionsToTheBody) {
  const Result result = RunThing({"in.csv", "--threads", "3", "--seed", "42", "--overwrite"},
                                 [](RunContext& context) {
                                   EXPECT_EQ(context.num_threads, 3);
                                   EXPECT_EQ(context.seed, 42U);
                                   EXPECT_EQ(context.provenance.seed, 42U);
                                   EXPECT_TRUE(context.overwrite);
                                   EXPECT_EQ(context.provenance.command_line,
                                             "acus-thing in.csv --threads 3 --seed 42 --overwrite");
                                   return ExitCode::kOk;
                                 });
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.stderr_text, "");
}

TEST(RunMain, TakesTheStandardOptionsBehindASubcommandToo) {
  const Result result = RunThing({"patient", "--seed", "7"}, true, [](RunContext& context) {
    EXPECT_EQ(context.seed, 7U);
    return ExitCode::kOk;
  });
  EXPECT_EQ(result.code, 0) << result.stderr_text;
}

TEST(RunMain, RefusesAWrongCommandLineWithAHint) {
  const Result missing = RunThing({}, Nothing);
  EXPECT_EQ(missing.code, 2);
  EXPECT_THAT(missing.stderr_text,
              AllOf(StartsWith("acus-thing: FILE is required"), HasSubstr("acus-thing --help")));
  EXPECT_EQ(RunThing({"in.csv", "--threads", "0"}, Nothing).code, 2);
  EXPECT_EQ(RunThing({"in.csv", "--threads", "1025"}, Nothing).code, 2);
  EXPECT_EQ(RunThing({"in.csv", "--seed", "-1"}, Nothing).code, 2);
  EXPECT_EQ(RunThing({"in.csv", "--threads", "two"}, Nothing).code, 2);
}

TEST(RunMain, NamesTheMistypedOptionRatherThanWhatTheParserMissed) {
  const Result result = RunThing({"--overwite"}, Nothing);
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.stderr_text,
              AllOf(HasSubstr("unknown option --overwite"), HasSubstr("Did you mean --overwrite?"),
                    Not(HasSubstr("required"))));
  EXPECT_THAT(RunThing({"in.csv", "--zzzz"}, Nothing).stderr_text,
              AllOf(HasSubstr("unknown option --zzzz"), Not(HasSubstr("Did you mean"))));
}

TEST(RunMain, NamesTheMistypedSubcommandAndItsOptions) {
  const Result command = RunThing({"pateint"}, true, Nothing);
  EXPECT_EQ(command.code, 2);
  EXPECT_THAT(command.stderr_text, AllOf(HasSubstr("unknown command 'pateint'"),
                                         HasSubstr("Did you mean patient?"), HasSubstr("scene")));
  EXPECT_THAT(RunThing({"patient", "--dept_mm", "3"}, true, Nothing).stderr_text,
              HasSubstr("Did you mean --depth_mm?"));
}

TEST(RunMain, StopsAtTheNextCheckpointOnASignal) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const Result result = RunThing({"in.csv"}, [signal](RunContext& context) {
      context.Checkpoint("before", 0.0);
      std::raise(signal);
      context.Checkpoint("after", 0.5);
      ADD_FAILURE() << "went on after the signal";
      return ExitCode::kOk;
    });
    EXPECT_EQ(result.code, 130);
    EXPECT_THAT(result.stderr_text, HasSubstr("stopped on request"));
  }
}

TEST(RunMain, OutlivesItsTerminalAfterNohup) {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  const Result result = RunThing({"in.csv"}, [](RunContext& context) {
    std::raise(SIGHUP);
    context.Checkpoint("after", 0.5);
    return ExitCode::kOk;
  });
  EXPECT_EQ(result.code, 0);
  std::signal(SIGHUP, before);
}

TEST(RunMain, PrintsWarningsUnlessQuiet) {
  const auto warn = [](RunContext& context) {
    context.Warn("thin ice");
    return ExitCode::kOk;
  };
  EXPECT_EQ(RunThing({"in.csv"}, warn).stderr_text, "acus-thing: warning: thin ice\n");
  EXPECT_EQ(RunThing({"in.csv", "--quiet"}, warn).stderr_text, "");
}

}  // namespace
}  // namespace acus
