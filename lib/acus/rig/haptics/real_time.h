// Threads that must not be kept waiting.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

namespace acus::haptics {

/// Gives the calling thread real-time priority (SCHED_FIFO) and, once per process, keeps the
/// process's memory from being swapped out. Empty if both were granted; otherwise a notice in plain
/// words, which says what to do.
/// @param priority  1 to 99; a servo has 80, what watches over it 85.
std::string RequestRealTime(int priority);

/// Calls a function at a fixed rate from a separate thread with real-time priority. The times
/// are those of a grid: a call that comes late does not shift the later ones, and calls that were
/// missed altogether are omitted.
class ServoThread {
 public:
  /// @param call  false ends the thread.
  using Call = bool (*)(void* context) noexcept;

  ServoThread() = default;
  ~ServoThread() { Stop(); }
  ServoThread(const ServoThread&) = delete;
  ServoThread& operator=(const ServoThread&) = delete;

  /// Returns the notice of RequestRealTime(). @pre it does not run; rate_hz > 0.
  /// @throws InputError if there can be no more threads.
  std::string Start(double rate_hz, Call call, void* context);

  /// Lets the call that is under way finish, and waits for it. A second call has no effect.
  void Stop() noexcept;

 private:
  std::thread thread_;
  std::atomic<bool> stopping_{false};
};

}  // namespace acus::haptics
