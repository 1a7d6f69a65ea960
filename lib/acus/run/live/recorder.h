// Records a live session in a folder that is readable at any time, also after kill -9.
//
// The real-time thread pushes one record for each step into a ring; a thread of the recorder
// converts records to rows and appends them to the files, at least every half second. Data handed
// to the operating system survives the death of the process. A disk that is full or slow costs
// memory, then records, and is reported; it never delays the real-time thread.
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
  double retry_s = 0.5;                   ///< Interval of retries after a write failed.
  double patience_s = 3.0;                ///< Time limit of Close() to write the remaining rows.
  std::size_t ring_steps = 1U << 14;      ///< Records that wait while a write takes its time.
  std::size_t memory_bytes = 256U << 20;  ///< Rows that wait while the disk accepts none.
  SinkFactory open = OpenOnDisk;
};

struct RecordingStatus {
  std::int64_t steps_on_disk = 0;
  std::int64_t steps_waiting = 0;      ///< In memory.
  std::int64_t steps_lost = 0;         ///< Ring or memory was full, or the last write failed.
  std::int64_t readings_recorded = 0;  ///< Raw readings of trackers.
  std::int64_t readings_lost = 0;
  std::int64_t refusals = 0;  ///< Number of failed writes.
  double longest_write_s = 0.0;
  std::string trouble;  ///< The problem and its remedy, for the user; empty if there is none.
};

/// Tracked tools whose raw readings go to tracker.csv.
struct RecordedBoard {
  std::string prefix;                    ///< Prefix of the tools' names; may be empty.
  tracking::PoseBoard* board = nullptr;  ///< Must outlive the recorder.
  std::uint64_t lost_before = 0;         ///< Readings lost before the recorder received the board.
};

class Recorder {
 public:
  /// Makes the folder with session.json, provenance.json and the files of `streams`; forces.csv and
  /// probe_forces.csv, if the scene's plan has these forces, and the files of other effects.
  /// @param scene  Must outlive this.
  /// @param origin_ns  CLOCK_MONOTONIC at time 0 of the session, for raw readings.
  /// @throws InputError if the folder exists and may not be replaced (see AtomicFolder), or cannot
  ///     be written.
  Recorder(const std::filesystem::path& folder, const std::string& name,
           const session::StreamNames& streams, const simulation::Scene& scene,
           std::int64_t origin_ns, const RecorderSettings& settings, const RunContext& context);
  ~Recorder();  ///< Closes.
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Before Start(). Earlier entries of their journals are not recorded.
  void AddBoards(std::vector<RecordedBoard> boards);
  /// Before Start(). Receives each recorded step, in the recorder's thread. Null: none.
  void SetExercise(LiveExercise* exercise) { exercise_ = exercise; }
  void Start();

  /// Called by the real-time thread. Never waits; a record is lost and counted if the ring is full.
  void Push(const StepRecord& record) noexcept;

  /// Returns when all records pushed before are converted to rows and added to the exercise: for
  /// sessions in virtual time, whose user acts on what the exercise shows. After Start().
  void CatchUp();

  /// Writes the remaining data, so that it survives a power failure, and ends the thread. A second
  /// call has no effect.
  void Close() noexcept;

  RecordingStatus status() const;  ///< Any thread.
  const std::filesystem::path& folder() const { return folder_; }

 private:
  /// In the order in which the rows of a block are written: a needle row is never on disk without
  /// all others of its step, so that the needle's rows after a kill can be replayed.
  enum Stream { kTracker, kCommands, kBreathing, kProbeForces, kForces, kProbe, kNeedle, kCount };

  /// Rows of all files for the same steps.
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
  NoStopDeadline unhurried_;  ///< A requested stop does not cut a recording off.
  const simulation::Scene& scene_;
  std::int64_t origin_ns_;
  RecorderSettings settings_;
  template <typename Action>
  void ForEachFile(const Action& action);

  std::array<std::unique_ptr<StreamFile>, kCount> files_;
  std::vector<std::unique_ptr<StreamFile>>
      effect_files_;  ///< Files of effects_, written before the others.
  std::vector<const simulation::ListedEffect*> effects_;  ///< Effects with columns.
  std::deque<Block> blocks_;                              ///< One for each block of the files.
  std::size_t pending_bytes_ = 0;
  std::vector<RecordedBoard> boards_;
  LiveExercise* exercise_ = nullptr;
  std::vector<tracking::ToolReading> readings_;  ///< Buffer of TakeReadings().
  Ring<StepRecord> ring_;
  std::int64_t next_try_ns_ = 0;  ///< After a failed write.
  std::thread thread_;

  std::atomic<std::int64_t> lost_in_ring_{0};
  std::atomic<std::int64_t> lost_in_memory_{0};
  std::atomic<std::int64_t> steps_taken_{0};  ///< Converted to rows.
  std::atomic<std::int64_t> steps_on_disk_{0};
  std::atomic<std::int64_t> taken_ns_{0};    ///< Session time of the newest row ...
  std::atomic<std::int64_t> on_disk_ns_{0};  ///< ... and of the newest that is on disk.
  std::atomic<std::int64_t> readings_taken_{0};
  std::atomic<std::int64_t> refusals_{0};
  std::atomic<std::int64_t> longest_write_ns_{0};
  std::atomic<int> error_{0};       ///< errno of the last write; 0: no error.
  std::atomic<int> sync_error_{0};  ///< errno of the sync in Close(); 0: no error.
  std::atomic<bool> closed_{false};

  std::mutex mutex_;  ///< Guards these; the real-time thread never takes it.
  std::condition_variable wake_;
  std::condition_variable caught_up_;
  bool stop_ = false;
  std::int64_t wanted_ = 0;  ///< Number of calls of CatchUp() ...
  std::int64_t served_ = 0;  ///< ... and of those that have been served.
};

}  // namespace acus::live
