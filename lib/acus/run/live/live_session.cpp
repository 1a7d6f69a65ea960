#include "acus/run/live/live_session.h"

#include <chrono>
#include <cmath>
#include <ranges>
#include <set>
#include <thread>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/output_check.h"
#include "acus/base/core/text_table.h"
#include "acus/data/session/session_import.h"
#include "acus/rig/haptics/open_device.h"
#include "acus/rig/haptics/zero_forces.h"
#include "acus/run/live/slicer_files.h"
#include "acus/run/live/start_on_skin.h"
#include "acus/run/live/tracked_driver.h"
#include "acus/run/replay/markups.h"
#include "acus/run/replay/pain_sound.h"
#include "acus/run/replay/training_log.h"
#include "acus/run/training/exercise.h"
#include "acus/run/training/session_metrics.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;

/// A device follows a recorded tool, back and forth without end.
haptics::GoalPath PathOf(const session::PoseStream& stream, std::int64_t start_ns,
                         const Eigen::Isometry3d& reference_from_device,
                         const Eigen::Isometry3d& handle_from_tool) {
  constexpr std::int64_t kLeastNs = 5'000'000;  // 200 points a second are enough for a hand.
  haptics::GoalPath path;
  path.between = haptics::GoalPath::Between::kLinear;
  std::int64_t last_ns = 0;
  for (const session::PoseSample& sample : stream) {
    if (!sample.valid || (!path.points.empty() && sample.time_ns - last_ns < kLeastNs)) continue;
    last_ns = sample.time_ns;
    path.points.push_back({1e-9 * static_cast<double>(sample.time_ns - start_ns),
                           reference_from_device.inverse() * sample.reference_from_tool.isometry() *
                               handle_from_tool.inverse()});
  }
  const double end_s = path.points.empty() ? 0.0 : path.points.back().time_s;
  for (std::size_t i = path.points.size(); i-- > 0;) {
    if (path.points[i].time_s >= end_s) continue;
    path.points.push_back({2.0 * end_s - path.points[i].time_s, path.points[i].device_from_handle});
  }
  path.repeats = true;
  return path;
}

bool OnlyVirtualHands(const LiveDevices& devices) {
  return devices.trackers.empty() && !devices.camera && !devices.belt && !devices.images_from &&
         !devices.send_out &&
         std::ranges::all_of(devices.haptics.devices, [](const haptics::DeviceConfig& device) {
           return device.driver == haptics::DriverKind::kVirtualHand;
         });
}

constexpr double kCorrectionS = 0.3;        // Time constant of a hand that watches its tool.
constexpr std::size_t kWordsThatTell = 40;  // Prefix of a status line; numbers follow.

}  // namespace

void UseExercise(const fs::path& file, LiveOptions& options, RunContext& context) {
  options.exercise = training::ReadExercise(file);
  options.name = options.exercise->name;
  context.provenance.AddInput(file);
}

simulation::Scene LoadLiveScene(const scenario::Scenario& scenario, const LiveDevices& devices,
                                RunContext& context) {
  const bool follows =
      scenario.breathing && scenario.breathing->from_session != scenario::SessionBreath::kNever;
  const auto plan = simulation::PlanEffects(scenario, {.needle_poses = devices.has_needle(),
                                                       .probe_poses = devices.has_probe(),
                                                       .breath = follows});
  return simulation::LoadScene(scenario, plan, context);
}

/// The servo of the device that does not run the steps.
struct LiveSession::Bridge {
  tracking::PoseBoard board{{"other"}};
  std::atomic<LiveCore*> core{nullptr};

  static haptics::DeviceForce Tick(void* context, const haptics::DeviceReading& reading) noexcept {
    auto& bridge = *static_cast<Bridge*>(context);
    tracking::TrackedPose pose;
    pose.time_ns = pose.measured_ns = reading.time_ns;
    pose.valid = reading.valid;
    if (reading.valid) pose.reference_from_tool = reading.device_from_handle;
    bridge.board.Publish(0, pose);
    const LiveCore* core = bridge.core.load(std::memory_order_acquire);
    return core == nullptr ? haptics::DeviceForce{} : core->OtherForce(reading.time_ns);
  }
};

std::string_view NameOf(SessionEnd end) {
  constexpr std::array<std::string_view, 4> kNames = {"running", "duration", "stopped",
                                                      "device failed"};
  return kNames[static_cast<std::size_t>(end)];
}

