#include "acus/base/core/stop_deadline.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <thread>
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

/// Longer than the deadline lasts after a stop; then the program ends by itself.
void OutliveTheDeadline() {
  std::this_thread::sleep_for(1500ms);
  std::_Exit(0);
}

TEST(StopDeadlineDeathTest, DoesNothingWithoutAStop) {
  EXPECT_EXIT(
      {
        const StopDeadline deadline("acus-thing");
        OutliveTheDeadline();
      },
      ::testing::ExitedWithCode(0), "^$");
}

TEST(StopDeadlineDeathTest, AStopBeforeIsNotTakenForOneOfThis) {
  EXPECT_EXIT(
      {
        {
          const StopDeadline before("acus-thing");
          NotifyStop();
        }
        const StopDeadline deadline("acus-thing");
        OutliveTheDeadline();
      },
      ::testing::ExitedWithCode(0), "^$");
}

TEST(StopDeadlineDeathTest, WaitsForARecording) {
  EXPECT_EXIT(
      {
        const StopDeadline deadline("acus-thing");
        const NoStopDeadline recording;
        NotifyStop();
        OutliveTheDeadline();
      },
      ::testing::ExitedWithCode(0), "^$");
}

}  // namespace
}  // namespace acus
