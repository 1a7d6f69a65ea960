#include "acus/run/live/live_core.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/monotonic_time.h"

namespace acus::live {
namespace {

using haptics::DeviceForce;
using haptics::DeviceReading;
using session::CommandKind;

constexpr std::int64_t kOldestForceNs = 20'000'000;
constexpr double kHeldNPerMm = 5.0;  ///< The stiffness of bone in the tables of forces.

std::int64_t Nanoseconds(double seconds) noexcept {
  return std::llround(1e9 * seconds);
}

/// Guards pass only rigid poses; a core without a guard must not fail on others.
bool IsRigid(const Eigen::Isometry3d& pose) noexcept {
  return pose.matrix().allFinite() &&
         (pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity())
                 .cwiseAbs()
                 .maxCoeff() < 1e-3;
}

void Add(CoreStatistics::Count& count, std::int64_t by = 1) noexcept {
  count.fetch_add(by, std::memory_order_relaxed);
}

}  // namespace

LiveCore::LiveCore(const simulation::Scene& scene, const CoreSettings& settings, Recorder* recorder,
                   const simulation::Breathing* partner)
    : scene_(scene),
      settings_(settings),
      recorder_(recorder),
      simulation_(scene),
      state_(simulation_.NewState()),
      stage_times_(scene.plan),
      inputs_(scene, {.needle = settings.servo_is_needle || settings.other,
                      .probe = !settings.servo_is_needle || settings.other}),
      servo_gate_(settings.gate),
      other_gate_(settings.gate) {
  shapes_ = scene.plan.Writes(effects::ports::kShape);
  if (scene.needle && (scene.labels || (scene.hu && scene.hu_tissues))) {
    stop_.emplace(scene.labels ? forces::TissueLookup(*scene.labels)
                               : forces::TissueLookup(*scene.hu, *scene.hu_tissues),
                  scene.needle->length_mm);
  }
  if (partner != nullptr) breath_.emplace(*partner, settings.belt.has_value());
}

haptics::Servo LiveCore::servo() noexcept {
  return {.tick =
              [](void* core, const DeviceReading& reading) noexcept {
                return static_cast<LiveCore*>(core)->Tick(reading);
              },
          .context = this};
}

DeviceForce LiveCore::OtherForce(std::int64_t now_ns) const noexcept {
  return other_force_.Get(now_ns, kOldestForceNs);
}

DeviceForce LiveCore::Tick(const DeviceReading& reading) noexcept {
  const double begin_cpu_s = ThreadCpuSeconds();
  Add(statistics_.ticks);
  const std::int64_t time_ns = reading.time_ns - settings_.origin_ns;
  if (started_ && time_ns <= record_.time_ns) {
    Add(statistics_.time_back);
    return {};
  }
  if (!started_) state_.session_start_ns = time_ns;
  record_.time_ns = time_ns;
  TakeOrders();
  ReadTools(reading);
  Step();
  const DeviceForce on_needle =
      ForceOn(needle_, record_.output.force.force_in_ct_n + held_in_ct_n_ - BracedInCtN(),
              record_.output.force.torque_in_ct_n_mm);
  const DeviceForce on_probe =
      ForceOn(probe_, record_.output.probe.force_in_ct_n, record_.output.probe.torque_in_ct_n_mm);
  if (recorder_ != nullptr) recorder_->Push(record_);
  Feed();
  const bool servo_holds_needle = settings_.servo_is_needle != hands_swapped_;
  other_force_.Put(servo_holds_needle ? on_probe : on_needle, reading.time_ns);
  Show(on_needle, on_probe);
  session_ns_.store(time_ns, std::memory_order_relaxed);
  MeasureChatter(on_needle.force_n, reading.time_ns);
  Count(reading, begin_cpu_s);
  started_ = true;
  return servo_holds_needle ? on_needle : on_probe;
}

void LiveCore::TakeOrders() noexcept {
  record_.num_commands = 0;
  CommandQueue::Order order;
  while (record_.num_commands < StepRecord::kMaxCommands && commands_.Take(order)) {
    Obey(order);
    record_.command[static_cast<std::size_t>(record_.num_commands++)] = {
        .time_ns = record_.time_ns, .kind = order.kind, .value = order.value};
  }
}

void LiveCore::Obey(const CommandQueue::Order& order) noexcept {
  switch (order.kind) {
    case CommandKind::kHoldBreath:
    case CommandKind::kBreatheOn:
      breath_held_ = order.kind == CommandKind::kHoldBreath;
      if (breath_) breath_->Hold(breath_held_);
      break;
    case CommandKind::kFreezeImage:
    case CommandKind::kRunImage:
      frozen_ = order.kind == CommandKind::kFreezeImage;
      break;
    case CommandKind::kMarkTarget:
      if (needle_.verdict == PoseVerdict::kGood) {
        target_in_ct_mm_ =
            scene_.ct_from_reference * needle_.sample.reference_from_tool.translation().eval();
      }
      break;
    case CommandKind::kSwapHands:
      if (!settings_.other) break;
      hands_swapped_ = !hands_swapped_;
      if (settings_.tools_change_handles) {
        std::swap(settings_.servo.handle_from_tool, settings_.other->mount.handle_from_tool);
      }
      break;
    case CommandKind::kPauseForces:
    case CommandKind::kResumeForces:
      forces_paused_ = order.kind == CommandKind::kPauseForces;
      break;
    case CommandKind::kGain:
      gain_db_ = order.value;
      break;
    case CommandKind::kDepth:
      depth_mm_ = order.value;
      break;
    case CommandKind::kPlunger:
      plunger_n_ = order.value;
      break;
    case CommandKind::kView:
      break;  // For the window: only recorded.
  }
}

LiveCore::Tool LiveCore::ReadServo(const DeviceReading& reading) noexcept {
  const ToolMount& mount = settings_.servo;
  PoseVerdict verdict = PoseVerdict::kNotFinite;
  if (IsRigid(reading.device_from_handle)) {
    const transforms::Pose pose(Eigen::Isometry3d(
        mount.reference_from_device * reading.device_from_handle * mount.handle_from_tool));
    verdict = servo_gate_.Judge(reading.time_ns, pose, reading.valid);
  }
  return {.sample = {record_.time_ns, servo_gate_.last_good(), verdict == PoseVerdict::kGood},
          .verdict = verdict,
          .measured_ns = reading.time_ns,
          .mount = &mount};
}

LiveCore::Tool LiveCore::ReadOther(std::int64_t now_ns) noexcept {
  const BoardTool& other = *settings_.other;
  const tracking::TrackedPose latest = other.board->Latest(other.tool);
  if (latest.AgeNs(now_ns) > Nanoseconds(other.stale_s)) {
    other_verdict_ = other_gate_.Judge(now_ns, {}, false);
  } else if (latest.number != other_number_) {
    // A tracker is slower than the steps: each of its readings is judged once, and used until the
    // next one.
    const transforms::Pose pose(Eigen::Isometry3d(other.mount.reference_from_device *
                                                  latest.reference_from_tool.isometry() *
                                                  other.mount.handle_from_tool));
    other_verdict_ = other_gate_.Judge(latest.time_ns, pose, latest.valid);
    other_number_ = latest.number;
  }
  return {
      .sample = {record_.time_ns, other_gate_.last_good(), other_verdict_ == PoseVerdict::kGood},
      .verdict = other_verdict_,
      .measured_ns = latest.measured_ns,
      .mount = &other.mount};
}

void LiveCore::ReadTools(const DeviceReading& reading) noexcept {
  const Tool servo = ReadServo(reading);
  const Tool other = settings_.other ? ReadOther(reading.time_ns) : Tool{};
  const bool servo_holds_needle = settings_.servo_is_needle != hands_swapped_;
  needle_ = servo_holds_needle ? servo : other;
  probe_ = servo_holds_needle ? other : servo;
  needle_.sample.time_ns = probe_.sample.time_ns = record_.time_ns;
  HoldNeedle();
  record_.needle = needle_.sample;
  record_.probe = probe_.sample;
  if (needle_.mount != nullptr) Add(statistics_.needle[static_cast<std::size_t>(needle_.verdict)]);
  if (probe_.mount != nullptr) Add(statistics_.probe[static_cast<std::size_t>(probe_.verdict)]);
}

/// Records and steps with the held pose of the needle, so that a replay is the same.
void LiveCore::HoldNeedle() noexcept {
  held_in_ct_n_.setZero();
  NeedleStop::Held held;
  if (stop_ && needle_.verdict != PoseVerdict::kGood) stop_->Forget();
  if (stop_ && needle_.verdict == PoseVerdict::kGood && needle_.mount->by_virtual_hand) {
    Eigen::Isometry3d pose = needle_.sample.reference_from_tool.isometry();
    const Eigen::Isometry3d ct_from_needle = scene_.ct_from_reference * pose;
    // The tissue moves little from step to step.
    const Eigen::Isometry3d at_rest = record_.output.needle_at_rest.ct_from_tool *
                                      record_.output.ct_from_needle.inverse() * ct_from_needle;
    held = stop_->At(at_rest.translation(), at_rest.linear().col(2));
    if (held.beyond_mm > 0.0) {
      pose.translation() -= held.beyond_mm * pose.linear().col(2);
      needle_.sample.reference_from_tool = transforms::Pose(pose);
      held_in_ct_n_ = -kHeldNPerMm * held.beyond_mm * ct_from_needle.linear().col(2);
    }
  }
  stopped_by_.store(held.by, std::memory_order_relaxed);
}

/// A person holds the needle against the other hand's thumb; a virtual hand does not feel that
/// force either.
Eigen::Vector3d LiveCore::BracedInCtN() const noexcept {
  if (needle_.mount == nullptr || !needle_.mount->by_virtual_hand) return Eigen::Vector3d::Zero();
  return record_.output.added_in_ct_n;
}

void LiveCore::ReadBelt() noexcept {
  const BoardBelt& belt = *settings_.belt;
  const tracking::TrackedPose latest = belt.board->Latest(belt.tool);
  if (latest.number == belt_number_) return;
  belt_number_ = latest.number;
  if (!latest.valid) return;
  const double along_mm = belt.axis.dot(latest.reference_from_tool.translation());
  breath_->ReadBelt(1e-9 * static_cast<double>(latest.time_ns - settings_.origin_ns),
                    (along_mm - belt.expiration_mm) / (belt.inspiration_mm - belt.expiration_mm));
}

void LiveCore::Step() noexcept {
  breathing::Breath breath;
  if (breath_) {
    if (settings_.belt) ReadBelt();
    record_.breath =
        breath_->Step(1e-9 * static_cast<double>(record_.time_ns - state_.session_start_ns));
    record_.breath.time_ns = record_.time_ns;
    breath = step::BreathOf(record_.breath);
  }
  if (!inputs_.steps()) return;
  record_.output = simulation_.Step(
      state_, inputs_.SampleAt(record_.time_ns, needle_.sample, probe_.sample, breath, plunger_n_),
      &stage_times_);
  Add(statistics_.steps);
}

void LiveCore::Feed() noexcept {
  if (settings_.feed == nullptr) return;
  settings_.feed->Push({.time_ns = record_.time_ns,
                        .needle = record_.needle,
                        .probe = record_.probe,
                        .breath = record_.breath,
                        .gain_db = gain_db_,
                        .depth_mm = depth_mm_,
                        .plunger_n = plunger_n_});
}

DeviceForce LiveCore::ForceOn(const Tool& tool, const Eigen::Vector3d& force_in_ct_n,
                              const Eigen::Vector3d& torque_in_ct_n_mm) const noexcept {
  DeviceForce out;
  if (!inputs_.steps() || forces_paused_ || tool.mount == nullptr ||
      tool.verdict != PoseVerdict::kGood) {
    return out;
  }
  const Eigen::Matrix3d device_from_ct =
      (scene_.ct_from_reference.linear() * tool.mount->reference_from_device.linear()).transpose();
  out.force_n = device_from_ct * force_in_ct_n;
  // Models give the torque about the tool's origin; the hand applies that about the handle's.
  const Eigen::Vector3d handle_to_tool_in_reference_mm =
      tool.sample.reference_from_tool.linear() *
      (tool.mount->handle_from_tool.linear().transpose() *
       tool.mount->handle_from_tool.translation());
  const Eigen::Vector3d handle_to_tool_mm =
      tool.mount->reference_from_device.linear().transpose() * handle_to_tool_in_reference_mm;
  out.torque_nmm = device_from_ct * torque_in_ct_n_mm + handle_to_tool_mm.cross(out.force_n);
  return out;
}

void LiveCore::Show(const DeviceForce& on_needle, const DeviceForce& on_probe) noexcept {
  if (started_ && record_.time_ns - shown_ns_ < Nanoseconds(settings_.snapshot_s)) return;
  shown_ns_ = record_.time_ns;
  LiveSnapshot& out = snapshots_.Back();
  out.moment = {};
  out.moment.time_ns = record_.time_ns;
  out.moment.session_s = 1e-9 * static_cast<double>(record_.time_ns - state_.session_start_ns);
  out.moment.breath = step::BreathOf(record_.breath);
  out.moment.probe_valid = probe_.sample.valid;
  out.moment.ct_from_probe = scene_.ct_from_reference * probe_.sample.reference_from_tool;
  if (needle_.sample.valid && inputs_.reads_needle()) {
    out.moment.ct_from_needle = scene_.ct_from_reference * needle_.sample.reference_from_tool;
  }
  out.moment.needle_force_in_ct_n = record_.output.force.force_in_ct_n;
  out.has_shape = shapes_ && simulation_.ShapeOf(state_, out.shape);
  out.has_load = scene_.tools_deform_images && simulation_.LoadOf(state_, record_.output, out.load);
  out.has_memory = scene_.listed.has_steps();
  if (out.has_memory) out.memory = state_.effects;
  out.output = record_.output;
  out.needle_valid = needle_.sample.valid;
  out.needle_force_n = on_needle.force_n.norm();
  out.probe_force_n = on_probe.force_n.norm();
  out.breath = record_.breath;
  out.breath_held = breath_ ? breath_->holds() : breath_held_;
  out.frozen = frozen_;
  out.hands_swapped = hands_swapped_;
  out.forces_paused = forces_paused_;
  out.gain_db = gain_db_;
  out.depth_mm = depth_mm_;
  out.plunger_n = plunger_n_;
  out.target_in_ct_mm = target_in_ct_mm_;
  out.measured_ns = probe_.sample.valid ? probe_.measured_ns : needle_.measured_ns;
  snapshots_.Publish();
}

void LiveCore::MeasureChatter(const Eigen::Vector3d& on_needle_n,
                              std::int64_t reading_ns) noexcept {
  constexpr double kFeltN = 0.01;  ///< Threshold below 30 Hz.
  if (!started_) return;
  needle_chatter_.Add(1e-9 * static_cast<double>(reading_ns - last_reading_ns_), on_needle_n,
                      needle_chatter_.slow_n().norm() > kFeltN);
  statistics_.needle_chatter_n.store(needle_chatter_.RmsN(), std::memory_order_relaxed);
}

void LiveCore::Count(const DeviceReading& reading, double begin_cpu_s) noexcept {
  const double period_s = 1.0 / settings_.rate_hz;
  if (started_) {
    const std::int64_t interval_ns = reading.time_ns - last_reading_ns_;
    statistics_.interval.Add(interval_ns);
    const auto periods = static_cast<std::int64_t>(
        std::floor(1e-9 * static_cast<double>(interval_ns) / period_s + 0.5));
    if (periods > 1) Add(statistics_.missed_by_machine, periods - 1);
  }
  last_reading_ns_ = reading.time_ns;
  const double cpu_s = ThreadCpuSeconds() - begin_cpu_s;
  statistics_.step_cpu.Add(Nanoseconds(cpu_s));
  if (cpu_s > period_s) Add(statistics_.missed_by_computation);
  statistics_.device_to_force.Add(MonotonicNs() - reading.time_ns);
}

}  // namespace acus::live
