// A thread for what must always be called from the same one, such as an OpenGL context.
#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <thread>

namespace acus::graphics {

class JobThread {
 public:
  JobThread() : thread_([this](const std::stop_token& stop) { Work(stop); }) {}

  /// Does a job in the thread, and waits for it. From one thread at a time.
  /// @throws What the job throws, or the one that was started before.
  void Run(const std::function<void()>& job);
  /// Begins a job in the thread. Whatever comes next waits for it.
  void Start(const std::function<void()>& job);

 private:
  void Work(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<std::packaged_task<void()>> waiting_;
  std::future<void> started_;  ///< Of Start(); not valid: none.
  std::jthread thread_;        ///< The last member: it uses the others.
};

}  // namespace acus::graphics
