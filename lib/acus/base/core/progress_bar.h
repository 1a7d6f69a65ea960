// Progress on stderr: a bar that redraws itself on a terminal, a line each 25 % otherwise.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace acus {

class ProgressBar {
 public:
  explicit ProgressBar(bool is_terminal) : is_terminal_(is_terminal) {}
  ~ProgressBar() { Clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Shows that `task` has come to `fraction` in [0, 1]. Redraws at most 20 times a second.
  void Show(std::string_view task, double fraction);

  /// Takes the bar off the terminal, so that a message can be printed.
  void Clear();

 private:
  bool is_terminal_;
  bool drawn_ = false;
  std::string task_;
  int quarter_ = -1;
  std::chrono::steady_clock::time_point started_;
  std::chrono::steady_clock::time_point last_drawn_;
};

}  // namespace acus