LiveSession::LiveSession(const scenario::Scenario& scenario, const LiveDevices& devices,
                         const LiveOptions& options, RunContext& context)
    // In this order: errors of the scenario are reported before those of devices.
    : LiveSession{
          scenario,
          std::make_shared<const simulation::Scene>(LoadLiveScene(scenario, devices, context)),
          std::make_shared<Rig>(devices,
                                options.only_checks ? Rig::Use::kCheck : Rig::Use::kOneSession),
          options, context} {}

LiveSession::LiveSession(const scenario::Scenario& scenario,
                         std::shared_ptr<const simulation::Scene> scene, std::shared_ptr<Rig> rig,
                         const LiveOptions& options, RunContext& context)
    : options_(options),
      context_(context),
      name_(!options.name.empty() ? options.name : scenario.name),
      scene_(std::move(scene)),
      rig_(std::move(rig)),
      devices_(rig_->devices()) {
  if (options_.left_handed) devices_.haptics.SwapHands();
  if (scene_->breathing && scene_->plan.breath_from_session()) {
    partner_.emplace(simulation::LoadBreathing(scenario, /*from_session=*/false, context));
  }
  if (options.exercise) {
    replay::RequireAssessable(*options.exercise, scenario, *scene_, nullptr);
    ACUS_REQUIRE(has_needle(), "an exercise needs a needle; these devices have none");
    exercise_.emplace(*options.exercise, *scene_, replay::TargetInCtMm(*options.exercise, scenario),
                      has_probe());
  }
  pain_sound_ = replay::PainSoundOf(scenario, context);
  if (devices_.images_from) digest_ = DigestOf(scenario, *scene_);
  targets_ = replay::TargetsOf(options.exercise ? &*options.exercise : nullptr, scenario);
  PlaceProbeOnSkin();
  if (!options.hand.empty()) FollowSession(devices_, options.hand);
  TakeDevices();
  if (options_.only_checks) CheckStart();
}

/// Checks everything that Start() requires before its first step.
void LiveSession::CheckStart() const {
  if (!options_.session_folder.empty())
    RequireFolderCanBeMade(options_.session_folder, context_.overwrite);
  if (devices_.send_out) RequirePortFree(*devices_.send_out);
}

LiveSession::~LiveSession() {
  Stop();
}

void LiveSession::FollowSession(LiveDevices& devices, const fs::path& path) {
  const session::Session session = session::ReadAnySession(path, {}, context_).session;
  const std::int64_t start_ns = session.start_ns();
  for (session::Command command : session.commands) {
    command.time_ns -= start_ns;
    followed_commands_.push_back(command);
  }
  for (const auto& [tool, stream] : {std::pair{&devices.haptics.needle, &session.needle},
                                     {&devices.haptics.probe, &session.probe}}) {
    if (tool->device.empty() || stream->empty()) continue;
    for (haptics::DeviceConfig& device : devices.haptics.devices) {
      if (device.name != tool->device) continue;
      ACUS_REQUIRE(device.driver == haptics::DriverKind::kVirtualHand, "--hand: the device \"",
                   device.name, "\" is held by a real hand; only a virtual_hand can follow ",
                   path.string());
      device.hand.path = PathOf(*stream, start_ns, devices.reference_from_device.at(device.name),
                                tool->handle_from_tool);
      device.hand.correction_s = kCorrectionS;
      followed_s_ =
          std::max(followed_s_, 1e-9 * static_cast<double>(stream->back().time_ns - start_ns));
    }
  }
}

/// A virtual hand without a given path begins with the probe in contact.
void LiveSession::PlaceProbeOnSkin() {
  const haptics::ToolConfig& probe = devices_.haptics.probe;
  if (probe.device.empty() || scene_->labels == nullptr) return;
  for (haptics::DeviceConfig& device : devices_.haptics.devices) {
    if (device.name != probe.device || device.driver != haptics::DriverKind::kVirtualHand ||
        !device.hand.path.points.empty()) {
      continue;
    }
    const Eigen::Isometry3d reference_from_device = devices_.reference_from_device.at(device.name);
    const Eigen::Isometry3d on_skin =
        OnSkin(reference_from_device * probe.handle_from_tool,
               training::LabelsOf({*scene_->labels, scene_->ct_from_reference}));
    device.hand.path.points.push_back(
        {0.0, reference_from_device.inverse() * on_skin * probe.handle_from_tool.inverse()});
  }
}

