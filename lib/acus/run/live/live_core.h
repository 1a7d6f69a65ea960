// One step of a live session: reads the devices, computes forces, passes all data on.
#pragma once

#include <Eigen/Geometry>
#include <atomic>
#include <cstdint>
#include <optional>

#include "acus/physics/forces/path/chatter_meter.h"
#include "acus/rig/haptics/device_reading.h"
#include "acus/rig/tracking/pose_board.h"
#include "acus/run/live/command_queue.h"
#include "acus/run/live/core_statistics.h"
#include "acus/run/live/force_mailbox.h"
#include "acus/run/live/live_breath.h"
#include "acus/run/live/live_snapshot.h"
#include "acus/run/live/needle_stop.h"
#include "acus/run/live/pose_gate.h"
#include "acus/run/live/recorder.h"
#include "acus/run/live/step_feed.h"
#include "acus/run/live/triple_buffer.h"
#include "acus/run/step/step_inputs.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::live {

/// How a tool is mounted on a device or tracked marker, and the pose of that. mm.
struct ToolMount {
  Eigen::Isometry3d reference_from_device = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d handle_from_tool = Eigen::Isometry3d::Identity();
  bool by_virtual_hand = false;  ///< Its needle stops at bone and, with its hub, at the skin.
};

/// A tool that is read from a board: of a tracker, or of a device whose servo does not run the
/// steps.
struct BoardTool {
  const tracking::PoseBoard* board = nullptr;
  std::size_t tool = 0;
  ToolMount mount;
  double stale_s = 0.1;  ///< Readings older than this: the tool is not seen.
};

/// A belt or marker that follows the patient's breath: the level is linear along an axis.
struct BoardBelt {
  const tracking::PoseBoard* board = nullptr;
  std::size_t tool = 0;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< In the tracker's frame, unit length.
  double expiration_mm = 0.0;                       ///< Position along the axis at expiration.
  double inspiration_mm = 10.0;
};

struct CoreSettings {
  std::int64_t origin_ns = 0;  ///< CLOCK_MONOTONIC at time 0 of the session.
  double rate_hz = 1000.0;     ///< Nominal rate of the device whose servo runs the steps.
  ToolMount servo;             ///< The tool on that device.
  bool servo_is_needle = true;
  std::optional<BoardTool> other;  ///< The other tool, if there is one.
  std::optional<BoardBelt> belt;
  PoseGateSettings gate;
  /// A swap of hands also swaps the tools' mounts: both are on haptic devices.
  bool tools_change_handles = false;
  double snapshot_s = 0.004;  ///< Smallest interval of snapshots.
  StepFeed* feed = nullptr;   ///< Receives the input of each step. Null: none.
};

/// Tick() runs in one thread, the servo of a haptic device; it takes no lock, allocates nothing,
/// never waits and does not throw. The other threads read its results.
class LiveCore {
 public:
  /// @param scene, recorder, boards  Must outlive this. @param recorder  Null: nothing is recorded.
  /// @param partner  The patient's breath, if the scene takes the breath from the session.
  LiveCore(const simulation::Scene& scene, const CoreSettings& settings, Recorder* recorder,
           const simulation::Breathing* partner);

  /// One step. The force is zero if the tool is not seen or forces are paused; it has not passed a
  /// guard yet.
  haptics::DeviceForce Tick(const haptics::DeviceReading& reading) noexcept;

  /// For HapticDevice::Start().
  haptics::Servo servo() noexcept;

  /// The force for a device with its own servo that holds the other tool. Any thread. Zero if there
  /// was no step for 20 ms.
  haptics::DeviceForce OtherForce(std::int64_t now_ns) const noexcept;

  CommandQueue& commands() noexcept { return commands_; }
  TripleBuffer<LiveSnapshot>& snapshots() noexcept { return snapshots_; }
  const CoreStatistics& statistics() const noexcept { return statistics_; }
  /// Costs of the stages of the steps. Only to be read while Tick() is not called.
  const simulation::StageTimes& stage_times() const noexcept { return stage_times_; }
  /// Session time of the last step, ns. Any thread.
  std::int64_t session_ns() const noexcept { return session_ns_.load(std::memory_order_relaxed); }
  /// The obstacle that stops the needle of a virtual hand. Any thread.
  StopKind stopped_by() const noexcept { return stopped_by_.load(std::memory_order_relaxed); }
  bool hands_swapped() const noexcept { return hands_swapped_.load(std::memory_order_relaxed); }

 private:
  /// A tool's reading in the reference frame.
  struct Tool {
    session::PoseSample sample{.valid = false};
    PoseVerdict verdict = PoseVerdict::kNotSeen;
    std::int64_t measured_ns = 0;
    const ToolMount* mount = nullptr;  ///< Null: there is no such tool.
  };

  void TakeOrders() noexcept;
  void Obey(const CommandQueue::Order& order) noexcept;
  void ReadTools(const haptics::DeviceReading& reading) noexcept;
  Tool ReadServo(const haptics::DeviceReading& reading) noexcept;
  Tool ReadOther(std::int64_t now_ns) noexcept;
  void HoldNeedle() noexcept;
  Eigen::Vector3d BracedInCtN() const noexcept;
  void ReadBelt() noexcept;
  void Step() noexcept;
  void Feed() noexcept;
  haptics::DeviceForce ForceOn(const Tool& tool, const Eigen::Vector3d& force_in_ct_n,
                               const Eigen::Vector3d& torque_in_ct_n_mm) const noexcept;
  void Show(const haptics::DeviceForce& on_needle, const haptics::DeviceForce& on_probe) noexcept;
  void MeasureChatter(const Eigen::Vector3d& on_needle_n, std::int64_t reading_ns) noexcept;
  void Count(const haptics::DeviceReading& reading, double begin_cpu_s) noexcept;

  const simulation::Scene& scene_;
  CoreSettings settings_;
  Recorder* recorder_;
  simulation::Simulation simulation_;
  simulation::State state_;
  simulation::StageTimes stage_times_;
  step::StepInputs inputs_;
  bool shapes_ = false;

  std::optional<LiveBreath> breath_;
  std::optional<NeedleStop> stop_;
  PoseGate servo_gate_;
  PoseGate other_gate_;
  std::uint64_t other_number_ = 0;  ///< Number of the last reading that was judged.
  PoseVerdict other_verdict_ = PoseVerdict::kNotSeen;
  std::uint64_t belt_number_ = 0;

  CommandQueue commands_;
  TripleBuffer<LiveSnapshot> snapshots_;
  ForceMailbox other_force_;
  CoreStatistics statistics_;
  forces::ChatterMeter needle_chatter_;
  std::atomic<std::int64_t> session_ns_{0};

  // Data of the present step.
  StepRecord record_;
  Tool needle_;
  Tool probe_;
  Eigen::Vector3d held_in_ct_n_ = Eigen::Vector3d::Zero();  ///< By the obstacle, on the needle.
  std::atomic<StopKind> stopped_by_{StopKind::kNone};
  bool started_ = false;
  std::int64_t last_reading_ns_ = 0;
  std::int64_t shown_ns_ = 0;
  std::atomic<bool> hands_swapped_{false};
  std::optional<double> gain_db_;
  std::optional<double> depth_mm_;
  double plunger_n_ = 0.0;
  bool frozen_ = false;
  bool breath_held_ = false;  ///< As ordered, of a patient whose breath does not move tissue too.
  bool forces_paused_ = false;
  std::optional<Eigen::Vector3d> target_in_ct_mm_;
};

}  // namespace acus::live
