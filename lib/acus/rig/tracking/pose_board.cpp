#include "acus/rig/tracking/pose_board.h"

#include <algorithm>
#include <array>
#include <bit>

#include "acus/base/core/error.h"

namespace acus::tracking {
namespace {

// A reading as words that can each be read while they are written: times, flags, quaternion
// (x, y, z, w) and translation.
constexpr std::size_t kWords = 12;
using Words = std::array<std::uint64_t, kWords>;

Words Packed(const TrackedPose& reading) noexcept {
  const Eigen::Quaterniond& q = reading.reference_from_tool.quaternion();
  const Eigen::Vector3d t_mm = reading.reference_from_tool.translation();
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  return {static_cast<std::uint64_t>(reading.time_ns),
          static_cast<std::uint64_t>(reading.source_time_ns),
          static_cast<std::uint64_t>(reading.measured_ns),
          reading.valid ? 1u : 0u,
          reading.number,
          bits(q.x()),
          bits(q.y()),
          bits(q.z()),
          bits(q.w()),
          bits(t_mm.x()),
          bits(t_mm.y()),
          bits(t_mm.z())};
}

TrackedPose Unpacked(const Words& words) noexcept {
  const auto real = [&](std::size_t i) { return std::bit_cast<double>(words[i]); };
  return {.time_ns = static_cast<std::int64_t>(words[0]),
          .source_time_ns = static_cast<std::int64_t>(words[1]),
          .measured_ns = static_cast<std::int64_t>(words[2]),
          // The quaternion is normalised already, so Pose keeps its bits.
          .reference_from_tool =
              transforms::Pose(Eigen::Quaterniond(real(8), real(5), real(6), real(7)),
                               Eigen::Vector3d(real(9), real(10), real(11))),
          .valid = words[3] != 0,
          .number = words[4]};
}

}  // namespace

/// Two copies: number n of the readings is written to copy n % 2 while n - 1 is read from the
/// other. So a writer that is interrupted in the middle never keeps a reader waiting, not even one
/// of higher priority on the same core. Aligned so that two tools never share a cache line.
struct alignas(128) PoseBoard::Slot {
  std::atomic<std::uint64_t> complete{0};  ///< Number of the latest reading that can be read.
  std::array<std::atomic<std::uint64_t>, kWords> copies[2] = {};
  TrackedPose last = {};  ///< The writer's own.
};

/// One writer, one taker.
struct PoseBoard::Journal {
  explicit Journal(std::size_t capacity) : readings(capacity) {}
  std::vector<ToolReading> readings;
  alignas(64) std::atomic<std::uint64_t> written{0};
  alignas(64) std::atomic<std::uint64_t> taken{0};
  std::atomic<std::uint64_t> lost{0};
};

PoseBoard::PoseBoard(std::vector<std::string> tools, std::size_t journal_capacity)
    : tools_(std::move(tools)), slots_(std::make_unique<Slot[]>(tools_.size())) {
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    ACUS_REQUIRE(!tools_[i].empty(), "tracked tools: name ", i + 1, " is empty");
    ACUS_REQUIRE(std::find(tools_.begin(), tools_.begin() + i, tools_[i]) == tools_.begin() + i,
                 "tracked tools: '", tools_[i], "' is there twice");
    const Words words = Packed(slots_[i].last);
    for (std::size_t k = 0; k < kWords; ++k) slots_[i].copies[0][k] = words[k];
  }
  if (journal_capacity > 0) journal_ = std::make_unique<Journal>(journal_capacity);
}

PoseBoard::~PoseBoard() = default;

std::optional<std::size_t> PoseBoard::Find(std::string_view tool) const noexcept {
  const auto found = std::find(tools_.begin(), tools_.end(), tool);
  if (found == tools_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - tools_.begin());
}

TrackedPose PoseBoard::Latest(std::size_t tool) const noexcept {
  ACUS_ASSERT(tool < tools_.size());
  const Slot& slot = slots_[tool];
  Words words;
  for (;;) {
    const std::uint64_t number = slot.complete.load(std::memory_order_acquire);
    for (std::size_t k = 0; k < kWords; ++k) {
      // Acquire, so that whoever sees a word of reading n + 2 also sees that n + 1 is complete.
      words[k] = slot.copies[number % 2][k].load(std::memory_order_acquire);
    }
    if (slot.complete.load(std::memory_order_relaxed) == number) return Unpacked(words);
  }
}

void PoseBoard::Publish(std::size_t tool, TrackedPose reading) noexcept {
  ACUS_ASSERT(tool < tools_.size());
  Slot& slot = slots_[tool];
  reading.number = slot.last.number + 1;
  if (!reading.valid) reading.reference_from_tool = slot.last.reference_from_tool;
  slot.last = reading;

  const Words words = Packed(reading);
  for (std::size_t k = 0; k < kWords; ++k) {
    slot.copies[reading.number % 2][k].store(words[k], std::memory_order_release);
  }
  slot.complete.store(reading.number, std::memory_order_release);

  if (journal_ == nullptr) return;
  const std::uint64_t written = journal_->written.load(std::memory_order_relaxed);
  const std::uint64_t held = written - journal_->taken.load(std::memory_order_acquire);
  if (held == journal_->readings.size()) {
    journal_->lost.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  journal_->readings[written % journal_->readings.size()] = {.tool = tool, .pose = reading};
  journal_->written.store(written + 1, std::memory_order_release);
}

std::size_t PoseBoard::TakeReadings(std::span<ToolReading> out) noexcept {
  if (journal_ == nullptr) return 0;
  const std::uint64_t taken = journal_->taken.load(std::memory_order_relaxed);
  const std::uint64_t held = journal_->written.load(std::memory_order_acquire) - taken;
  const std::size_t count = std::min<std::uint64_t>(held, out.size());
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = journal_->readings[(taken + i) % journal_->readings.size()];
  }
  journal_->taken.store(taken + count, std::memory_order_release);
  return count;
}

std::uint64_t PoseBoard::lost_from_journal() const noexcept {
  return journal_ == nullptr ? 0 : journal_->lost.load(std::memory_order_relaxed);
}

}  // namespace acus::tracking
