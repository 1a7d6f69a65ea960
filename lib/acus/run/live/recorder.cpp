#include "acus/run/live/recorder.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>

#include "acus/base/config/json_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/sync_folder.h"
#include "acus/base/core/text_table.h"
#include "acus/base/translation/translation.h"
#include "acus/data/session/pose_csv.h"
#include "acus/run/replay/force_rows.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTrackerHeader =
    "time_s,source_time_s,tool,x_mm,y_mm,z_mm,qw,qx,qy,qz,status";

// Rows of this many steps are written together: a full disk loses no more than these.
constexpr std::int64_t kStepsInBlock = 200;

/// A recording that cannot begin leaves nothing: its folder is removed, or the files that it
/// created in an existing one. Lives while files are opened.
class UnbegunFolder {
 public:
  UnbegunFolder(const fs::path& folder, bool made) : folder_(folder), made_(made) {}
  UnbegunFolder(const UnbegunFolder&) = delete;
  UnbegunFolder& operator=(const UnbegunFolder&) = delete;
  ~UnbegunFolder() {
    if (begun_) return;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
      fs::remove_all(entry, ignored);
    }
    if (made_) fs::remove(folder_, ignored);
  }
  void Begin() { begun_ = true; }

 private:
  fs::path folder_;
  bool made_;
  bool begun_ = false;
};

/// Makes an empty folder, in place of an earlier output if `overwrite` is set, and locks it: a
/// folder into which another program records is never removed. @param made  True if it did not
/// exist.
FolderLock MakeFolder(const fs::path& folder, bool overwrite, bool& made) {
  std::error_code error;
  made = fs::create_directories(folder, error);
  ACUS_REQUIRE(!error, folder.string(), ": cannot be made: ", error.message());
  FolderLock lock(folder);
  if (fs::is_empty(folder, error)) return lock;
  ACUS_REQUIRE(overwrite, folder.string(),
               ": is there already; choose another name, or replace it with --overwrite");
  ACUS_REQUIRE(fs::exists(folder / "provenance.json"), folder.string(),
               ": is not the output of an earlier run (no provenance.json); it is not replaced");
  for (const auto& entry : fs::directory_iterator(folder)) fs::remove_all(entry, error);
  ACUS_REQUIRE(!error, folder.string(), ": cannot be emptied: ", error.message());
  return lock;
}

std::string TroubleText(int error, const fs::path& folder, double waiting_s, bool memory_is_full) {
  using translation::Translated;
  const std::string cause =
      error == ENOSPC ? Translated("Recording: the disk is full.")
                      : Translated("Recording: writing fails: {1}.", {std::strerror(error)});
  const std::string kept =
      memory_is_full
          ? Translated(
                "Memory for it is full as well: the session continues, but is no longer "
                "recorded.")
          : Translated("The last {1} s are kept in memory.", {RoundedText(waiting_s, 3)});
  return cause + ' ' + kept + ' ' + Translated("Make room for {1}.", {folder.string()});
}

}  // namespace

Recorder::Recorder(const fs::path& folder, const std::string& name,
                   const session::StreamNames& streams, const simulation::Scene& scene,
                   std::int64_t origin_ns, const RecorderSettings& settings,
                   const RunContext& context)
    : folder_(folder),
      scene_(scene),
      origin_ns_(origin_ns),
      settings_(settings),
      readings_(4096),
      ring_(settings.ring_steps) {
  bool made = false;
  lock_ = MakeFolder(folder, context.overwrite, made);
  UnbegunFolder unbegun(folder, made);
  const auto open = [&](Stream stream, const char* file, std::string_view header) {
    files_[stream] = std::make_unique<StreamFile>(settings_.open(folder_ / file), header);
  };
  config::WriteJson(folder_ / "provenance.json", context.provenance.ToJson());
  if (streams.tracker) open(kTracker, session::kTrackerFile, kTrackerHeader);
  if (streams.commands) open(kCommands, session::kCommandsFile, session::kCommandHeader);
  if (streams.breathing) open(kBreathing, session::kBreathingFile, session::kBreathHeader);
  if (streams.probe) open(kProbe, session::kProbeFile, session::kPoseHeader);
  if (streams.needle) open(kNeedle, session::kNeedleFile, session::kPoseHeader);
  if (scene.plan.Writes(effects::ports::kForce)) {
    open(kForces, "forces.csv", replay::ForceHeader(scene));
  }
  if (scene.plan.Writes(effects::ports::kProbeForce)) {
    open(kProbeForces, "probe_forces.csv", replay::ProbeForceHeader());
  }
  for (const simulation::ListedEffect& other : scene.listed.all()) {
    if (other.columns.empty()) continue;
    effects_.push_back(&other);
    effect_files_.push_back(std::make_unique<StreamFile>(
        settings_.open(folder_ / Message(other.key, ".csv")), replay::EffectHeader(other)));
  }
  blocks_.emplace_back();
  Flush();  // The headers.
  ACUS_REQUIRE(error_ == 0, folder_.string(), ": cannot be written: ", std::strerror(error_));
  config::WriteJson(folder_ / "session.json",
                    session::SessionDescription(streams, name, "Reference"));
  unbegun.Begin();
}