/// A device of the rig; a virtual hand is constructed for this session.
haptics::HapticDevice* LiveSession::Take(const haptics::ToolConfig& tool) {
  if (haptics::HapticDevice* device = rig_->Find(tool.device)) return device;
  const auto steering = std::make_shared<haptics::HandSteering>();
  steering_[tool.device] = steering;
  const haptics::DeviceConfig& config = *devices_.haptics.Find(tool.device);
  if (options_.virtual_time) {
    using haptics::VirtualHandDriver;
    auto driver = std::make_unique<VirtualHandDriver>(config.hand, steering,
                                                      VirtualHandDriver::Clock::kStepped);
    stepped_.push_back(driver.get());
    own_devices_.push_back(
        std::make_unique<haptics::HapticDevice>(std::move(driver), config.safety));
  } else {
    own_devices_.push_back(haptics::OpenDevice(config, steering));
  }
  return own_devices_.back().get();
}

void LiveSession::TakeDevices() {
  ACUS_REQUIRE(!options_.virtual_time || OnlyVirtualHands(devices_),
               "--virtual-time: the devices file must have virtual hands only, no tracker, camera, "
               "belt, images_from or send_out: these have a clock of their own");
  const auto mount = [&](const haptics::ToolConfig& tool) {
    return ToolMount{.reference_from_device = devices_.reference_from_device.at(tool.device),
                     .handle_from_tool = tool.handle_from_tool,
                     .by_virtual_hand = steering_.contains(tool.device)};
  };
  const auto tracked = [&](const char* tool) -> std::optional<BoardTool> {
    const auto place = devices_.FindTracked(tool);
    if (!place) return {};
    return BoardTool{.board = &rig_->trackers()[place->tracker]->board(),
                     .tool = place->tool,
                     .mount = {},
                     .stale_s = place->stale_s};
  };
  const haptics::ToolConfig& needle = devices_.haptics.needle;
  const haptics::ToolConfig& probe = devices_.haptics.probe;
  // Motors require steps at their rate: a device with motors runs them, rather than a tracker.
  if (!needle.device.empty()) {
    servo_device_ = Take(needle);
    core_settings_.servo = mount(needle);
    if (!probe.device.empty()) {
      other_device_ = Take(probe);
      bridge_ = std::make_unique<Bridge>();
      core_settings_.other =
          BoardTool{.board = &bridge_->board, .tool = 0, .mount = mount(probe), .stale_s = 0.02};
      core_settings_.tools_change_handles = true;
    } else {
      core_settings_.other = tracked("probe");
    }
  } else if (!probe.device.empty()) {
    servo_device_ = Take(probe);
    core_settings_.servo = mount(probe);
    core_settings_.servo_is_needle = false;
    core_settings_.other = tracked("needle");
  } else {
    const bool by_needle = devices_.FindTracked("needle").has_value();
    const BoardTool tool = *tracked(by_needle ? "needle" : "probe");
    own_devices_.push_back(std::make_unique<haptics::HapticDevice>(
        std::make_unique<TrackedDriver>(*tool.board, tool.tool, tool.stale_s),
        TrackedDriver::Guard()));
    servo_device_ = own_devices_.back().get();
    core_settings_.servo_is_needle = by_needle;
    if (by_needle) core_settings_.other = tracked("probe");
  }
  core_settings_.rate_hz = servo_device_->info().rate_hz;
  if (devices_.belt) {
    const auto place = *devices_.FindTracked(devices_.belt->tool);
    core_settings_.belt = BoardBelt{.board = &rig_->trackers()[place.tracker]->board(),
                                    .tool = place.tool,
                                    .axis = devices_.belt->axis,
                                    .expiration_mm = devices_.belt->expiration_mm,
                                    .inspiration_mm = devices_.belt->inspiration_mm};
  }
}

void LiveSession::MakeCore() {
  if (devices_.images_from) {
    remote_ = std::make_unique<RemoteImages>(*devices_.images_from, *scene_, digest_);
    remote_->Connect();  // Else images are rendered here, with the reason in the status.
    core_settings_.feed = &remote_->feed();
  }
  if (pain_sound_) voice_ = std::make_unique<PatientVoice>(*scene_, *pain_sound_);
  core_settings_.origin_ns = MonotonicNs();
  recorder_ =
      std::make_unique<Recorder>(options_.session_folder, name_,
                                 session::StreamNames{.needle = devices_.has_needle(),
                                                      .probe = devices_.has_probe(),
                                                      .breathing = partner_.has_value(),
                                                      .commands = true,
                                                      .tracker = !rig_->trackers().empty()},
                                 *scene_, core_settings_.origin_ns, options_.recorder, context_);
  std::vector<RecordedBoard> boards;
  tracked_before_.clear();
  for (const auto& tracker : rig_->trackers()) {
    tracked_before_.push_back(tracker->status().counts);
    boards.push_back({.prefix = tracker->name() + "/", .board = &tracker->board()});
  }
  recorder_->AddBoards(std::move(boards));
  if (exercise_) recorder_->SetExercise(&*exercise_);
  core_ = std::make_unique<LiveCore>(*scene_, core_settings_, recorder_.get(),
                                     partner_ ? &*partner_ : nullptr);
  images_ = std::make_unique<ImageThread>(
      *scene_, core_->snapshots(), std::max(scene_->image_rate_hz, options_.least_image_rate_hz),
      [this](const LiveImage& image) {
        if (voice_) voice_->Follow(image.snapshot);
        if (broadcast_) broadcast_->Send(image);
      });
  images_->TakeFrom(remote_.get());
}

