#include "haptics/shared_library.h"

#include <algorithm>
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
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

#include "core/error.h"

namespace acus::haptics {
namespace {

constexpr int kLoaded = 0;
constexpr int kNotLoaded = 3;

/// What became of loading in the child.
struct Probe {
  bool is_good = false;
  std::string text;
};

std::string LoaderError() {
  const char* text = dlerror();
  return text != nullptr ? text : "unknown error of the loader";
}

int Flags(const LibraryRequest& request) {
  return RTLD_NOW | (request.shares_symbols ? RTLD_GLOBAL : RTLD_LOCAL);
}

/// In the child: the handlers of this program must not run there, and nobody wants its core file.
void BeOnOnesOwn() {
  for (int number = 1; number < NSIG; ++number) std::signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
}

[[noreturn]] void LoadInChild(const LibraryRequest& request, const std::string& name, int answer) {
  BeOnOnesOwn();
  for (const std::string& first : request.preload) dlopen(first.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (dlopen(name.c_str(), Flags(request)) != nullptr) _exit(kLoaded);
  const std::string text = LoaderError();
  const bool is_written = write(answer, text.data(), text.size()) > 0;
  _exit(is_written ? kNotLoaded : kNotLoaded + 1);
}

/// All that the child writes until it ends or the time is over; false if it is over.
bool ReadUntilEnd(int answer, double timeout_s, std::string& text) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(timeout_s);
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    pollfd waiting{answer, POLLIN, 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::max<long>(0, left.count())));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    std::array<char, 512> buffer{};
    const ssize_t length = read(answer, buffer.data(), buffer.size());
    if (length <= 0) return true;
    text.append(buffer.data(), static_cast<std::size_t>(length));
  }
}

Probe TryInChild(const LibraryRequest& request, const std::string& name) {
  std::array<int, 2> pipe_ends{};
  ACUS_REQUIRE(pipe2(pipe_ends.data(), O_CLOEXEC) == 0, request.product,
               ": no pipe can be made to try its library; too many files are open");
  const pid_t child = fork();
  if (child == 0) LoadInChild(request, name, pipe_ends[1]);
  close(pipe_ends[1]);
  Probe probe;
  const bool in_time = child > 0 && ReadUntilEnd(pipe_ends[0], request.timeout_s, probe.text);
  close(pipe_ends[0]);
  ACUS_REQUIRE(child > 0, request.product,
               ": no process can be made to try its library: ", std::strerror(errno));
  if (!in_time) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!in_time) {
    probe.text = Message("does not return from loading (waited ", request.timeout_s,
                         " s): is its service running, and does it ask something on the screen?");
  } else if (WIFSIGNALED(status)) {
    probe.text = Message("crashes while it is loaded (", strsignal(WTERMSIG(status)),
                         "): it may be made for another system");
  } else {
    probe.is_good = WIFEXITED(status) && WEXITSTATUS(status) == kLoaded;
  }
  return probe;
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

void* OpenFirst(const LibraryRequest& request, const std::vector<std::string>& names) {
  std::string tried;
  for (const std::string& name : names) {
    if (void* handle = AllLoaded().Find(name); handle != nullptr) return handle;
    const Probe probe = TryInChild(request, name);
    if (probe.is_good) {
      for (const std::string& first : request.preload) {
        dlopen(first.c_str(), RTLD_NOW | RTLD_GLOBAL);
      }
      void* handle = dlopen(name.c_str(), Flags(request));
      ACUS_REQUIRE(handle != nullptr, request.product, ": ", name, ": ", LoaderError());
      AllLoaded().Keep(name, handle);
      return handle;
    }
    if (!tried.empty()) tried += "; ";
    // The loader's own words begin with the name.
    tried += probe.text.starts_with(name) ? probe.text : name + " " + probe.text;
  }
  throw InputError(
      Message(request.product, ": its library cannot be loaded: ", tried, ". ", request.advice));
}

}  // namespace

void LoadLibrary(const LibraryRequest& request, std::span<const Symbol> symbols) {
  const std::vector<std::string> names =
      request.path.empty() ? request.names : std::vector<std::string>{request.path};
  void* handle = OpenFirst(request, names);
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

void PatientCalls::Call(const std::string& what, double timeout_s, std::function<void()> function) {
  struct Outcome {
    std::mutex mutex;
    std::condition_variable done;
    bool is_done = false;
    std::exception_ptr error;
  };
  ACUS_REQUIRE(!is_busy_->exchange(true), what,
               " has not returned yet: end this program, and switch the device off and on");
  const auto outcome = std::make_shared<Outcome>();
  try {
    std::thread([outcome, busy = is_busy_, function = std::move(function)] {
      std::exception_ptr error;
      try {
        function();
      } catch (...) {
        error = std::current_exception();
      }
      *busy = false;
      const std::lock_guard lock(outcome->mutex);
      outcome->error = error;
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
  if (outcome->error) std::rethrow_exception(outcome->error);
}

}  // namespace acus::haptics
