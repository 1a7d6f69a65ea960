#include "acus/rig/haptics/real_time.h"

#include <cerrno>
#include <cstring>
#include <future>
#include <mutex>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <system_error>
#include <time.h>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"

namespace acus::haptics {
namespace {

constexpr int kServoPriority = 80;
constexpr std::size_t kStackToTouch = 64 * 1024;
constexpr std::int64_t kSecondNs = 1'000'000'000;

/// Locks what is there and what will be. Where there is a limit, later allocations would fail at
/// it: then rather not.
std::string LockMemoryOnce() {
  static std::once_flag once;
  static std::string& notice = *new std::string;  // exit() leaves servo threads running.
  std::call_once(once, [] {
    rlimit limit{};
    getrlimit(RLIMIT_MEMLOCK, &limit);
    if (limit.rlim_cur == RLIM_INFINITY && mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) {
      return;
    }
    notice =
        "memory may be swapped out, and steps may then come late: allow locked memory, e.g. with "
        "the line '@haptics - memlock unlimited' in /etc/security/limits.d/haptics.conf, put "
        "yourself into the group haptics, and log in again";
  });
  return notice;
}

/// So that the servo does not meet the first touch of its stack.
void TouchStack() {
  volatile char stack[kStackToTouch];
  for (std::size_t i = 0; i < kStackToTouch; i += 1024) stack[i] = 0;
  static_cast<void>(stack[0]);
}

}  // namespace

std::string RequestRealTime(int priority) {
  std::string notice = LockMemoryOnce();
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error != 0) {
    if (!notice.empty()) notice += "; ";
    notice += Message(
        "no real-time priority (", std::strerror(error), "): steps may come late when the machine ",
        "is busy; allow it, e.g. with the line '@haptics - rtprio 90' in ",
        "/etc/security/limits.d/haptics.conf, put yourself into the group haptics, and log in ",
        "again");
  }
  return notice;
}

std::string ServoThread::Start(double rate_hz, Call call, void* context) {
  ACUS_ASSERT(!thread_.joinable() && rate_hz > 0.0);
  stopping_ = false;
  std::promise<std::string> notice;
  std::future<std::string> noticed = notice.get_future();
  const auto period_ns = static_cast<std::int64_t>(1e9 / rate_hz);
  auto loop = [this, call, context, period_ns, promise = std::move(notice)]() mutable {
    promise.set_value(RequestRealTime(kServoPriority));
    TouchStack();
    std::int64_t due_ns = MonotonicNs();
    while (!stopping_.load(std::memory_order_acquire) && call(context)) {
      due_ns += period_ns;
      const std::int64_t now_ns = MonotonicNs();
      if (now_ns > due_ns) due_ns += (now_ns - due_ns) / period_ns * period_ns;
      const timespec due{.tv_sec = due_ns / kSecondNs, .tv_nsec = due_ns % kSecondNs};
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) == EINTR) {
      }
    }
  };
  try {
    thread_ = std::thread(std::move(loop));
  } catch (const std::system_error& error) {
    throw InputError(Message("no thread can be started for a haptic device: ", error.what()));
  }
  return noticed.get();
}

void ServoThread::Stop() noexcept {
  stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

}  // namespace acus::haptics
