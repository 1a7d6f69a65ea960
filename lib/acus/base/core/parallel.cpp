#include "acus/base/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace acus {
namespace {

/// Threads that stay from loop to loop: starting one for each loop takes longer than the stages of
/// an image do, and allocates. Plain threads rather than a task library: the thread sanitizer
/// understands all of it, which it does not of libraries that come without instrumentation.
class Team {
 public:
  using Work = std::function<void()>;

  /// The one team of the program. Never destroyed: its threads may still wait when statics die.
  static Team& Get() {
    static Team* const team = new Team;
    return *team;
  }

  /// Calls `work` on this thread and on up to `num_helpers` others, and returns when all that
  /// began have ended. @return false, and nothing is done, if the team is at work for another loop.
  bool Run(int num_helpers, const Work& work) {
    if (busy_.test_and_set(std::memory_order_acquire)) return false;
    Grow(num_helpers);
    work_ = &work;
    finished_.store(0, std::memory_order_relaxed);
    seats_.store(num_helpers, std::memory_order_release);
    round_.fetch_add(1, std::memory_order_release);
    round_.notify_all();
    work();
    // Who has not begun by now need not begin.
    const int begun = num_helpers - seats_.exchange(0, std::memory_order_acq_rel);
    WaitWhile([this, begun] { return finished_.load(std::memory_order_acquire) != begun; });
    for (int f = finished_.load(std::memory_order_acquire); f != begun;
         f = finished_.load(std::memory_order_acquire)) {
      finished_.wait(f, std::memory_order_acquire);
    }
    busy_.clear(std::memory_order_release);
    return true;
  }

 private:
  /// Loops follow each other closely in an image: going to sleep in between costs more than this.
  template <typename Condition>
  static void WaitWhile(const Condition& condition) {
    constexpr int kYields = 200;
    for (int n = 0; n < kYields && condition(); ++n) std::this_thread::yield();
  }

  void Grow(int num_helpers) {
    for (; num_threads_ < num_helpers; ++num_threads_) {
      try {
        std::thread([this] { Help(); }).detach();
      } catch (const std::system_error&) {
        return;  // The system has no thread left: the ones that run do the work.
      }
    }
  }

  [[noreturn]] void Help() {
    unsigned seen = 0;
    while (true) {
      WaitWhile([this, seen] { return round_.load(std::memory_order_acquire) == seen; });
      round_.wait(seen, std::memory_order_acquire);
      seen = round_.load(std::memory_order_acquire);
      int seats = seats_.load(std::memory_order_relaxed);
      while (seats > 0 &&
             !seats_.compare_exchange_weak(seats, seats - 1, std::memory_order_acq_rel)) {
      }
      if (seats <= 0) continue;
      (*work_)();
      finished_.fetch_add(1, std::memory_order_release);
      finished_.notify_all();
    }
  }

  std::atomic_flag busy_;
  int num_threads_ = 0;         ///< Of whoever holds busy_, as is work_.
  const Work* work_ = nullptr;  ///< Read only by those who took a seat.
  std::atomic<unsigned> round_{0};
  std::atomic<int> seats_{0};     ///< Helpers that may still join the loop.
  std::atomic<int> finished_{0};  ///< Helpers that joined and have ended.
};

/// Where the team is taken, as in a loop within a loop.
void RunOnNewThreads(int num_helpers, const std::function<void()>& work) {
  std::vector<std::jthread> helpers;
  for (int i = 0; i < num_helpers; ++i) {
    try {
      helpers.emplace_back(work);
    } catch (const std::system_error&) {
      break;
    }
  }
  work();
}

}  // namespace

void ParallelFor(int count, int num_threads, const std::function<void(int)>& body) {
  std::atomic<int> next{0};
  std::mutex first_error_mutex;
  std::exception_ptr first_error;
  const auto work = [&] {
    // Relaxed: handing out indices must not order the pieces, or races among them would be hidden.
    const auto take = [&next] { return next.fetch_add(1, std::memory_order_relaxed); };
    for (int i = take(); i < count; i = take()) {
      try {
        body(i);
      } catch (...) {
        next.store(count, std::memory_order_relaxed);
        const std::lock_guard lock(first_error_mutex);
        if (!first_error) first_error = std::current_exception();
      }
    }
  };
  const int num_helpers = std::min(num_threads, count) - 1;
  if (num_helpers <= 0) {
    work();
  } else if (!Team::Get().Run(num_helpers, std::ref(work))) {
    RunOnNewThreads(num_helpers, std::ref(work));
  }
  if (first_error) std::rethrow_exception(first_error);
}

}  // namespace acus
