#include "acus/base/core/temporaries.h"

#include <chrono>
#include <set>
#include <thread>

namespace acus {
namespace {

constexpr int kAttempts = 5;  // Other threads may add files while a folder is being removed.

std::mutex& TemporariesMutex() {
  static std::mutex mutex;
  return mutex;
}

/// Never destroyed: an exception may unwind while statics are gone.
std::set<std::filesystem::path>& Known() {
  static auto* known = new std::set<std::filesystem::path>;
  return *known;
}

}  // namespace

Temporary::Temporary(std::filesystem::path path) : path_(std::move(path)) {
  const std::lock_guard lock(TemporariesMutex());
  Known().insert(path_);
}

Temporary::~Temporary() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  const std::lock_guard lock(TemporariesMutex());
  Known().erase(path_);
}

std::unique_lock<std::mutex> HoldTemporaries() {
  return std::unique_lock(TemporariesMutex());
}

void RemoveTemporaries() noexcept {
  // Whoever holds it may be the thread that is ending: it is not waited for without end.
  for (int i = 0; i < 50 && !TemporariesMutex().try_lock(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::error_code error;
  for (const auto& path : Known()) {
    for (int i = 0; i < kAttempts && std::filesystem::exists(path, error); ++i) {
      std::filesystem::remove_all(path, error);
    }
  }
}

}  // namespace acus
