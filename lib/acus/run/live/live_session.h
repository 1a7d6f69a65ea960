// A live session from start to end: the work of each thread, and the order in which they stop.
//
//   servo of a haptic device (1 kHz, real-time)   LiveCore::Tick: step, force, record, snapshot
//   servo of the other device, if there is one    passes its pose on, takes its force
//   trackers                                      receive poses
//   images (30 Hz or more)                        render the newest snapshot, send it
//   a second computer, if there is one            receives all steps, sends images
//   recorder                                      writes
//   the caller                                    Poll(), status, windows, orders
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/rig/haptics/haptic_device.h"
#include "acus/rig/haptics/virtual_hand_driver.h"
#include "acus/run/live/broadcast.h"
#include "acus/run/live/image_thread.h"
#include "acus/run/live/live_core.h"
#include "acus/run/live/live_devices.h"
#include "acus/run/live/live_exercise.h"
#include "acus/run/live/patient_voice.h"
#include "acus/run/live/recent_rate.h"
#include "acus/run/live/recorder.h"
#include "acus/run/live/remote_images.h"
#include "acus/run/live/rig.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::live {

struct LiveOptions {
  std::filesystem::path session_folder;
  std::string name;  ///< Name of the session; empty: the scenario's.
  /// 0: to the end of the session that the hands follow; without one until it is stopped.
  double duration_s = 0.0;
  /// A session whose needle, probe and commands the virtual hands follow: once, or forth and back
  /// for `duration_s`. Empty: the devices file decides.
  std::filesystem::path hand;
  /// Time is counted, not measured: as fast as the computer is, with virtual hands only and without
  /// images. What is recorded is the same on every computer.
  bool virtual_time = false;
  bool left_handed = false;  ///< The devices of needle and probe change places.
  /// No vendor's library is loaded, no device searched for, and the session cannot be started.
  bool only_checks = false;
  double least_image_rate_hz = 30.0;
  std::optional<training::Exercise> exercise;  ///< Nothing: no exercise.
  RecorderSettings recorder;
};

/// Makes the session one of that exercise: with its name, and the file as an input.
/// @throws InputError as training::ReadExercise().
void UseExercise(const std::filesystem::path& file, LiveOptions& options, RunContext& context);

enum class Severity { kGood, kNote, kWarning, kFault };

/// A sentence for the user at the screen.
struct StatusLine {
  Severity severity = Severity::kNote;
  std::string text;
};

enum class SessionEnd { kRunning, kDuration, kStopped, kDeviceFailed };
/// "duration", "stopped", "device failed".
std::string_view NameOf(SessionEnd end);

/// A tool on a haptic device.
struct HeldTool {
  std::shared_ptr<haptics::HandSteering> hand = nullptr;  ///< Null: no virtual hand holds it.
  Eigen::Isometry3d handle_from_tool = Eigen::Isometry3d::Identity();  ///< mm.
  Eigen::Isometry3d reference_from_device = Eigen::Isometry3d::Identity();
  bool may_advance = true;  ///< False: bone or the skin stops the needle.
};

/// The largest forces that guards pass; 0: no motor.
struct ForceLimits {
  double needle_n = 0.0;
  double probe_n = 0.0;
};

/// The patient and the effects of sessions with these devices, which a replay of their recordings
/// loads as well.
/// @throws InputError as simulation::LoadScene().
simulation::Scene LoadLiveScene(const scenario::Scenario& scenario, const LiveDevices& devices,
                                RunContext& context);

class LiveSession {
 public:
  /// Reads the scenario's data and opens the devices, motors off; for this session alone.
  /// @throws InputError with a message for the user.
  LiveSession(const scenario::Scenario& scenario, const LiveDevices& devices,
              const LiveOptions& options, RunContext& context);
  /// One of several sessions with the same devices, one at a time, or in the same scene.
  /// @param scene  LoadLiveScene() of the scenario.
  /// @throws InputError with a message for the user.
  LiveSession(const scenario::Scenario& scenario, std::shared_ptr<const simulation::Scene> scene,
              std::shared_ptr<Rig> rig, const LiveOptions& options, RunContext& context);
  ~LiveSession();  ///< Stops.
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  /// Begins to record, then starts trackers, images and at last the devices.
  /// @throws InputError; then nothing runs and motors are off.
  void Start();

  /// Called every kLookS of session time; false ends the session.
  using Look = std::function<bool(const LiveSnapshot&)>;
  static constexpr double kLookS = 0.05;

  /// All of a session in virtual time, in place of Start() and Poll(). @pre the option was set.
  /// @param look  A user who watches the session and acts; may be empty. What the exercise shows is
  ///     then that of the newest step: the same actions give the same session on every computer.
  void RunInVirtualTime(const Look& look = {});
  bool in_virtual_time() const { return options_.virtual_time; }

  /// False when the session is over: its time is up, it was stopped, or the device that runs the
  /// steps has failed for good. To be called at least ten times a second.
  bool Poll();

