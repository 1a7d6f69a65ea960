// The windows of a session: the trainee's, and that of a trainer who looks on.
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
  /// Of a second window, for the trainer; empty: none. Its keys are those of the first; it has no
  /// hand on the tools.
  std::string trainer_views;
};

class SessionWindows {
 public:
  /// Opens them.
  /// @throws InputError as Window(), or for a view that there is not.
  SessionWindows(const PatientOnDisplay& patient, const WindowsSettings& settings);

  /// Handles what was done, then shows a moment; the trainer's window in each third call.
  void Show(const DisplayFrame& frame);
  /// Before the next session: its keys and views as at first.
  void Restart();
  /// While no session runs.
  void ShowText(const std::string& text);
  void HandleEvents();
  /// Of both windows, since the last call.
  std::vector<Command> TakeCommands();
  /// Of the trainee's window alone.
  HandInput TakeHandInput();
  /// The trainee's window was closed. That of the trainer may be closed without further effect.
  bool closed() const;
  /// Of the trainee's window; nothing while its volume view is not shown.
  std::optional<VolumeReadout> volume() const { return trainee_.volume(); }
  /// PNG files; the trainer's window is beside the other's as NAME_trainer.png.
  void WriteScreenshots(const std::filesystem::path& path);

 private:
  Window trainee_;
  std::optional<Window> trainer_;
  long num_shown_ = 0;
};

}  // namespace acus::window
