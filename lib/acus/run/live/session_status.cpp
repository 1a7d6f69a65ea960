// The status of a live session: on the screen, at its end, and in summary.json.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/text_table.h"
#include "acus/base/translation/translation.h"
#include "acus/run/live/live_session.h"
#include "acus/scene/simulation/plan_json.h"

namespace acus::live {
namespace {

using haptics::DeviceState;
using nlohmann::json;
using translation::Translated;

/// Share of late steps in the last seconds up to which no warning is shown.
constexpr double kLateStepsShare = 1e-3;

constexpr std::array<const char*, 4> kStates = {"stopped", "running", "recovering", "failed"};

json GuardJson(const haptics::GuardCounts& counts) {
  json out = {{"ticks", counts.ticks}};
  for (std::size_t i = 0; i < haptics::kNumGuardActs; ++i) {
    out[haptics::Words(static_cast<haptics::GuardAct>(i))] = counts.of[i];
  }
  return out;
}

json DeviceJson(const haptics::HapticDevice& device) {
  const haptics::DeviceStatus status = device.status();
  return {{"name", device.info().name},
          {"rate_hz", device.info().rate_hz},
          {"state_at_end", kStates[static_cast<std::size_t>(status.state)]},
          {"last_fault", status.text},
          {"notices", device.info().notices},
          {"reopened", status.num_reopened},
          {"overruns", status.num_overruns},
          {"longest_tick_ms", status.longest_tick_ms},
          {"guard", GuardJson(status.guard)}};
}

/// @param before  The source's counters at the start of the session.
json TrackerJson(const tracking::PoseSource& source, const tracking::SourceCounts& before) {
  const tracking::SourceStatus status = source.status();
  const tracking::SourceCounts counts = status.counts.Since(before);
  return {{"name", source.name()},
          {"last_error", status.last_error},
          {"messages", counts.messages},
          {"readings", counts.readings},
          {"not_seen", counts.not_seen},
          {"bad_poses", counts.bad_poses},
          {"bad_messages", counts.bad_messages},
          {"skipped_bytes", counts.skipped_bytes},
          {"connects", counts.connects}};
}

json ExerciseJson(const LiveExercise& exercise) {
  const replay::ExerciseProgress progress = exercise.progress();
  json goals = json::array();
  for (const replay::GoalNow& goal : progress.goals) {
    const auto& value = goal.result.value;
    goals.push_back({{"metric", goal.result.goal.metric},
                     {"value", value ? json(*value) : json(nullptr)},
                     {"met", goal.result.met},
                     {"in_report_only", goal.at_end}});
  }
  json steps = json::array();
  for (const training::StepResult& step : progress.checklist) {
    const bool open = step.state == training::StepState::kOpen;
    steps.push_back(
        {{"text", step.text},
         {"state", NameOf(step.state)},
         {"time_s", open ? json(nullptr) : json(1e-9 * static_cast<double>(step.time_ns))}});
  }
  return {{"name", exercise.exercise().name}, {"goals", goals}, {"checklist", steps}};
}

void AddDevice(const haptics::HapticDevice& device, std::vector<StatusLine>& lines) {
  const haptics::DeviceStatus status = device.status();
  if (status.state == DeviceState::kFailed) {
    lines.push_back({Severity::kFault,
                     Translated("The device has failed, forces are off: end the session. {1}.",
                                {status.text})});
  } else if (status.state == DeviceState::kRecovering) {
    lines.push_back(
        {Severity::kFault,
         Translated("The device is opened again, forces are off. {1}.", {status.text})});
  } else if (status.guard.IsActing(haptics::GuardAct::kDeadManOpen)) {
    lines.push_back({Severity::kNote,
                     Translated("{1}: no force until its switch is held.", {device.info().name})});
  }
}

void AddStop(StopKind stop, std::vector<StatusLine>& lines) {
  if (stop == StopKind::kBone) {
    lines.push_back({Severity::kWarning,
                     Translated("Bone: the needle does not advance. Withdraw it, and change its "
                                "direction.")});
  } else if (stop == StopKind::kHub) {
    lines.push_back(
        {Severity::kWarning,
         Translated("The hub is at the skin: the needle is inserted to its full length.")});
  }
}

void AddRemote(const RemoteImages& remote, std::vector<StatusLine>& lines) {
  if (remote.works()) {
    lines.push_back(
        {Severity::kNote, Translated("Images come from {1}, {2} ms old.",
                                     {remote.place(), RoundedText(remote.age_ms(), 2)})});
  } else if (const std::string trouble = remote.trouble(); !trouble.empty()) {
    lines.push_back(
        {Severity::kWarning, Translated("Images are made on this computer: {1}.", {trouble})});
  }
}

}  // namespace

std::vector<StatusLine> LiveSession::Status() const {
  std::vector<StatusLine> lines;
  AddDevice(*servo_device_, lines);
  if (other_device_) AddDevice(*other_device_, lines);
  AddStop(core_->stopped_by(), lines);
  const RecordingStatus recording = recorder_->status();
  if (!recording.trouble.empty()) {
    lines.push_back(
        {recording.steps_lost > 0 ? Severity::kFault : Severity::kWarning, recording.trouble});
  }
  if (const std::string trouble = images_->trouble(); !trouble.empty()) {
    lines.push_back({Severity::kFault, trouble});
  }
  if (remote_) AddRemote(*remote_, lines);
  if (voice_ && !voice_->trouble().empty()) {
    lines.push_back(
        {Severity::kWarning, Translated("The patient is not heard: {1}", {voice_->trouble()})});
  }
  const std::int64_t now_ns = MonotonicNs();
  for (std::size_t t = 0; t < rig_->trackers().size(); ++t) {
    const tracking::SourceStatus status = rig_->trackers()[t]->status();
    if (status.state != tracking::SourceState::kConnected) {
      lines.push_back({Severity::kFault,
                       Translated("The tracker {1} is not connected: {2}.",
                                  {rig_->trackers()[t]->name(),
                                   status.last_error.empty() ? Translated("it does not answer yet")
                                                             : status.last_error})});
      continue;
    }
    const tracking::PoseBoard& board = rig_->trackers()[t]->board();
    for (std::size_t i = 0; i < board.tools().size(); ++i) {
      const tracking::TrackedPose pose = board.Latest(i);
      if (pose.valid && pose.AgeNs(now_ns) < 200'000'000) continue;
      const std::string why = i < status.why_not_seen.size() ? status.why_not_seen[i] : "";
      lines.push_back(
          {Severity::kWarning,
           Translated("The tracker {1} does not see the {2}.",
                      {rig_->trackers()[t]->name(),
                       why.empty() ? board.tools()[i] : board.tools()[i] + ": " + why})});
    }
  }
  const std::int64_t late = recent_late_steps_.recent();
  if (static_cast<double>(late) > kLateStepsShare * static_cast<double>(recent_steps_.recent())) {
    lines.push_back(
        {Severity::kWarning,
         Translated("{1} of the last {2} steps took longer than the device's period; choose "
                    "cheaper models (acus-tradeoff).",
                    {std::to_string(late), std::to_string(recent_steps_.recent())})});
  }
  std::ranges::stable_sort(lines, std::ranges::greater(), &StatusLine::severity);
  return lines;
}

bool LiveSession::switch_is_open() const {
  const auto is_open = [](const haptics::HapticDevice* device) {
    return device != nullptr && device->status().guard.IsActing(haptics::GuardAct::kDeadManOpen);
  };
  return is_open(servo_device_) || is_open(other_device_);
}

std::string LiveSession::DevicesText() const {
  std::string text;
  const auto add = [&text](const char* what, const haptics::HapticDevice& device) {
    text +=
        Message(what, ": ", device.info().name, ", ", device.info().rate_hz, " Hz, ",
                device.info().max_force_n > 0.0 ? Message("up to ", device.info().max_force_n, " N")
                                                : std::string("no motors"),
                '\n');
    for (const std::string& notice : device.info().notices) text += "  " + notice + '\n';
  };
  add(core_settings_.servo_is_needle ? "Needle" : "Probe", *servo_device_);
  if (other_device_) add("Probe", *other_device_);
  for (const auto& tracker : rig_->trackers()) text += "Tracker: " + tracker->name() + '\n';
  return text;
}

simulation::StageTimes LiveSession::stage_times() const {
  simulation::StageTimes times = core_->stage_times();
  times.Add(images_->stage_times());
  return times;
}

json LiveSession::Summary() const {
  const RecordingStatus recording = recorder_->status();
  json devices = json::array({DeviceJson(*servo_device_)});
  if (other_device_) devices.push_back(DeviceJson(*other_device_));
  json trackers = json::array();
  for (std::size_t n = 0; n < tracked_before_.size(); ++n) {
    trackers.push_back(TrackerJson(*rig_->trackers()[n], tracked_before_[n]));
  }
  const json exercise = exercise_ ? ExerciseJson(*exercise_) : json(nullptr);
  return {{"format", "acus-live-summary/1"},
          {"name", name_},
          {"exercise", exercise},
          {"seconds", session_s()},
          {"ended_by", NameOf(end_)},
          {"steps", statistics().ToJson()},
          {"images", image_statistics().ToJson()},
          {"images_from", remote_ ? remote_->ToJson() : json(nullptr)},
          {"pain_sound", voice_ ? voice_->ToJson() : json(nullptr)},
          {"effect_plan", simulation::PlanJson(scene_->plan, stage_times())},
          {"recording",
           {{"steps_on_disk", recording.steps_on_disk},
            {"steps_lost", recording.steps_lost},
            {"readings", recording.readings_recorded},
            {"readings_lost", recording.readings_lost},
            {"refused_writes", recording.refusals},
            {"longest_write_s", recording.longest_write_s},
            {"trouble", recording.trouble}}},
          {"devices", devices},
          {"trackers", trackers}};
}

std::string LiveSession::SummaryText() const {
  const CoreStatistics& core = statistics();
  const ImageStatistics& images = image_statistics();
  const auto ms = [](double ns) { return RoundedText(1e-6 * ns, 3) + " ms"; };
  const RecordingStatus recording = recorder_->status();
  std::string text =
      Message("Session of ", RoundedText(session_s(), 4), " s: ", core.steps.load(), " steps, ",
              images.images.load(), " images (", RoundedText(images.per_s(), 3),
              " a second).\n  step: ", ms(core.step_cpu.QuantileNs(0.5)),
              " of CPU time (99.9 %: ", ms(core.step_cpu.QuantileNs(0.999)),
              "); too slow for the device: ", core.missed_by_computation.load(),
              "; readings missed as the machine was busy: ", core.missed_by_machine.load(),
              "\n  device to force: ", ms(core.device_to_force.QuantileNs(0.5)),
              " (99.9 %: ", ms(core.device_to_force.QuantileNs(0.999)),
              "), tracker to image: ", ms(images.tracker_to_image.QuantileNs(0.5)),
              " (99 %: ", ms(images.tracker_to_image.QuantileNs(0.99)),
              ")\n  recorded: ", recording.steps_on_disk, " steps in ",
              options_.session_folder.string(), "; lost: ", recording.steps_lost, "\n");
  if (remote_) {
    const std::string trouble = remote_->trouble();
    text += Message("  images from ", remote_->place(), ": ", remote_->num_images(), ", ",
                    RoundedText(remote_->median_age_ms(), 3), " ms old",
                    trouble.empty() ? "" : "; ", trouble, "\n");
  }
  for (const auto* device : {servo_device_, other_device_}) {
    if (device == nullptr) continue;
    for (const std::string& notice : device->info().notices) text += "  " + notice + '\n';
    if (!device->status().text.empty()) text += "  " + device->status().text + '\n';
  }
  if (images.failed > 0) {
    text += Message("  ", images.failed.load(), " images could not be made.\n");
  }
  if (!recording.trouble.empty()) text += "  " + recording.trouble + '\n';
  return text;
}

}  // namespace acus::live