  /// First the force becomes zero; then the threads stop; then the remaining data is written, with
  /// summary.json. A second call has no effect.
  void Stop() noexcept;

  SessionEnd end() const { return end_; }
  /// No device failed for good, no step is missing from the recording, and its summary is written.
  bool complete() const;
  const simulation::Scene& scene() const { return *scene_; }
  /// @pre Start() was called, as for all following functions.
  CommandQueue& commands() { return core_->commands(); }
  /// The device and hand that hold the needle, or the probe, at present.
  HeldTool HeldBy(bool needle) const;
  /// The camera whose video is shown; null if there is none.
  const camera::CameraTracker* video() const { return rig_->camera(); }
  ForceLimits force_limits() const;
  /// Null if there is none.
  const LiveExercise* exercise() const { return exercise_ ? &*exercise_ : nullptr; }
  /// A command holds the patient's breath, or the exercise has a step for that command.
  bool breath_can_be_held() const;
  bool has_needle() const { return devices_.has_needle(); }
  bool has_probe() const { return devices_.has_probe(); }
  /// A device gives no force because its dead-man switch is open.
  bool switch_is_open() const;
  /// Images per second of the last seconds; 0 before these have passed.
  double recent_images_per_s() const { return recent_images_.per_s(); }
  /// To be called while a pedal or its key is down: see HapticDevice.
  void HoldPedal();
  /// Null: no second computer renders the images.
  const RemoteImages* remote_images() const { return remote_.get(); }
  TripleBuffer<LiveImage>& images() { return images_->images(); }
  const CoreStatistics& statistics() const { return core_->statistics(); }
  const ImageStatistics& image_statistics() const { return images_->statistics(); }
  double seconds_running() const;
  double session_s() const { return 1e-9 * static_cast<double>(core_->session_ns()); }

  /// Status for the screen, the worst first; empty if there is no problem.
  std::vector<StatusLine> Status() const;
  /// A text about the attached devices: one line for each device and tracker.
  std::string DevicesText() const;
  /// Costs of the stages of the effect plan. @pre Stop() was called, as for Summary().
  simulation::StageTimes stage_times() const;
  nlohmann::json Summary() const;
  std::string SummaryText() const;

 private:
  struct Bridge;
  haptics::HapticDevice* Take(const haptics::ToolConfig& tool);
  void CheckStart() const;
  void TakeDevices();
  void FollowSession(LiveDevices& devices, const std::filesystem::path& session);
  void PlaceProbeOnSkin();
  void SendFollowedCommands();
  bool IsTimeUp() const;
  void ReadRates();
  void SendStatus();
  void MakeCore();

  LiveOptions options_;
  RunContext& context_;
  std::string name_;
  std::shared_ptr<const simulation::Scene> scene_;
  std::shared_ptr<Rig> rig_;
  LiveDevices devices_;  ///< Devices of this session, with hands and their paths.
  std::optional<simulation::Breathing> partner_;

  std::vector<tracking::SourceCounts> tracked_before_;  ///< By tracker, at the start.
  std::unique_ptr<Bridge> bridge_;                      ///< Between the other device and the core.
  std::map<std::string, std::shared_ptr<haptics::HandSteering>> steering_;  ///< By virtual hand.
  std::vector<haptics::VirtualHandDriver*> stepped_;  ///< In virtual time; the servo's first.
  std::vector<session::Command> followed_commands_;  ///< Commands of the session that hands follow.
  std::size_t next_followed_ = 0;
  double followed_s_ = 0.0;  ///< Its duration; 0: none.
  /// Virtual hands, and substitutes for absent devices.
  std::vector<std::unique_ptr<haptics::HapticDevice>> own_devices_;
  haptics::HapticDevice* servo_device_ = nullptr;
  haptics::HapticDevice* other_device_ = nullptr;  ///< Null: none.
  CoreSettings core_settings_;

  std::optional<LiveExercise> exercise_;
  RecentRate recent_images_{5.0};
  RecentRate recent_late_steps_{10.0};
  RecentRate recent_steps_{10.0};
  std::int64_t rates_read_ns_ = 0;
  std::int64_t status_sent_ns_ = 0;
  std::optional<sound::Sound> pain_sound_;
  std::unique_ptr<PatientVoice> voice_;  ///< Null: the patient makes no sound.
  std::unique_ptr<Recorder> recorder_;
  std::string digest_;                    ///< Of the scene, if another computer renders images.
  std::unique_ptr<RemoteImages> remote_;  ///< Null: all images are rendered here.
  std::unique_ptr<LiveCore> core_;
  std::unique_ptr<ImageThread> images_;
  transforms::Landmarks targets_;  ///< Targets of exercise and corridor, CT space.
  std::unique_ptr<Broadcast> broadcast_;
  SessionEnd end_ = SessionEnd::kRunning;
  bool started_ = false;
  bool stopped_ = false;
  bool summary_is_written_ = true;
};

/// Runs a session without windows to its end, and reports its status lines as warnings.
/// @returns session.complete().
bool RunHeadless(LiveSession& session, const RunContext& context);

}  // namespace acus::live
