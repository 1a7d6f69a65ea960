// The windows of a session: the trainee's, and that of a trainer who watches.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/window/window.h"

namespace acus::window {

struct WindowsSettings {
  WindowSettings window;
  /// Names of the views to show, as ViewsOf() takes them; empty: see WindowSettings::views.
  std::string views;
  /// Views of a second window, for the trainer; empty: none. It has the same keys as the first; its
  /// mouse and keys do not move tools.
  std::string trainer_views;
};

class SessionWindows {
 public:
  /// Opens the windows.
  /// @param screen  For the trainee's window, as Window() takes it.
  /// @throws InputError as Window(), or for a view that does not exist.
  SessionWindows(const PatientOnDisplay& patient, const WindowsSettings& settings,
                 std::unique_ptr<Screen> screen = nullptr);

  /// Handles the input, then shows a frame; the trainer's window in each third call.
  void Show(const DisplayFrame& frame);
  /// Before the next session: resets keys and views.
  void Restart();
  /// While no session runs.
  void ShowText(const std::string& text);
  void HandleEvents();
  /// Commands of both windows, since the last call.
  std::vector<Command> TakeCommands();
  /// Input of the trainee's window alone.
  HandInput TakeHandInput();
  /// The trainee's window was closed. Closing the trainer's has no further effect.
  bool closed() const;
  /// State of the trainee's window; nothing while its volume view is not shown.
  std::optional<VolumeReadout> volume() const { return trainee_.volume(); }
  /// Writes PNG files; the trainer's window as NAME_trainer.png beside the other.
  void WriteScreenshots(const std::filesystem::path& path);

 private:
  Window trainee_;
  std::optional<Window> trainer_;
  long num_shown_ = 0;
};

}  // namespace acus::window
