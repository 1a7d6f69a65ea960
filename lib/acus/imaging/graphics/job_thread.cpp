#include "acus/imaging/graphics/job_thread.h"

#include <utility>

namespace acus::graphics {

void JobThread::Run(const std::function<void()>& job) {
  std::packaged_task<void()> task(job);
  std::future<void> done = task.get_future();
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(task);
  }
  changed_.notify_one();
  done.get();
}

void JobThread::Work(const std::stop_token& stop) {
  while (true) {
    std::packaged_task<void()> task;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return waiting_.has_value(); })) return;
      task = std::move(*std::exchange(waiting_, std::nullopt));
    }
    task();
  }
}

}  // namespace acus::graphics
