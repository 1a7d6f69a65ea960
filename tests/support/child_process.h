// Work in a process of its own, so that a crash and a hang are outcomes like others.
#pragma once

#include <algorithm>
#include <cstdio>
#include <functional>
#include <stdexcept>
#include <string>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "support/scenario_trial.h"

namespace acus::testing_support {

enum class End { kSound, kRefused, kViolated, kCrashed };

struct Outcome {
  End end = End::kSound;
  std::string what;
};

/// Memory that a child writes and its parent reads. @pre T is plain.
template <typename T>
class Shared {
 public:
  Shared()
      : memory_(
            mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (memory_ == MAP_FAILED) throw std::runtime_error("no memory to share");
    new (memory_) T();
  }
  ~Shared() { munmap(memory_, sizeof(T)); }
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;
  T& operator*() const { return *static_cast<T*>(memory_); }
  T* operator->() const { return static_cast<T*>(memory_); }

 private:
  void* memory_;
};

/// Runs `work` in a child: refused by an InputError, violated by any other exception, crashed by a
/// signal or after `most_seconds`.
inline Outcome InChild(const std::function<void()>& work, unsigned most_seconds = 60) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    alarm(most_seconds);
    Outcome outcome;
    try {
      work();
    } catch (const InputError& error) {
      outcome = {End::kRefused, error.what()};
    } catch (const std::exception& error) {
      outcome = {End::kViolated, error.what()};
    }
    const auto written [[maybe_unused]] =
        write(ends[1], outcome.what.data(), std::min<std::size_t>(outcome.what.size(), 4000));
    _exit(static_cast<int>(outcome.end));
  }
  close(ends[1]);
  std::string what;
  char buffer[512];
  for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) > 0;) {
    what.append(buffer, static_cast<std::size_t>(n));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status)) {
    return {End::kCrashed, Message("signal ", WTERMSIG(status),
                                   WTERMSIG(status) == SIGALRM ? " (took too long)" : "")};
  }
  if (WEXITSTATUS(status) > static_cast<int>(End::kViolated)) {
    return {End::kCrashed, Message("exit code ", WEXITSTATUS(status))};  // A sanitizer's.
  }
  return {static_cast<End>(WEXITSTATUS(status)), what};
}

}  // namespace acus::testing_support
