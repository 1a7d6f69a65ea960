#include "acus/rig/haptics/callback_gate.h"

#include <chrono>
#include <thread>

namespace acus::haptics {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(1);
constexpr auto kLastTickTimeout = std::chrono::milliseconds(200);

}  // namespace

void CallbackGate::Open() noexcept {
  stopping_ = false;
  has_ended_ = false;
}

bool CallbackGate::AwaitLastTick() noexcept {
  stopping_.store(true, std::memory_order_release);
  for (auto waited = std::chrono::milliseconds(0);
       !has_ended_.load(std::memory_order_acquire) && waited < kLastTickTimeout; waited += kPoll) {
    std::this_thread::sleep_for(kPoll);
  }
  return has_ended_.exchange(true, std::memory_order_acq_rel);
}

void CallbackGate::AwaitNobodyInside() const noexcept {
  while (is_inside_.load(std::memory_order_acquire)) std::this_thread::sleep_for(kPoll);
}

}  // namespace acus::haptics
