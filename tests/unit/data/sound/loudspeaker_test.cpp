// What is played is what OpenAL Soft writes into a file in place of a loudspeaker.
#include "acus/data/sound/loudspeaker.h"

#include <chrono>
#include <gtest/gtest.h>
#include <optional>
#include <thread>

#include "acus/data/sound/cry.h"
#include "support/played_sound.h"
#include "support/temporary_folder.h"

namespace acus::loudspeaker {
namespace {

TEST(ALoudspeaker, PlaysTheSoundEachTimeFromItsBeginning) {
  const testing_support::TemporaryFolder temporary;
  const auto file = temporary.path() / "played.wav";
  testing_support::PlayInto(file);
  const sound::Sound cry = sound::Cry();
  std::optional<Loudspeaker> loudspeaker;
  try {
    loudspeaker.emplace(cry);
  } catch (const InputError& error) {
    GTEST_SKIP() << error.what();
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  for (int i = 0; i < 2; ++i) {
    loudspeaker->Play();
    std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  }
  loudspeaker.reset();
  const sound::Sound played = sound::ReadSound(file);
  ASSERT_EQ(played.rate_hz, cry.rate_hz);
  const auto found = testing_support::FindSounds(played, cry);
  ASSERT_EQ(found.size(), 2U);
  for (const auto& sound : found) EXPECT_GT(sound.likeness, 0.999) << "at sample " << sound.at;
  EXPECT_GT(found[0].at, 0U) << "silence at first";
  const double apart_s = static_cast<double>(found[1].at - found[0].at) / played.rate_hz;
  EXPECT_NEAR(apart_s, 1.2, 0.3) << "the file is written at the pace of the clock";
}

}  // namespace
}  // namespace acus::loudspeaker
