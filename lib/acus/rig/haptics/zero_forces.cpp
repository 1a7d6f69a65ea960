#include "acus/rig/haptics/zero_forces.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <mutex>
#include <poll.h>
#include <thread>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/rig/haptics/driver.h"

namespace acus::haptics {
namespace {

constexpr std::size_t kMostDrivers = 16;
constexpr int kLongestWaitMs = 200;
constexpr std::array<int, 9> kSignals = {SIGSEGV, SIGBUS, SIGILL,  SIGFPE, SIGABRT,
                                         SIGTERM, SIGHUP, SIGQUIT, SIGINT};

std::atomic<bool> forces_are_cut{false};
std::array<struct sigaction, NSIG> previous_actions{};

/// Lives until the process ends: a handler may need it at any time.
class Rescue {
 public:
  static Rescue& Get() {
    static Rescue* rescue = new Rescue;
    return *rescue;
  }

  void Add(Driver* driver) {
    const std::lock_guard lock(mutex_);
    for (Driver*& slot : drivers_) {
      if (slot != nullptr) continue;
      slot = driver;
      return;
    }
    throw InputError(Message("more than ", kMostDrivers, " haptic devices run at once"));
  }
  void Remove(Driver* driver) {
    const std::lock_guard lock(mutex_);
    for (Driver*& slot : drivers_) {
      if (slot == driver) slot = nullptr;
    }
  }
  void ZeroAll() {
    const std::lock_guard lock(mutex_);
    for (Driver* driver : drivers_) {
      if (driver != nullptr) driver->ZeroNow();
    }
  }

  /// Async-signal-safe.
  void AskAndWait() const noexcept {
    const char byte = 0;
    if (write(ask_[1], &byte, 1) != 1) return;
    pollfd answer{answer_[0], POLLIN, 0};
    while (poll(&answer, 1, kLongestWaitMs) < 0) {
      // Interrupted by another signal.
    }
  }

 private:
  Rescue() {
    ACUS_REQUIRE(pipe2(ask_, O_CLOEXEC) == 0 && pipe2(answer_, O_CLOEXEC) == 0,
                 "no pipe can be made for switching forces off; too many files are open");
    // No signal is handled in the thread that the handlers wait for.
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    std::thread([this] {
      char byte = 0;
      while (read(ask_[0], &byte, 1) == 1) {
        ZeroAll();
        if (write(answer_[1], &byte, 1) != 1) return;
      }
    }).detach();
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    std::atexit([] {
      CutForces();
      Get().ZeroAll();
    });
  }

  std::mutex mutex_;
  std::array<Driver*, kMostDrivers> drivers_{};
  int ask_[2] = {-1, -1};
  int answer_[2] = {-1, -1};
};

void OnSignal(int number, siginfo_t* info, void* context) {
  CutForces();
  Rescue::Get().AskAndWait();
  const struct sigaction& previous = previous_actions[static_cast<std::size_t>(number)];
  if ((previous.sa_flags & SA_SIGINFO) != 0 && previous.sa_sigaction != nullptr) {
    previous.sa_sigaction(number, info, context);
  } else if (previous.sa_handler != SIG_DFL && previous.sa_handler != SIG_IGN) {
    previous.sa_handler(number);
  } else if (previous.sa_handler == SIG_DFL) {
    sigaction(number, &previous, nullptr);
    raise(number);  // Comes when this handler returns.
  }
}

}  // namespace

void CutForces() noexcept {
  forces_are_cut.store(true, std::memory_order_seq_cst);
}

bool ForcesAreCut() noexcept {
  return forces_are_cut.load(std::memory_order_acquire);
}

void ZeroForcesOnSignals() {
  static std::once_flag once;
  std::call_once(once, [] {
    Rescue::Get();
    for (const int number : kSignals) {
      struct sigaction action {};
      action.sa_sigaction = &OnSignal;
      action.sa_flags = SA_SIGINFO | SA_ONSTACK;
      sigemptyset(&action.sa_mask);
      struct sigaction& previous = previous_actions[static_cast<std::size_t>(number)];
      sigaction(number, &action, &previous);
      // What was to be ignored (SIGHUP after nohup) ends nothing, and cuts no force.
      if ((previous.sa_flags & SA_SIGINFO) == 0 && previous.sa_handler == SIG_IGN) {
        sigaction(number, &previous, nullptr);
      }
    }
  });
}

void RegisterForZero(Driver* driver) {
  Rescue::Get().Add(driver);
}

void UnregisterForZero(Driver* driver) noexcept {
  Rescue::Get().Remove(driver);
}

}  // namespace acus::haptics
