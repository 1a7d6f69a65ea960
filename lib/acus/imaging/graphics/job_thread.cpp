#include "acus/imaging/graphics/job_thread.h"

#include <utility>

namespace acus::graphics {

void JobThread::Run(const std::function<void()>& job) {
  Start(job);
  std::exchange(started_, {}).get();
}

void JobThread::Start(const std::function<void()>& job) {
  if (started_.valid()) std::exchange(started_, {}).get();
  std::packaged_task<void()> task(job);
  started_ = task.get_future();
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(task);
  }
  changed_.notify_one();
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
