#include "acus/run/launcher/launcher.h"

#include <CLI/CLI.hpp>
#include <QApplication>
#include <QStyleFactory>
#include <QTimer>
#include <cstdlib>
#include <memory>
#include <ostream>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/translation/translation.h"
#include "acus/run/entry/commands.h"
#include "acus/run/launcher/launcher_window.h"

namespace acus::launcher {
namespace {

namespace fs = std::filesystem;

constexpr int kLookForStopMs = 200;

struct LauncherOptions {
  fs::path folder;
  bool list = false;
  bool headless = false;
  double duration_s = 0.0;
};

fs::path LiveSessionFile() {
  const fs::path file = fs::weakly_canonical(
      entry::FileOf(*entry::FindCommand("live-session"), fs::read_symlink("/proc/self/exe")));
  ACUS_REQUIRE(
      fs::exists(file), file.string(),
      ": missing, but the launcher starts sessions by it; install Acus whole, or build it");
  return file;
}

/// Qt ends the program where there is no display.
void RequireDisplay() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"}) {
    const char* value = std::getenv(name);
    if (value != nullptr && *value != '\0') return;
  }
  throw InputError(
      "there is no screen to open a window on: DISPLAY is not set; log in at the "
      "desktop, or use acus live-session --headless");
}

/// Workplaces with their exercises, and what is wrong with them.
std::string ListText(const fs::path& folder) {
  std::string text;
  for (const Workplace& workplace : FindWorkplaces(folder)) {
    text += Message(workplace.folder.string(), ": ", workplace.patient, '\n');
    if (!workplace.trouble.empty()) text += Message("  ", workplace.trouble, '\n');
    for (const ExerciseOfWorkplace& exercise : workplace.exercises) {
      text += Message("  ", exercise.file_name, ": ", exercise.title, '\n');
    }
  }
  return text.empty() ? Message("There is no workplace in ", folder.string(), ".\n") : text;
}

ExitCode RunLauncher(const LauncherOptions& options, const RunContext& context, std::ostream& out) {
  if (options.list) {
    out << ListText(options.folder);
    return ExitCode::kOk;
  }
  RequireDisplay();
  translation::UseLanguage(translation::LanguageOfEnvironment(), translation::LocaleFolder());
  LauncherSettings settings;
  settings.folder = options.folder;
  settings.live_session = LiveSessionFile();
  fs::create_directories(options.folder);
  if (options.headless) settings.session_options.emplace_back("--headless");
  if (options.duration_s > 0.0) {
    settings.session_options.emplace_back("--duration");
    settings.session_options.push_back(RoundedText(options.duration_s, 6));
  }
  int count = 1;
  std::string name = "acus-launcher";
  char* words[] = {name.data(), nullptr};
  QApplication application(count, words);
  QApplication::setStyle(QStyleFactory::create("Fusion"));
  LauncherWindow window(settings, context);
  window.show();
  QTimer timer;
  QObject::connect(&timer, &QTimer::timeout, [&] {
    if (context.stop != nullptr && context.stop->load()) QApplication::quit();
  });
  timer.start(kLookForStopMs);
  QApplication::exec();
  return ExitCode::kOk;
}

}  // namespace

std::function<ExitCode(RunContext& context, std::ostream& out)> AddLauncherOptions(CLI::App& app) {
  const auto options = std::make_shared<LauncherOptions>();
  app.add_option("folder", options->folder,
                 "Folder of workplaces, or one workplace; it is made if it is not there")
      ->required();
  app.add_flag("--list", options->list, "Print the workplaces and their exercises, open no window");
  app.add_flag("--headless", options->headless, "Of every session: without its window");
  app.add_option("--duration", options->duration_s,
                 "Of every session: ends by itself after so many seconds")
      ->check(CLI::Range(0.0, 86400.0));
  return [options](RunContext& context, std::ostream& out) {
    return RunLauncher(*options, context, out);
  };
}

}  // namespace acus::launcher
