// One step of a live session: readings of the devices in, forces out, everything handed on.
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

/// How a tool sits on a device or tracked marker, and where that is. mm.
struct ToolMount {
  Eigen::Isometry3d reference_from_device = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d handle_from_tool = Eigen::Isometry3d::Identity();
  bool by_virtual_hand = false;  ///< Its needle is held where bone and the skin stop it.
};

/// A tool that is read from a board: of a tracker, or of a device with a servo of its own.
struct BoardTool {
  const tracking::PoseBoard* board = nullptr;
  std::size_t tool = 0;
  ToolMount mount;
  double stale_s = 0.1;  ///< News older than this: the tool is not seen.
};

/// A belt or marker that follows the patient's breath: the level is linear along an axis.
struct BoardBelt {
  const tracking::PoseBoard* board = nullptr;
  std::size_t tool = 0;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< Of the tracker's frame, unit length.
  double expiration_mm = 0.0;                       ///< Along the axis.
  double inspiration_mm = 10.0;
};

struct CoreSettings {
  std::int64_t origin_ns = 0;  ///< CLOCK_MONOTONIC at time 0 of the session.
  double rate_hz = 1000.0;     ///< Nominal, of the device whose servo runs the steps.
  ToolMount servo;             ///< What that device holds.
  bool servo_is_needle = true;
  std::optional<BoardTool> other;  ///< The other tool, if there is one.
  std::optional<BoardBelt> belt;
  PoseGateSettings gate;
  /// When hands are swapped, what is fixed to the handles goes along: both are haptic devices.
  bool tools_change_handles = false;
  double snapshot_s = 0.004;  ///< At most this often.
  StepFeed* feed = nullptr;   ///< Is given the input of each step. Null: nobody wants it.
};

/// All of Tick() runs in one thread, the servo of a haptic device; it takes no lock, allocates
/// nothing, waits for nobody and does not throw. The others read what it leaves.
class LiveCore {
 public:
  /// @param scene, recorder, boards  Must outlive this. @param recorder  Null: nothing is recorded.
  /// @param partner  Says how the patient breathes, if the scene breathes as the session says.
  LiveCore(const simulation::Scene& scene, const CoreSettings& settings, Recorder* recorder,
           const simulation::Breathing* partner);

  /// One step. The force is zero where the tool is not seen, or forces are paused; it has not
  /// passed a guard yet.
  haptics::DeviceForce Tick(const haptics::DeviceReading& reading) noexcept;

  /// For HapticDevice::Start().
  haptics::Servo servo() noexcept;

  /// The force for a device with a servo of its own that holds the other tool. Any thread. Zero if
  /// no step came for 20 ms.
  haptics::DeviceForce OtherForce(std::int64_t now_ns) const noexcept;

  CommandQueue& commands() noexcept { return commands_; }
  TripleBuffer<LiveSnapshot>& snapshots() noexcept { return snapshots_; }
  const CoreStatistics& statistics() const noexcept { return statistics_; }
  /// What the stages of the steps did. Only to be read while nobody calls Tick().
  const simulation::StageTimes& stage_times() const noexcept { return stage_times_; }
  /// Session time of the last step, ns. Any thread.
  std::int64_t session_ns() const noexcept { return session_ns_.load(std::memory_order_relaxed); }
  /// What keeps the needle of a virtual hand from going further in. Any thread.
  StopKind stopped_by() const noexcept { return stopped_by_.load(std::memory_order_relaxed); }
  bool hands_swapped() const noexcept { return hands_swapped_.load(std::memory_order_relaxed); }

 private:
  /// A tool as read, in the reference frame.
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
  std::uint64_t other_number_ = 0;  ///< Of the last reading that was judged.
  PoseVerdict other_verdict_ = PoseVerdict::kNotSeen;
  std::uint64_t belt_number_ = 0;

  CommandQueue commands_;
  TripleBuffer<LiveSnapshot> snapshots_;
  ForceMailbox other_force_;
  CoreStatistics statistics_;
  forces::ChatterMeter needle_chatter_;
  std::atomic<std::int64_t> session_ns_{0};

  // Of the present step.
  StepRecord record_;
  Tool needle_;
  Tool probe_;
  Eigen::Vector3d held_in_ct_n_ = Eigen::Vector3d::Zero();  ///< On the needle, by what stops it.
  std::atomic<StopKind> stopped_by_{StopKind::kNone};
  bool started_ = false;
  std::int64_t last_reading_ns_ = 0;
  std::int64_t shown_ns_ = 0;
  std::atomic<bool> hands_swapped_{false};
  std::optional<double> gain_db_;
  std::optional<double> depth_mm_;
  double plunger_n_ = 0.0;
  bool frozen_ = false;
  bool forces_paused_ = false;
  std::optional<Eigen::Vector3d> target_in_ct_mm_;
};

}  // namespace acus::live
