// The window of acus-launcher, by Qt. Its parts are found by their object names: "workplaces",
// "exercises", "trainee", "trials", "devices", "status", "start", "demonstration", "check",
// "report", "progress", "template", "create".
#pragma once

#include <QWidget>
#include <atomic>
#include <functional>
#include <thread>

#include "acus/run/launcher/launcher.h"
#include "acus/run/launcher/workplaces.h"

class QComboBox;
class QLabel;
class QListWidget;
class QProcess;
class QProgressBar;
class QPushButton;
class QTableWidget;

namespace acus::launcher {

class LauncherWindow : public QWidget {
 public:
  LauncherWindow(const LauncherSettings& settings, const RunContext& context);
  /// Ends what it has started, a session included: it keeps what it has recorded.
  ~LauncherWindow() override;

  /// Whether a session, a check or the making of a workplace runs.
  bool busy() const { return process_ != nullptr; }

 private:
  QWidget* MakePatients();
  QWidget* MakeExercise();
  QWidget* MakeTrainee();
  QPushButton* Button(const char* name, const char* text, const std::function<void()>& act);

  void Refresh();
  void ShowWorkplace();
  void ShowExercise();
  void ShowTrials();
  void ShowImage(const std::string& folder);
  void SetButtons();
  void Say(const QString& text);

  void CheckDevices();
  void Start(bool as_demonstration);
  void Create();
  void OpenReport();

  const Workplace* Chosen() const;
  std::string ChosenExercise() const;
  std::string Trainee() const;
  /// Runs pipelines/live-session; `after` gets its exit code and what it printed.
  void Run(const std::vector<std::string>& arguments, const QString& meanwhile,
           const std::function<void(int code, const QString& said)>& after);
  void MakeImages();

  LauncherSettings settings_;
  RunContext context_;
  std::vector<Workplace> found_;
  std::vector<Trial> trials_shown_;
  QListWidget* workplaces_ = nullptr;
  QLabel* image_ = nullptr;
  QLabel* patient_ = nullptr;
  QLabel* devices_ = nullptr;
  QListWidget* exercises_ = nullptr;
  QLabel* instructions_ = nullptr;
  QComboBox* trainee_ = nullptr;
  QTableWidget* trials_ = nullptr;
  QComboBox* template_ = nullptr;
  QLabel* status_ = nullptr;
  QProgressBar* progress_ = nullptr;
  std::vector<QPushButton*> buttons_;  ///< Those that start something.
  QProcess* process_ = nullptr;        ///< Null: nothing runs.
  std::atomic<bool> stop_ = false;
  std::thread images_;
};

}  // namespace acus::launcher
