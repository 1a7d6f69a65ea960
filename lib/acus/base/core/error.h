// Errors: whose mistake it is decides how it is reported.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace acus {

/// Exit codes of every program. See docs/reference/exit_codes.md.
enum class ExitCode : int {
  kOk = 0,
  kInternal = 1,     ///< Anything unforeseen.
  kCommandLine = 2,  ///< Wrong or missing option, no such file.
  kInput = 3,        ///< The content of a file is not usable.
  kNoAnswer = 4,     ///< Ran, but the answer is not usable: no convergence, runs differ.
  kCancelled = 130,  ///< Stopped by the user.
};

/// The user's data is wrong. The message says file, place, value, what is allowed, what to try.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// It ran, but there is no usable answer. Becomes ExitCode::kNoAnswer.
class NoAnswerError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A stop was requested (Ctrl-C, or RunContext::stop).
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("stopped on request; nothing was written") {}
};

/// Joins its arguments with operator<<, numbers with up to nine digits.
template <typename... Parts>
std::string Message(const Parts&... parts) {
  std::ostringstream out;
  out.precision(9);
  (out << ... << parts);
  return std::move(out).str();
}

/// Prints the broken invariant and aborts. Called by ACUS_ASSERT only.
[[noreturn]] void AssertionFailed(const char* condition, const char* file, int line) noexcept;

}  // namespace acus

/// The caller's data is wrong: throws InputError, in every build.
#define ACUS_REQUIRE(condition, ...)                          \
  do {                                                        \
    if (!(condition)) [[unlikely]] {                          \
      throw ::acus::InputError(::acus::Message(__VA_ARGS__)); \
    }                                                         \
  } while (false)

/// Our own invariant is broken: aborts, in every build.
#define ACUS_ASSERT(condition)                                 \
  do {                                                         \
    if (!(condition)) [[unlikely]] {                           \
      ::acus::AssertionFailed(#condition, __FILE__, __LINE__); \
    }                                                          \
  } while (false)
