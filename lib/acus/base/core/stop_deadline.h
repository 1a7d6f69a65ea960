// A stop that was requested (Ctrl-C, SIGTERM) ends the program soon, whatever it is computing.
#pragma once

#include <atomic>
#include <string>
#include <thread>

namespace acus {

/// Call in the signal handler: starts the time of the StopDeadline that is alive.
void NotifyStop() noexcept;

/// While it is alive, the process ends with ExitCode::kCancelled about a second after NotifyStop(),
/// if it has not ended by itself: libraries compute for long between two Checkpoints. Outputs that
/// are not committed are removed.
class StopDeadline {
 public:
  /// @param program  Its name, for the message.
  explicit StopDeadline(std::string program);
  ~StopDeadline();
  StopDeadline(const StopDeadline&) = delete;
  StopDeadline& operator=(const StopDeadline&) = delete;

 private:
  void Watch() const;

  std::string program_;
  std::atomic<bool> is_over_{false};
  std::thread thread_;
};

/// While one is alive, no deadline ends the process: a recording is written to its end.
class NoStopDeadline {
 public:
  NoStopDeadline();
  ~NoStopDeadline();
  NoStopDeadline(const NoStopDeadline&) = delete;
  NoStopDeadline& operator=(const NoStopDeadline&) = delete;

  static bool IsAlive() noexcept;
};

}  // namespace acus
