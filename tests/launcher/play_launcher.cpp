// Plays acus-launcher with mouse and keyboard, on a display:
//   play_launcher WORKPLACES LIVE_SESSION SCREENSHOT.png
// Starts a real session of the first workplace, and looks at what the window shows afterwards.
#include <QApplication>
#include <QComboBox>
#include <QDir>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QPushButton>
#include <QTableWidget>
#include <QTest>
#include <iostream>

#include "acus/run/launcher/launcher_window.h"

namespace {

constexpr int kPatienceMs = 100000;

bool Fails(bool good, const QString& what) {
  if (!good) std::cerr << "play_launcher: " << what.toStdString() << '\n';
  return !good;
}

int Play(acus::launcher::LauncherWindow& window, const QString& screenshot) {
  const auto idle = [&] { return !window.busy(); };
  const auto* devices = window.findChild<QLabel*>("devices");
  const auto* status = window.findChild<QLabel*>("status");
  auto* start = window.findChild<QPushButton*>("start");
  const auto* patients = window.findChild<QListWidget*>("workplaces");
  if (Fails(QTest::qWaitFor(idle, kPatienceMs), "the check of the devices does not end")) return 1;
  if (Fails(devices->text().contains("virtual hand"), "devices: " + devices->text())) return 1;
  if (Fails(!start->isEnabled(), "a session can be started without a code")) return 1;
  const auto has_image = [&] { return !patients->item(0)->icon().isNull(); };
  if (Fails(QTest::qWaitFor(has_image, kPatienceMs), "the patient has no image")) return 1;
  QTest::keyClicks(window.findChild<QComboBox*>("trainee")->lineEdit(), "T1");
  if (Fails(start->isEnabled(), "a session cannot be started with a code")) return 1;
  QTest::mouseClick(start, Qt::LeftButton);
  if (Fails(window.busy(), "no session runs")) return 1;
  if (Fails(QTest::qWaitFor(idle, kPatienceMs), "the session does not end")) return 1;
  const auto* trials = window.findChild<QTableWidget*>("trials");
  if (Fails(trials->rowCount() == 1, "the session is not listed: " + status->text())) return 1;
  if (Fails(window.findChild<QPushButton*>("report")->isEnabled(), "no report")) return 1;
  if (Fails(window.findChild<QPushButton*>("progress")->isEnabled(), "no progress")) return 1;
  return Fails(window.grab().save(screenshot), "no screenshot") ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  if (argc != 4) return 2;
  acus::launcher::LauncherSettings settings;
  settings.folder = argv[1];
  settings.live_session = argv[2];
  settings.session_options = {"--headless", "--duration", "1"};
  acus::launcher::LauncherWindow window(settings, acus::RunContext());
  window.show();
  return Play(window, argv[3]);
}
