// A first session by somebody who does what the screen states, and nothing else:
//   first_session SCENARIO DEVICES EXERCISE SESSION_FOLDER
// Reads the lines of the status bar, in virtual time, and presses the keys that they name until the
// session is ended as the window says. Prints what was read and pressed. Exit code 4 if the session
// does not end within five minutes.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <string_view>

#include "acus/base/core/run_main.h"
#include "acus/base/core/text_table.h"
#include "acus/window/frame_maker.h"
#include "acus/window/session_operation.h"
#include "acus/window/status_bar.h"
#include "acus/window/steering.h"

namespace acus {
namespace {

/// Time limit of the session.
constexpr double kPatienceS = 300.0;
/// From a line on the screen to the key.
constexpr double kReactionS = 0.3;
/// A key is held no longer without a look at the screen.
constexpr double kLongestPressS = 0.5;
/// A person keeps this distance from what a key reaches in that time, and taps the key.
constexpr double kTapMm = 4.0;

/// A key in the words of the screen, and as the window receives it.
struct NamedKey {
  std::string_view words;
  const char* key;
};
constexpr std::array<NamedKey, 6> kMovements = {{{"Page Down", "Next"},
                                                 {"Page Up", "Prior"},
                                                 {"Left", "Left"},
                                                 {"Right", "Right"},
                                                 {"Up", "Up"},
                                                 {"Down", "Down"}}};

class Newcomer {
 public:
  explicit Newcomer(live::LiveSession& session)
      : session_(session), frames_(session), operation_(session) {}

  /// Looks at the screen. False: the session is ended.
  bool Look(const live::LiveSnapshot& snapshot) {
    image_.snapshot = snapshot;
    image_.number = 1;
    frames_.SetNotice(operation_.NoticeAt(session_.session_s()));
    const window::DisplayFrame& frame =
        frames_.Make(image_, nullptr, steering_.choice().steers_probe);
    const double now_s = session_.session_s();
    if (held_ != nullptr && now_s >= release_s_) Send(window::InputEvent::Kind::kKeyUp, held_);
    if (held_ == nullptr && now_s >= next_s_) Act(frame, now_s);
    if (!operation_.Obey(steering_.TakeCommands(), image_, now_s)) return false;
    operation_.Move(steering_.TakeHandInput(), frame.tip_to_target_mm, now_s);
    return true;
  }

 private:
  using Kind = window::InputEvent::Kind;

  void Send(Kind kind, const char* key) {
    const window::InputEvent event{.kind = kind, .key = key};
    steering_.Handle(std::span(&event, 1), {}, {});
    held_ = kind == Kind::kKeyDown ? key : nullptr;
  }
  void Tap(const char* key) {
    Send(Kind::kKeyDown, key);
    Send(Kind::kKeyUp, key);
  }

  /// The line that says what to do: the first that names a key.
  void Act(const window::DisplayFrame& frame, double now_s) {
    next_s_ = now_s + kReactionS;
    for (const window::StatusLine& line : LinesToShow(frame, steering_.choice())) {
      if (line.text != said_) std::cout << FixedText(now_s, 1) << " s  " << line.text << '\n';
      said_ = line.text;
      if (Do(line.text, frame, now_s)) return;
    }
  }

  bool Do(std::string_view line, const window::DisplayFrame& frame, double now_s) {
    const auto says = [&](std::string_view words) { return line.find(words) != line.npos; };
    if (says("press Q twice") || says("Press Q again")) return Press("q");
    if (says("Tab selects")) return Press("Tab");
    if (says("D shows more")) return Press("d");
    if (says("B holds the breath")) return Press("b");
    if (says("Page Down and Page Up, in turn")) {
      back_ = !back_;  // The first one is Page Down; the needle stays in the skin.
      return back_ ? Hold("Prior", 0.2, now_s) : Hold("Next", 0.3, now_s);
    }
    for (const NamedKey& named : kMovements) {
      for (const char* verb : {" moves it there", " advances", " withdraws"}) {
        if (!says(std::string(named.words) + verb)) continue;
        return Hold(named.key, PressS(line, frame), now_s);
      }
    }
    return false;
  }

  bool Press(const char* key) {
    Tap(key);
    return true;
  }
  bool Hold(const char* key, double for_s, double now_s) {
    if (for_s <= 0.0) return Press(key);
    Send(Kind::kKeyDown, key);
    release_s_ = now_s + for_s;
    return true;
  }

  /// How long to hold a key for the distance in the line, or that to the target. 0: tap it.
  static double PressS(std::string_view line, const window::DisplayFrame& frame) {
    double way_mm = frame.tip_to_target_mm.value_or(10.0);
    const std::size_t unit = line.find(" mm");
    if (unit != line.npos) {
      const std::size_t before = line.rfind(' ', unit - 1);
      way_mm = std::stod(std::string(line.substr(before + 1, unit - before - 1)));
    }
    if (way_mm < kTapMm) return 0.0;
    return std::min(kLongestPressS, (way_mm - kTapMm) / window::kHeldMmPerS);
  }

  live::LiveSession& session_;
  window::FrameMaker frames_;
  window::SessionOperation operation_;
  window::Steering steering_;
  live::LiveImage image_;
  std::string said_;
  const char* held_ = nullptr;
  double release_s_ = 0.0;
  double next_s_ = 1.0;
  bool back_ = true;
};

ExitCode Play(const std::array<std::string, 4>& files, RunContext& context) {
  live::LiveOptions options;
  options.session_folder = files[3];
  options.virtual_time = true;
  options.duration_s = kPatienceS;
  live::UseExercise(files[2], options, context);
  const auto scenario = scenario::ReadScenario(files[0], {});
  live::LiveSession session(scenario, live::ReadLiveDevices(files[1]), options, context);
  std::optional<Newcomer> newcomer;
  session.RunInVirtualTime([&](const live::LiveSnapshot& snapshot) {
    if (!newcomer) newcomer.emplace(session);
    return newcomer->Look(snapshot);
  });
  std::cout << "Ended after " << FixedText(session.session_s(), 1) << " s\n";
  return session.end() == live::SessionEnd::kStopped ? ExitCode::kOk : ExitCode::kNoAnswer;
}

}  // namespace
}  // namespace acus

int main(int argc, char** argv) {
  CLI::App app{"Plays a first session by what the screen says.", "first_session"};
  std::array<std::string, 4> files;
  const std::array names = {"scenario", "devices", "exercise", "output"};
  for (std::size_t i = 0; i < files.size(); ++i) {
    app.add_option(names[i], files[i], "File")->required();
  }
  return acus::RunMain(app, argc, argv,
                       [&](acus::RunContext& context) { return acus::Play(files, context); });
}
