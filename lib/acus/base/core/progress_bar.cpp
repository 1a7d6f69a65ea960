#include "acus/base/core/progress_bar.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace acus {
namespace {

constexpr int kBarWidth = 30;
constexpr auto kMinInterval = std::chrono::milliseconds(50);
/// Tasks that end sooner than this print nothing where there is no terminal.
constexpr auto kShortTask = std::chrono::seconds(2);

}  // namespace

void ProgressBar::Show(std::string_view task, double fraction) {
  const auto now = std::chrono::steady_clock::now();
  fraction = std::clamp(fraction, 0.0, 1.0);
  if (task != task_) {
    task_ = task;
    quarter_ = 0;
    started_ = now;
    last_drawn_ = {};
  }
  const std::chrono::duration<double> elapsed = now - started_;
  const int percent = static_cast<int>(std::floor(100.0 * fraction));
  if (is_terminal_) {
    if (now - last_drawn_ < kMinInterval && fraction < 1.0) return;
    last_drawn_ = now;
    const int filled = percent * kBarWidth / 100;
    std::fprintf(stderr, "\r\033[K%-32.*s [%s%s] %3d %%  %.0f s", static_cast<int>(task.size()),
                 task.data(), std::string(filled, '#').c_str(),
                 std::string(kBarWidth - filled, '.').c_str(), percent, elapsed.count());
    std::fflush(stderr);
    drawn_ = true;
    return;
  }
  if (const int quarter = percent / 25; quarter > quarter_ && elapsed > kShortTask) {
    quarter_ = quarter;
    std::fprintf(stderr, "%.*s: %d %%, %.0f s\n", static_cast<int>(task.size()), task.data(),
                 percent, elapsed.count());
  }
}

void ProgressBar::Clear() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

}  // namespace acus