void LiveSession::Start() {
  haptics::ZeroForcesOnSignals();
  try {
    MakeCore();
    replay::WriteTargets(options_.session_folder, targets_);
    if (devices_.send_out) {
      broadcast_ =
          std::make_unique<Broadcast>(*devices_.send_out, *scene_, targets_, devices_.has_probe());
      WriteSlicerScene(options_.session_folder, devices_.send_out->host, broadcast_->port(),
                       targets_);
    }
    recorder_->Start();
    rig_->StartTrackers();
    if (remote_) remote_->Start(core_settings_.origin_ns);
    if (!options_.virtual_time) images_->Start();
    started_ = true;
    if (bridge_) bridge_->core = core_.get();
    servo_device_->Start(core_->servo());
    if (other_device_) other_device_->Start({.tick = &Bridge::Tick, .context = bridge_.get()});
  } catch (...) {
    Stop();
    throw;
  }
}

bool LiveSession::Poll() {
  if (end_ != SessionEnd::kRunning) return false;
  ReadRates();
  SendStatus();
  SendFollowedCommands();
  if (context_.stop != nullptr && context_.stop->load(std::memory_order_relaxed)) {
    end_ = SessionEnd::kStopped;
  } else if (IsTimeUp()) {
    end_ = SessionEnd::kDuration;
  } else if (servo_device_->status().state == haptics::DeviceState::kFailed) {
    end_ = SessionEnd::kDeviceFailed;
  }
  return end_ == SessionEnd::kRunning;
}

bool LiveSession::IsTimeUp() const {
  if (options_.duration_s > 0.0) return seconds_running() >= options_.duration_s;
  // A person who has taken over a hand continues.
  return followed_s_ > 0.0 && seconds_running() >= followed_s_ &&
         std::ranges::none_of(steering_,
                              [](const auto& hand) { return hand.second->is_steered(); });
}

void LiveSession::SendFollowedCommands() {
  for (; next_followed_ < followed_commands_.size(); ++next_followed_) {
    const session::Command& next = followed_commands_[next_followed_];
    if (1e-9 * static_cast<double>(next.time_ns) > session_s()) break;
    core_->commands().Give(next.kind, next.value);
  }
}

