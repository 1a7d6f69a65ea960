#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace acus {

// Plain threads rather than a task library: starting one costs some 20 us, loops take
// milliseconds, and the thread sanitizer understands all of it, which it does not of libraries
// that come without instrumentation.
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
  {
    std::vector<std::jthread> helpers;
    const int num_helpers = std::min(num_threads, count) - 1;
    for (int i = 0; i < num_helpers; ++i) {
      try {
        helpers.emplace_back(work);
      } catch (const std::system_error&) {
        break;  // The system has no thread left: the ones that run do the work.
      }
    }
    work();
  }
  if (first_error) std::rethrow_exception(first_error);
}

}  // namespace acus