Recorder::~Recorder() {
  Close();
}

void Recorder::AddBoards(std::vector<RecordedBoard> boards) {
  boards_ = std::move(boards);
  for (RecordedBoard& recorded : boards_) {
    while (recorded.board->TakeReadings(readings_) == readings_.size()) {
    }
    recorded.lost_before = recorded.board->lost_from_journal();
  }
}

void Recorder::Start() {
  thread_ = std::thread([this] { Run(); });
}

void Recorder::Push(const StepRecord& record) noexcept {
  if (!ring_.Push(record)) lost_in_ring_.fetch_add(1, std::memory_order_relaxed);
}

void Recorder::Run() noexcept {
  const auto interval = std::chrono::duration<double>(std::clamp(settings_.write_s, 0.001, 0.5));
  bool stop = false;
  while (!stop) {
    std::int64_t wanted = 0;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, interval, [this] { return stop_ || wanted_ > served_; });
      stop = stop_;
      wanted = wanted_;
    }
    try {
      TakeSteps();
      if (exercise_ != nullptr) exercise_->Publish();
      TakeReadings();
    } catch (const std::exception&) {
      // No memory for the rows of one record: it is lost, the session continues.
      lost_in_memory_.fetch_add(1, std::memory_order_relaxed);
    }
    {
      const std::lock_guard lock(mutex_);
      served_ = wanted;
    }
    caught_up_.notify_all();
    Flush();
  }
}

void Recorder::CatchUp() {
  std::unique_lock lock(mutex_);
  const std::int64_t wanted = ++wanted_;
  wake_.notify_all();
  caught_up_.wait(lock, [&] { return served_ >= wanted || stop_; });
}

template <typename Action>
void Recorder::ForEachFile(const Action& action) {
  for (const auto& file : effect_files_) action(*file);
  for (const auto& file : files_) {
    if (file) action(*file);
  }
}

void Recorder::BeginBlock() {
  ForEachFile([](StreamFile& file) { file.BeginBlock(); });
  blocks_.emplace_back();
}

void Recorder::TakeSteps() {
  // No more than the initial number: a faster producer must not delay the writing of rows.
  for (std::size_t left = ring_.size(); left > 0; --left) {
    const StepRecord* record = ring_.Front();
    if (record == nullptr) return;
    if (pending_bytes_ > settings_.memory_bytes) {
      lost_in_memory_.fetch_add(1, std::memory_order_relaxed);
    } else {
      // The longer the queue, the larger the blocks: a disk may be slow per call.
      const std::int64_t waiting = steps_taken_ - steps_on_disk_;
      if (blocks_.back().steps >= std::max(kStepsInBlock, waiting / 4)) {
        CountPending();
        BeginBlock();
      }
      AppendStep(*record);
      if (exercise_ != nullptr) exercise_->Add(*record);
      ++blocks_.back().steps;
      blocks_.back().newest_ns = record->time_ns;
      steps_taken_.fetch_add(1, std::memory_order_relaxed);
      taken_ns_ = record->time_ns;
    }
    ring_.Pop();
  }
}

void Recorder::CountPending() noexcept {
  pending_bytes_ = 0;
  ForEachFile([this](StreamFile& file) { pending_bytes_ += file.pending_bytes(); });
}

void Recorder::AppendStep(const StepRecord& record) {
  for (int i = 0; i < record.num_commands && files_[kCommands]; ++i) {
    session::AppendCommandRow(files_[kCommands]->rows(),
                              record.command[static_cast<std::size_t>(i)]);
  }
  if (files_[kBreathing]) session::AppendBreathRow(files_[kBreathing]->rows(), record.breath);
  if (files_[kProbeForces]) {
    replay::AppendProbeForceRow(files_[kProbeForces]->rows(), record.output, scene_);
  }
  for (std::size_t n = 0; n < effects_.size(); ++n) {
    replay::AppendEffectRow(effect_files_[n]->rows(), record.output, *effects_[n]);
  }
  if (files_[kForces]) replay::AppendForceRow(files_[kForces]->rows(), record.output, scene_);
  if (files_[kProbe]) session::AppendPoseRow(files_[kProbe]->rows(), record.probe);
  if (files_[kNeedle]) session::AppendPoseRow(files_[kNeedle]->rows(), record.needle);
}