void LiveSession::RunInVirtualTime(const Look& look) {
  constexpr int kStepsBetweenLooks = 256;
  ACUS_REQUIRE(options_.duration_s > 0.0 || followed_s_ > 0.0,
               "--virtual-time: give --duration, or --hand with a session to follow");
  Start();
  const auto period_ns = static_cast<std::int64_t>(1e9 / core_settings_.rate_hz);
  const auto steps_between_acts = std::llround(kLookS * core_settings_.rate_hz);
  const auto ends = [&](std::int64_t step) {
    if (!look || step == 0 || step % steps_between_acts != 0) return false;
    recorder_->CatchUp();
    core_->snapshots().Refresh();
    return !look(core_->snapshots().Front());
  };
  const auto is_busy = [this] {
    return recorder_->status().steps_waiting >
           static_cast<std::int64_t>(options_.recorder.ring_steps / 2);
  };
  for (std::int64_t step = 0; end_ == SessionEnd::kRunning; ++step) {
    const std::int64_t time_ns = core_settings_.origin_ns + step * period_ns;
    // The probe's hand first: the servo, which makes the step, reads where it is.
    for (haptics::VirtualHandDriver* hand : stepped_ | std::views::reverse) hand->Step(time_ns);
    SendFollowedCommands();
    if (IsTimeUp()) end_ = SessionEnd::kDuration;
    if (ends(step)) end_ = SessionEnd::kStopped;
    if (step % kStepsBetweenLooks != 0) continue;
    if (context_.stop != nullptr && context_.stop->load(std::memory_order_relaxed)) {
      end_ = SessionEnd::kStopped;
    }
    while (is_busy()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  Stop();
}

void LiveSession::ReadRates() {
  constexpr std::int64_t kEachNs = 100'000'000;
  const std::int64_t now_ns = MonotonicNs();
  if (now_ns - rates_read_ns_ < kEachNs) return;
  rates_read_ns_ = now_ns;
  recent_images_.Add(now_ns, image_statistics().images);
  recent_steps_.Add(now_ns, statistics().ticks);
  recent_late_steps_.Add(now_ns, statistics().missed_by_computation);
}

void LiveSession::SendStatus() {
  constexpr std::int64_t kEachNs = 1'000'000'000;
  if (!broadcast_ || MonotonicNs() - status_sent_ns_ < kEachNs) return;
  status_sent_ns_ = MonotonicNs();
  const std::vector<StatusLine> lines = Status();
  const bool is_ok = lines.empty() || lines.front().severity < Severity::kWarning;
  broadcast_->SetStatus(is_ok, lines.empty() ? Message("Running: ", name_) : lines.front().text);
}

void LiveSession::Stop() noexcept {
  for (const auto& device : own_devices_) device->Stop();
  rig_->ReleaseDevices();
  if (bridge_) bridge_->core = nullptr;
  if (images_) images_->Stop();
  if (remote_) remote_->Stop();
  rig_->ReleaseTrackers();
  if (broadcast_) broadcast_->Stop();
  if (recorder_) recorder_->Close();
  if (!started_ || stopped_) return;
  stopped_ = true;
  if (end_ == SessionEnd::kRunning) end_ = SessionEnd::kStopped;
  try {
    config::WriteJson(options_.session_folder / "summary.json", Summary());
  } catch (const std::exception& error) {
    summary_is_written_ = false;
    context_.Warn(Message("summary.json is not written: ", error.what()));
  }
}

HeldTool LiveSession::HeldBy(bool needle) const {
  const haptics::DevicesFile& file = devices_.haptics;
  const bool swapped = core_ && core_->hands_swapped();
  const haptics::ToolConfig& device = needle != swapped ? file.needle : file.probe;
  const haptics::ToolConfig& tool = needle ? file.needle : file.probe;
  const auto found = steering_.find(device.device);
  if (found == steering_.end()) return {};
  return {.hand = found->second,
          .handle_from_tool = tool.handle_from_tool,
          .reference_from_device = devices_.reference_from_device.at(device.device),
          .may_advance = !needle || !core_ || core_->stopped_by() == StopKind::kNone};
}

ForceLimits LiveSession::force_limits() const {
  const auto limit = [this](const haptics::ToolConfig& tool, bool is_needle) {
    const haptics::DeviceConfig* config = devices_.haptics.Find(tool.device);
    if (config == nullptr) return 0.0;
    const bool is_servo = core_settings_.servo_is_needle == is_needle;
    const haptics::HapticDevice& device = is_servo ? *servo_device_ : *other_device_;
    return std::min(config->safety.max_force_n, device.info().max_force_n);
  };
  return {.needle_n = limit(devices_.haptics.needle, true),
          .probe_n = limit(devices_.haptics.probe, false)};
}

bool LiveSession::breath_can_be_held() const {
  using training::StepCondition;
  const auto is_held_in = [](const training::ChecklistStep& step) {
    return step.when == StepCondition::kBreathHeld || step.when == StepCondition::kPositionChecked;
  };
  return partner_.has_value() ||
         (exercise_ && std::ranges::any_of(exercise_->exercise().checklist.steps, is_held_in));
}

void LiveSession::HoldPedal() {
  servo_device_->HoldPedal();
  if (other_device_) other_device_->HoldPedal();
}

double LiveSession::seconds_running() const {
  if (options_.virtual_time) return session_s();
  // By the clock: a silent device causes no steps.
  return 1e-9 * static_cast<double>(MonotonicNs() - core_settings_.origin_ns);
}

bool LiveSession::complete() const {
  return end_ != SessionEnd::kDeviceFailed && recorder_->status().steps_lost == 0 &&
         summary_is_written_;
}

bool RunHeadless(LiveSession& session, const RunContext& context) {
  if (session.in_virtual_time()) {
    session.RunInVirtualTime();
    return session.complete();
  }
  session.Start();
  std::set<std::string> said;
  for (int i = 0; session.Poll(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (i < 50 || i % 10 != 0) continue;  // Connections take time to open.
    std::set<std::string> now;
    for (const StatusLine& line : session.Status()) {
      const std::string what = line.text.substr(0, kWordsThatTell);
      if (line.severity >= Severity::kWarning && !said.contains(what)) context.Warn(line.text);
      now.insert(what);
    }
    said = std::move(now);
  }
  session.Stop();
  return session.complete();
}

}  // namespace acus::live
