// A patient who is heard when the needle hurts: live through the loudspeaker, in a replay as a
// file.
#include "acus/run/live/patient_voice.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/data/session/session_io.h"
#include "acus/data/sound/cry.h"
#include "acus/run/live/live_session.h"
#include "acus/run/replay/pain_sound.h"
#include "support/layered_folder.h"
#include "support/played_sound.h"
#include "support/replay_folder.h"

namespace acus::live {
namespace {

constexpr double kLatencyS = 0.15;

class PatientInPain : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(folder_, R"({"needle_force": {},
        "pain_reaction": {"tissues": ["skin"], "pause_s": 0.4, "return_s": 0.5, "sound": "cry"}})");
    WriteTextFile(folder_ / "devices.json", R"({"format": "acus-devices/1", "devices": [
      {"name": "right", "driver": "virtual_hand", "virtual_hand": {"repeats": true, "path": [
        {"time_s": 0, "translation_mm": [0, 20, -10]}, {"time_s": 1, "translation_mm": [0, 20, 10]},
        {"time_s": 2, "translation_mm": [0, 20, -10]}]}}],
      "needle": {"device": "right"}})");
  }
  scenario::Scenario Scenario(const std::vector<scenario::Override>& changes = {}) {
    return scenario::ReadScenario(folder_ / "scene.json", changes);
  }
};

TEST_F(PatientInPain, IsHeardLiveAndInTheReplay) {
  testing_support::PlayInto(folder_ / "played.wav");
  LiveOptions options;
  options.session_folder = folder_ / "s";
  options.duration_s = 4.0;
  {
    LiveSession session(Scenario(), ReadLiveDevices(folder_ / "devices.json"), options, context_);
    EXPECT_TRUE(RunHeadless(session, context_));
  }
  replay::ReplayOptions replay;
  replay.run_folder = folder_ / "r";
  replay.film = false;
  replay::ReplaySession(Scenario(), folder_ / "s", replay, context_);
  EXPECT_EQ(ReadTextFile(folder_ / "s/pain_reaction.csv"),
            ReadTextFile(folder_ / "r/pain_reaction.csv"));

  // The replay has a cry where the movement begins, to the sample.
  const sound::Sound cry = sound::Cry();
  const sound::Sound track = sound::ReadSound(folder_ / "r/pain_reaction.wav");
  const auto in_track = testing_support::FindSounds(track, cry);
  std::vector<double> begins_s;
  double first_s = -1.0;
  int reactions = 0;
  std::istringstream rows(ReadTextFile(folder_ / "r/pain_reaction.csv"));
  std::string row;
  std::getline(rows, row);
  ASSERT_EQ(row, "time_s,shift_mm,reactions");
  while (std::getline(rows, row)) {
    const double time_s = std::stod(row);
    if (first_s < 0.0) first_s = time_s;
    const int now = std::stoi(row.substr(row.rfind(',') + 1));
    if (now > reactions) begins_s.push_back(time_s - first_s + kLatencyS);
    reactions = now;
  }
  ASSERT_GE(begins_s.size(), 2U);
  ASSERT_EQ(in_track.size(), begins_s.size());
  for (std::size_t i = 0; i < begins_s.size(); ++i) {
    EXPECT_GT(in_track[i].likeness, 0.9999);
    EXPECT_NEAR(static_cast<double>(in_track[i].at) / track.rate_hz, begins_s[i],
                2.0 / track.rate_hz);
  }

  const auto heard = config::ReadJson(folder_ / "s/summary.json").at("pain_sound");
  if (heard.at("trouble") != "") GTEST_SKIP() << heard.at("trouble");
  EXPECT_EQ(heard.at("played"), reactions);
  const sound::Sound played = sound::ReadSound(folder_ / "played.wav");
  const auto in_room = testing_support::FindSounds(played, cry);
  ASSERT_GE(in_room.size(), 1U);
  for (std::size_t i = 0; i < in_room.size(); ++i) {
    EXPECT_GT(in_room[i].likeness, 0.999);
    // The file begins when the loudspeaker is opened: what counts is the time between.
    if (i == 0) continue;
    const double apart_s = static_cast<double>(in_room[i].at - in_room[i - 1].at) / played.rate_hz;
    EXPECT_NEAR(apart_s, begins_s[i] - begins_s[i - 1], 0.2);
  }
}

TEST_F(PatientInPain, IsSilentUnlessItIsAskedFor) {
  EXPECT_FALSE(replay::PainSoundOf(Scenario({{"/effects/pain_reaction/sound", "none"}}), context_));
  EXPECT_FALSE(replay::PainSoundOf(Scenario({{"/effects/pain_reaction", nullptr}}), context_));
  EXPECT_FALSE(replay::PainSoundOf(Scenario({{"/effects/pain_reaction", nlohmann::json::object()}}),
                                   context_));
}

TEST_F(PatientInPain, HasAVoiceOfAFileAfterTheLatency) {
  sound::WriteWav(folder_ / "ouch.wav", {.rate_hz = 8000, .samples = {5, 6, 7}});
  const std::vector<scenario::Override> changes = {{"/effects/pain_reaction/sound", "ouch.wav"},
                                                   {"/effects/pain_reaction/latency_s", 0.5}};
  const auto sound = replay::PainSoundOf(Scenario(changes), context_);
  ASSERT_TRUE(sound);
  ASSERT_EQ(sound->samples.size(), 4003U);
  EXPECT_EQ(sound->samples[3999], 0);
  EXPECT_EQ(sound->samples[4002], 7);
  EXPECT_THAT(
      [&] {
        replay::PainSoundOf(Scenario({{"/effects/pain_reaction/sound", "gone.wav"}}), context_);
      },
      testing::ThrowsMessage<InputError>(testing::AllOf(
          testing::HasSubstr("/effects/pain_reaction/sound: "), testing::HasSubstr("gone.wav"),
          testing::HasSubstr("\"none\" or \"cry\""))));
}

}  // namespace
}  // namespace acus::live
