// Records a live session in a folder that can be read at any moment, also after kill -9.
//
// The real-time thread pushes one record for each step into a ring; a thread of the recorder turns
// records into rows and appends them to the files, at least every half second. What was handed to
// the operating system survives the death of the process. A disk that is full or slow costs memory,
// then records, and says so; it never delays the real-time thread.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "acus/base/core/folder_lock.h"
#include "acus/base/core/run_context.h"
#include "acus/base/core/stop_deadline.h"
#include "acus/data/session/session_io.h"
#include "acus/rig/tracking/pose_board.h"
#include "acus/run/live/live_exercise.h"
#include "acus/run/live/ring.h"
#include "acus/run/live/step_record.h"
#include "acus/run/live/stream_file.h"
#include "acus/scene/simulation/scene.h"

namespace acus::live {

struct RecorderSettings {
  double write_s = 0.2;                   ///< Rows reach the files this often; at most 0.5.
  double retry_s = 0.5;                   ///< After the disk has refused to take any.
  double patience_s = 3.0;                ///< How long Close() tries to write what is left.
  std::size_t ring_steps = 1U << 14;      ///< Records that wait while a write takes its time.
  std::size_t memory_bytes = 256U << 20;  ///< Rows that wait while the disk takes none.
  SinkFactory open = OpenOnDisk;
};

struct RecordingStatus {
  std::int64_t steps_on_disk = 0;
  std::int64_t steps_waiting = 0;  ///< In memory.
  std::int64_t steps_lost = 0;     ///< Found ring or memory full, or could not be written at last.
  std::int64_t readings_recorded = 0;  ///< Raw ones, of trackers.
  std::int64_t readings_lost = 0;
  std::int64_t refusals = 0;  ///< Times that the disk took nothing.
  double longest_write_s = 0.0;
  std::string trouble;  ///< In plain words, with what to do; empty if all is well.
};

/// Tracked tools whose raw readings go to tracker.csv.
struct RecordedBoard {
  std::string prefix;                    ///< Of the tools' names; may be empty.
  tracking::PoseBoard* board = nullptr;  ///< Must outlive the recorder.
  std::uint64_t lost_before = 0;         ///< Readings, when the recorder was given the board.
};

class Recorder {
 public:
  /// Makes the folder with session.json, provenance.json and the files of `streams`; forces.csv and
  /// probe_forces.csv, if the scene's plan has these forces, and the files of other effects.
  /// @param scene  Must outlive this.
  /// @param origin_ns  CLOCK_MONOTONIC at time 0 of the session, for raw readings.
  /// @throws InputError if the folder is there already and may not be replaced (see AtomicFolder),
  ///     or cannot be written.
  Recorder(const std::filesystem::path& folder, const std::string& name,
           const session::StreamNames& streams, const simulation::Scene& scene,
           std::int64_t origin_ns, const RecorderSettings& settings, const RunContext& context);
  ~Recorder();  ///< Closes.
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Before Start(). What their journals hold of the time before is not recorded.
  void AddBoards(std::vector<RecordedBoard> boards);
  /// Before Start(). Is passed each step that is recorded, by the recorder's thread. Null: none.
  void SetExercise(LiveExercise* exercise) { exercise_ = exercise; }
  void Start();

  /// The real-time thread. Never waits; a record that finds the ring full is lost and counted.
  void Push(const StepRecord& record) noexcept;

  /// Writes what is left, so that a power failure does not take it, and ends the thread. Twice is
  /// once.
  void Close() noexcept;

  RecordingStatus status() const;  ///< Any thread.
  const std::filesystem::path& folder() const { return folder_; }

 private:
  /// In the order in which the rows of a block are written: a needle row is never there without all
  /// others of its step, so that what a kill leaves of the needle can be replayed.
  enum Stream { kTracker, kCommands, kBreathing, kProbeForces, kForces, kProbe, kNeedle, kCount };

  /// Rows of all files that belong together.
  struct Block {
    std::int64_t steps = 0;
    std::int64_t newest_ns = 0;  ///< Session time.
  };

  void Run() noexcept;
  void BeginBlock();
  void CountPending() noexcept;
  int FlushBlocks() noexcept;  ///< Returns 0 or an errno.
  void TakeSteps();
  void TakeReadings();
  void AppendStep(const StepRecord& record);
  void Flush() noexcept;

  std::filesystem::path folder_;
  FolderLock lock_;           ///< No other program records into the folder or replaces it.
  NoStopDeadline unhurried_;  ///< A stop that was asked for does not cut a recording off.
  const simulation::Scene& scene_;
  std::int64_t origin_ns_;
  RecorderSettings settings_;
  template <typename Action>
  void ForEachFile(const Action& action);

  std::array<std::unique_ptr<StreamFile>, kCount> files_;
  std::vector<std::unique_ptr<StreamFile>>
      effect_files_;  ///< Of effects_, written before the others.
  std::vector<const simulation::ListedEffect*> effects_;  ///< That write numbers down.
  std::deque<Block> blocks_;                              ///< In step with those of the files.
  std::size_t pending_bytes_ = 0;
  std::vector<RecordedBoard> boards_;
  LiveExercise* exercise_ = nullptr;
  std::vector<tracking::ToolReading> readings_;  ///< Buffer of TakeReadings().
  Ring<StepRecord> ring_;
  std::int64_t next_try_ns_ = 0;  ///< After the disk has refused.
  std::thread thread_;

  std::atomic<std::int64_t> lost_in_ring_{0};
  std::atomic<std::int64_t> lost_in_memory_{0};
  std::atomic<std::int64_t> steps_taken_{0};  ///< Turned into rows.
  std::atomic<std::int64_t> steps_on_disk_{0};
  std::atomic<std::int64_t> taken_ns_{0};    ///< Session time of the newest row ...
  std::atomic<std::int64_t> on_disk_ns_{0};  ///< ... and of the newest that is on disk.
  std::atomic<std::int64_t> readings_taken_{0};
  std::atomic<std::int64_t> refusals_{0};
  std::atomic<std::int64_t> longest_write_ns_{0};
  std::atomic<int> error_{0};       ///< errno of the last write; 0: all is well.
  std::atomic<int> sync_error_{0};  ///< errno of what Close() could not put on the medium.
  std::atomic<bool> closed_{false};

  std::mutex mutex_;  ///< Of stop_; the real-time thread never takes it.
  std::condition_variable wake_;
  bool stop_ = false;
};

}  // namespace acus::live
