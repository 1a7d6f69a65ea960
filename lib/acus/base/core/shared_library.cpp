#include "acus/base/core/shared_library.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <map>
#include <memory>
#include <mutex>
#include <spawn.h>
#include <string_view>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/system_libraries.h"
#include "acus/base/core/trusted_library.h"

namespace acus {
namespace {

constexpr auto kProbePause = std::chrono::milliseconds(5);

std::string LoaderError() {
  const char* text = dlerror();
  return text != nullptr ? text : "unknown error of the loader";
}

int Flags(const LibraryRequest& request) {
  return RTLD_NOW | (request.shares_symbols ? RTLD_GLOBAL : RTLD_LOCAL);
}

/// This process's environment, with the library to be loaded before anything else. Of the loader's
/// variables only LD_LIBRARY_PATH is handed on, which has been checked.
std::vector<std::string> ProbeEnvironment(const LibraryRequest& request, const std::string& name) {
  std::vector<std::string> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view variable = *entry;
    const bool is_loaders = variable.starts_with("LD_");
    if (!is_loaders || variable.starts_with("LD_LIBRARY_PATH=")) environment.emplace_back(variable);
  }
  std::string first = "LD_PRELOAD=";
  for (const std::string& before : request.preload) first += before + ":";
  environment.push_back(first + name);
  environment.emplace_back("LD_BIND_NOW=1");
  return environment;
}

/// Starts a program that does nothing, with the library loaded into it; -1 if it cannot be. (A fork
/// of this program could hang by itself: other threads may hold the loader's lock.)
pid_t StartProbe(const LibraryRequest& request, const std::string& name) {
  std::vector<std::string> environment = ProbeEnvironment(request, name);
  std::vector<char*> entries;
  for (std::string& entry : environment) entries.push_back(entry.data());
  entries.push_back(nullptr);
  std::string program = "/bin/true";
  std::array<char*, 2> arguments = {program.data(), nullptr};

  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, file, "/dev/null", O_RDWR, 0);
  }
  sigset_t all;
  sigset_t none;
  sigfillset(&all);
  sigemptyset(&none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  pid_t child = -1;
  const int error =
      posix_spawn(&child, program.c_str(), &actions, &attributes, arguments.data(), entries.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error == 0 ? child : -1;
}

/// What is wrong with loading the library, as far as only a separate process may find out; or
/// empty. A file that is not there is no such thing: the loader says that better.
std::string TryInChild(const LibraryRequest& request, const std::string& name) {
  using Clock = std::chrono::steady_clock;
  // The loader takes these for separators.
  if (name.find_first_of(" :") != std::string::npos) return "";
  const pid_t child = StartProbe(request, name);
  if (child < 0) return "";
  const auto end = Clock::now() + std::chrono::duration<double>(request.timeout_s);
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(child, &status, WNOHANG)) == 0 || (ended < 0 && errno == EINTR)) {
    if (Clock::now() > end) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return Message(name, " does not return from loading (waited ", request.timeout_s,
                     " s): is its service running, and does it ask something on the screen?");
    }
    std::this_thread::sleep_for(kProbePause);
  }
  if (ended < 0 || !WIFSIGNALED(status)) return "";
  return Message(name, " crashes while it is loaded (", strsignal(WTERMSIG(status)),
                 "): it may be made for another system");
}

