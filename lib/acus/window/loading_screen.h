// The window while a session is prepared: what is being done, and how far it is.
#pragma once

#include <memory>
#include <string_view>

#include "acus/base/core/run_context.h"
#include "acus/window/screen.h"
#include "acus/window/window.h"

namespace acus::window {

/// Opens at once, before the patient is read; its screen then becomes that of the session's window.
/// All calls come from the constructing thread.
class LoadingScreen {
 public:
  /// @throws InputError as Window().
  explicit LoadingScreen(const WindowSettings& settings);
  ~LoadingScreen();
  LoadingScreen(const LoadingScreen&) = delete;
  LoadingScreen& operator=(const LoadingScreen&) = delete;

  /// @param task  In English, as in RunContext::on_progress.
  /// @param fraction  Of this task, in [0, 1].
  void Show(std::string_view task, double fraction);

  /// `context`, whose progress is shown here too. @pre This outlives its use.
  RunContext Shown(const RunContext& context);

  /// Its screen, which keeps the last image until something else is drawn; Show() does nothing any
  /// more.
  std::unique_ptr<Screen> Release();

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::window
