#include "core/worker_pool.h"

#include <atomic>
#include <cstdint>
#include <system_error>
#include <thread>
#include <vector>

namespace acus {
namespace {

/// Waiting rounds before a helper goes to sleep: some 20 us, the gap between the loops of a
/// picture.
constexpr int kSpins = 2000;

void Pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

struct WorkerPool::State {
  // The loop at hand. Written by the caller while no helper works.
  Call call = nullptr;
  const void* body = nullptr;
  int count = 0;
  std::atomic<int> next{0};
  std::atomic<std::uint32_t> round{0};  ///< Counts loops: a change wakes the helpers.
  std::atomic<int> busy{0};             ///< Helpers that have not finished this round.
  std::atomic<bool> stop{false};
  std::vector<std::thread> helpers;

  void Work() {
    const auto take = [&] { return next.fetch_add(1, std::memory_order_relaxed); };
    for (int i = take(); i < count; i = take()) call(body, i);
  }

  void Help() {
    std::uint32_t seen = 0;
    for (;;) {
      for (int n = 0; n < kSpins && round.load(std::memory_order_acquire) == seen; ++n) Pause();
      round.wait(seen, std::memory_order_acquire);
      seen = round.load(std::memory_order_acquire);
      if (stop.load(std::memory_order_relaxed)) return;
      Work();
      if (busy.fetch_sub(1, std::memory_order_acq_rel) == 1) busy.notify_one();
    }
  }
};

WorkerPool::WorkerPool(int num_threads) : state_(std::make_unique<State>()) {
  for (int i = 1; i < num_threads; ++i) {
    try {
      state_->helpers.emplace_back([state = state_.get()] { state->Help(); });
    } catch (const std::system_error&) {
      break;
    }
  }
}

WorkerPool::~WorkerPool() {
  state_->stop.store(true, std::memory_order_relaxed);
  state_->round.fetch_add(1, std::memory_order_release);
  state_->round.notify_all();
  for (std::thread& helper : state_->helpers) helper.join();
}

int WorkerPool::num_threads() const {
  return static_cast<int>(state_->helpers.size()) + 1;
}

void WorkerPool::RunPieces(int count, Call call, const void* body) {
  State& s = *state_;
  s.call = call;
  s.body = body;
  s.count = count;
  s.next.store(0, std::memory_order_relaxed);
  if (!s.helpers.empty() && count > 1) {
    s.busy.store(static_cast<int>(s.helpers.size()), std::memory_order_relaxed);
    s.round.fetch_add(1, std::memory_order_release);
    s.round.notify_all();
    s.Work();
    for (int n = 0; n < kSpins && s.busy.load(std::memory_order_acquire) != 0; ++n) Pause();
    for (int left = s.busy.load(std::memory_order_acquire); left != 0;
         left = s.busy.load(std::memory_order_acquire)) {
      s.busy.wait(left, std::memory_order_acquire);
    }
    return;
  }
  s.Work();
}

}  // namespace acus
