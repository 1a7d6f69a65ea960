#include "acus/base/core/stop_deadline.h"

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <semaphore.h>
#include <system_error>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/temporaries.h"

namespace acus {
namespace {

constexpr auto kGrace = std::chrono::milliseconds(1200);
constexpr auto kLook = std::chrono::milliseconds(20);

std::atomic<int> num_without_deadline{0};

/// What a signal handler may raise; it lives as long as the process.
sem_t& StopSemaphore() noexcept {
  static sem_t semaphore = [] {
    sem_t made;
    ::sem_init(&made, 0, 0);
    return made;
  }();
  return semaphore;
}

}  // namespace

void NotifyStop() noexcept {
  ::sem_post(&StopSemaphore());
}

StopDeadline::StopDeadline(std::string program) : program_(std::move(program)) {
  while (::sem_trywait(&StopSemaphore()) == 0) {  // What remains of a stop before.
  }
  try {
    thread_ = std::thread([this] { Watch(); });
  } catch (const std::system_error&) {
    // No thread can be had: the next Checkpoint stops the program.
  }
}

StopDeadline::~StopDeadline() {
  is_over_ = true;
  NotifyStop();
  if (thread_.joinable()) thread_.join();
}

void StopDeadline::Watch() const {
  while (::sem_wait(&StopSemaphore()) != 0 && errno == EINTR) {
  }
  const auto end = std::chrono::steady_clock::now() + kGrace;
  while (!is_over_ && (num_without_deadline > 0 || std::chrono::steady_clock::now() < end)) {
    std::this_thread::sleep_for(kLook);
  }
  if (is_over_) return;
  RemoveTemporaries();
  std::fprintf(stderr, "%s: stopped on request; what was not finished is not written\n",
               program_.c_str());
  ::_exit(static_cast<int>(ExitCode::kCancelled));
}

NoStopDeadline::NoStopDeadline() {
  ++num_without_deadline;
}

bool NoStopDeadline::IsAlive() noexcept {
  return num_without_deadline > 0;
}

NoStopDeadline::~NoStopDeadline() {
  --num_without_deadline;
}

}  // namespace acus