void Recorder::TakeReadings() {
  if (!files_[kTracker]) return;
  std::string& text = files_[kTracker]->rows();
  for (const RecordedBoard& recorded : boards_) {
    std::size_t count = 0;
    do {
      count = recorded.board->TakeReadings(readings_);
      for (std::size_t i = 0; i < count; ++i) {
        const tracking::ToolReading& reading = readings_[i];
        const session::PoseSample sample{reading.pose.time_ns - origin_ns_,
                                         reading.pose.reference_from_tool, reading.pose.valid};
        std::string row;
        session::AppendPoseRow(row, sample);
        const std::size_t comma = row.find(',');
        text += row.substr(0, comma + 1) + session::SecondsText(reading.pose.source_time_ns) + ',' +
                recorded.prefix + recorded.board->tools()[reading.tool] + row.substr(comma);
      }
      readings_taken_.fetch_add(static_cast<std::int64_t>(count), std::memory_order_relaxed);
    } while (count == readings_.size() && pending_bytes_ < settings_.memory_bytes);
  }
}

int Recorder::FlushBlocks() noexcept {
  while (true) {
    int error = 0;
    ForEachFile([&error](StreamFile& file) {
      if (error == 0) error = file.FlushFirstBlock();
    });
    if (error != 0) return error;
    steps_on_disk_ += blocks_.front().steps;
    if (blocks_.front().steps > 0) on_disk_ns_ = blocks_.front().newest_ns;
    if (blocks_.size() == 1) BeginBlock();
    blocks_.pop_front();
    ForEachFile([](StreamFile& file) { file.DropFirstBlock(); });
    if (blocks_.size() == 1 && blocks_.front().steps == 0) return 0;
  }
}

void Recorder::Flush() noexcept {
  const std::int64_t begin_ns = MonotonicNs();
  if (begin_ns < next_try_ns_) return;
  const int error = FlushBlocks();
  const std::int64_t end_ns = MonotonicNs();
  longest_write_ns_ = std::max(longest_write_ns_.load(), end_ns - begin_ns);
  error_ = error;
  next_try_ns_ = 0;
  if (error != 0) {
    ++refusals_;
    next_try_ns_ = end_ns + std::llround(1e9 * settings_.retry_s);
  }
  CountPending();
}

void Recorder::Close() noexcept {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
  // The producer has stopped: no records follow.
  const std::int64_t give_up_ns = MonotonicNs() + std::llround(1e9 * settings_.patience_s);
  next_try_ns_ = 0;
  Flush();
  while (pending_bytes_ > 0 && MonotonicNs() < give_up_ns) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    next_try_ns_ = 0;
    Flush();
  }
  sync_error_ = SyncFolder(folder_);
  closed_ = true;
}

RecordingStatus Recorder::status() const {
  RecordingStatus status;
  const bool closed = closed_;
  status.steps_on_disk = steps_on_disk_;
  const std::int64_t waiting =
      steps_taken_ - status.steps_on_disk + static_cast<std::int64_t>(ring_.size());
  status.steps_lost = lost_in_ring_ + lost_in_memory_ + (closed ? waiting : 0);
  status.steps_waiting = closed ? 0 : waiting;
  status.readings_recorded = readings_taken_;
  for (const RecordedBoard& recorded : boards_) {
    status.readings_lost +=
        static_cast<std::int64_t>(recorded.board->lost_from_journal() - recorded.lost_before);
  }
  status.refusals = refusals_;
  status.longest_write_s = 1e-9 * static_cast<double>(longest_write_ns_);
  const int error = error_;
  if (error != 0 && !closed) {
    const double waiting_s = 1e-9 * static_cast<double>(taken_ns_ - on_disk_ns_);
    status.trouble = TroubleText(error, folder_, waiting_s, lost_in_memory_ > 0);
  } else if (status.steps_lost > 0) {
    status.trouble = Message("Recording: ", status.steps_lost, " steps are missing",
                             error != 0 ? Message(" (", std::strerror(error), ")") : std::string(),
                             "; a replay differs after the first of them.");
  } else if (sync_error_ != 0) {
    status.trouble = Message("Recording: ", folder_.string(), " may not survive a power failure (",
                             std::strerror(sync_error_), "); copy it to another disk.");
  }
  return status;
}

}  // namespace acus::live
