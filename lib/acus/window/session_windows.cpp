#include "acus/window/session_windows.h"

#include "acus/data/image/png.h"
#include "acus/window/screen.h"

namespace acus::window {
namespace {

/// The trainee's images have priority.
constexpr long kTrainerEach = 3;

WindowSettings With(WindowSettings settings, const std::string& views) {
  if (!views.empty()) settings.views = ViewsOf(views);
  return settings;
}

WindowSettings OfTrainer(WindowSettings settings, const std::string& views) {
  settings.title += ": trainer";
  return With(settings, views);
}

}  // namespace

SessionWindows::SessionWindows(const PatientOnDisplay& patient, const WindowsSettings& settings,
                               std::unique_ptr<Screen> screen)
    : trainee_(patient, With(settings.window, settings.views), std::move(screen)) {
  if (settings.trainer_views.empty()) return;
  trainer_.emplace(patient, OfTrainer(settings.window, settings.trainer_views));
}

void SessionWindows::Show(const DisplayFrame& frame) {
  trainee_.Show(frame);
  if (trainer_ && num_shown_++ % kTrainerEach == 0) trainer_->Show(frame);
}

void SessionWindows::Restart() {
  trainee_.Restart();
  if (trainer_) trainer_->Restart();
}

void SessionWindows::ShowText(const std::string& text) {
  trainee_.ShowText(text);
  if (trainer_) trainer_->ShowText(text);
}

void SessionWindows::HandleEvents() {
  trainee_.HandleEvents();
  if (trainer_) trainer_->HandleEvents();
}

std::vector<Command> SessionWindows::TakeCommands() {
  std::vector<Command> commands = trainee_.TakeCommands();
  if (trainer_) {
    const std::vector<Command> more = trainer_->TakeCommands();
    commands.insert(commands.end(), more.begin(), more.end());
  }
  return commands;
}

HandInput SessionWindows::TakeHandInput() {
  return trainee_.TakeHandInput();
}

bool SessionWindows::closed() const {
  return trainee_.closed();
}

void SessionWindows::WriteScreenshots(const std::filesystem::path& path) {
  image::WritePng(path, trainee_.Screenshot(), "Acus");
  if (!trainer_ || trainer_->closed()) return;
  const auto name = path.stem().string() + "_trainer" + path.extension().string();
  image::WritePng(path.parent_path() / name, trainer_->Screenshot(), "Acus");
}

}  // namespace acus::window
