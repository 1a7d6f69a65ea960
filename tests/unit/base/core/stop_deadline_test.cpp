#include "acus/base/core/stop_deadline.h"

#include <chrono>
#include <filesystem>
#include <gtest/gtest.h>
#include <optional>
#include <unistd.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus {
namespace {

using std::chrono_literals::operator""ms;

/// Never returns.
void ComputeForEver() {
  for (;;) std::this_thread::yield();
}

TEST(StopDeadlineDeathTest, EndsAProgramThatDoesNotLook) {
  EXPECT_EXIT(
      {
        const StopDeadline deadline("acus-thing");
        NotifyStop();
        ComputeForEver();
      },
      ::testing::ExitedWithCode(130), "acus-thing: stopped on request");
}

TEST(StopDeadlineDeathTest, RemovesWhatIsNotFinished) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / Message("acus_stop_", static_cast<int>(::getpid()));
  EXPECT_EXIT(
      {
        const StopDeadline deadline("acus-thing");
        const AtomicFolder output(folder / "run", false);
        WriteTextFile(output.path() / "a.txt", "half");
        NotifyStop();
        ComputeForEver();
      },
      ::testing::ExitedWithCode(130), "stopped");
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove_all(folder);
}

TEST(StopDeadline, DoesNothingWithoutAStopOrAfterTheEnd) {
  { const StopDeadline deadline("acus-thing"); }
  {
    const StopDeadline deadline("acus-thing");
    NotifyStop();
  }
  const StopDeadline deadline("acus-thing");
  std::this_thread::sleep_for(1500ms);  // The stop before is not taken for one of this.
}

TEST(StopDeadline, WaitsForARecording) {
  const StopDeadline deadline("acus-thing");
  const NoStopDeadline recording;
  NotifyStop();
  std::this_thread::sleep_for(1500ms);
}

}  // namespace
}  // namespace acus