/// Handles of what was loaded before, by name and flags.
class Loaded {
 public:
  void* Find(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const auto found = handles_.find(name);
    return found == handles_.end() ? nullptr : found->second;
  }
  void Keep(const std::string& name, void* handle) {
    const std::lock_guard lock(mutex_);
    handles_[name] = handle;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, void*> handles_;
};

Loaded& AllLoaded() {
  static Loaded* loaded = new Loaded;  // Outlives every device.
  return *loaded;
}

/// The paths for the loader, one after the other, once nothing of it can be the working
/// directory's.
std::vector<std::string> WhatToLoad(const LibraryRequest& request) {
  CheckLibraryWord(request.path, Message(request.product, ": library"));
  CheckSearch(LoaderFolders());
  if (request.path.empty()) return request.names;
  if (request.path.front() != '/') return {request.path};
  return {TrustedFile(request.path, request.product)};
}

void* OpenFirst(const LibraryRequest& request, const std::vector<std::string>& names) {
  std::string tried;
  for (const std::string& name : names) {
    if (void* handle = AllLoaded().Find(name); handle != nullptr) return handle;
    std::string problem = TryInChild(request, name);
    if (problem.empty()) {
      for (const std::string& first : request.preload) {
        dlopen(first.c_str(), RTLD_NOW | RTLD_GLOBAL);
      }
      if (void* handle = dlopen(name.c_str(), Flags(request)); handle != nullptr) {
        AllLoaded().Keep(name, handle);
        return handle;
      }
      problem = LoaderError();
    }
    if (!tried.empty()) tried += "; ";
    tried += problem;
  }
  throw InputError(
      Message(request.product, ": its library cannot be loaded: ", tried, ". ", request.advice));
}

}  // namespace

void LoadLibrary(const LibraryRequest& request, std::span<const Symbol> symbols) {
  void* handle = OpenFirst(request, WhatToLoad(request));
  std::string missing;
  for (const Symbol& symbol : symbols) {
    dlerror();
    *symbol.pointer = dlsym(handle, symbol.name);
    if (*symbol.pointer != nullptr || !symbol.is_required) continue;
    missing += Message(missing.empty() ? "" : "; ", symbol.name, " (", LoaderError(), ")");
  }
  ACUS_REQUIRE(missing.empty(), request.product, ": its library lacks functions: ", missing,
               ". Install a version that has them");
}

std::filesystem::path FindLibrary(const LibraryRequest& request) {
  std::string tried;
  for (const std::string& name : WhatToLoad(request)) {
    if (name.front() == '/') return name;
    const std::filesystem::path file = FindSystemLibrary(name);
    if (!file.empty()) return file;
    tried += (tried.empty() ? "" : ", ") + name;
  }
  throw InputError(Message(request.product, ": there is no library ", tried,
                           " in LD_LIBRARY_PATH and where the system keeps its libraries (see "
                           "ldconfig -p). ",
                           request.advice));
}

void PatientCalls::Call(const std::string& what, double timeout_s, std::function<void()> function) {
  struct Outcome {
    std::mutex mutex;
    std::condition_variable done;
    bool is_done = false;
    bool has_failed = false;
    std::string error;  // The words, not the exception: that would be shared by two threads.
  };
  ACUS_REQUIRE(!is_busy_->exchange(true), what,
               " has not returned yet: end this program, and switch the device off and on");
  const auto outcome = std::make_shared<Outcome>();
  try {
    std::thread([outcome, busy = is_busy_, function = std::move(function)] {
      bool has_failed = false;
      std::string error;
      try {
        function();
      } catch (const std::exception& thrown) {
        has_failed = true;
        error = thrown.what();
      }
      *busy = false;
      const std::lock_guard lock(outcome->mutex);
      outcome->has_failed = has_failed;
      outcome->error = std::move(error);
      outcome->is_done = true;
      outcome->done.notify_all();
    }).detach();
  } catch (const std::system_error& error) {
    *is_busy_ = false;
    throw InputError(Message(what, ": no thread can be started: ", error.what()));
  }
  std::unique_lock lock(outcome->mutex);
  const bool in_time = outcome->done.wait_for(lock, std::chrono::duration<double>(timeout_s),
                                              [&] { return outcome->is_done; });
  ACUS_REQUIRE(in_time, what, " does not return (waited ", timeout_s,
               " s): is the device plugged in and switched on, and is no other program using it?");
  if (outcome->has_failed) throw InputError(outcome->error);
}

}  // namespace acus
