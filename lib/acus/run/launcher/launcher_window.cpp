#include "acus/run/launcher/launcher_window.h"

#include <QComboBox>
#include <QDesktopServices>
#include <QFile>
#include <QGroupBox>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QListWidget>
#include <QProcess>
#include <QProgressBar>
#include <QPushButton>
#include <QTableWidget>
#include <QUrl>
#include <QVBoxLayout>
#include <array>

#include "acus/base/core/error.h"
#include "acus/base/translation/translation.h"
#include "acus/data/image/png.h"
#include "acus/run/launcher/patient_image.h"

namespace acus::launcher {
namespace {

namespace fs = std::filesystem;
using translation::Marked;
using translation::Translated;

constexpr int kImagePx = 320;
constexpr int kIconPx = 96;
constexpr const char* kImageFile = "image.png";

/// A synthetic patient that can be made: its text, and the options of pipelines/live-session.
struct Template {
  const char* text;
  const char* name;
  std::vector<std::string> options;
};

const std::vector<Template>& Templates() {
  static const std::vector<Template> all = {
      {Marked("Lumbar puncture"), "lumbar", {}},
      {Marked("Epidural puncture by loss of resistance"), "epidural", {"--procedure", "epidural"}},
      {Marked("Spinal puncture"), "spinal", {"--procedure", "spinal"}},
      {Marked("Injection into the subacromial bursa"),
       "bursa_injection",
       {"--procedure", "bursa_injection"}},
      {Marked("Nephrostomy"), "nephrostomy", {"--procedure", "nephrostomy"}},
      {Marked("Aspiration of a liver cyst"), "liver_cyst", {"--procedure", "liver_cyst"}},
      {Marked("Kidney puncture"), "kidney", {"--paper", "vidal_2008"}},
      {Marked("Shoulder puncture"), "shoulder", {"--paper", "alamilla_2021"}},
      {Marked("Bile duct drainage"), "bile_duct", {"--paper", "fortmeier_2016"}},
      {Marked("Spinal needle with a camera"), "spinal_camera", {"--paper", "augmented_2010"}}};
  return all;
}

QString Shown(const std::string& text) {
  return QString::fromStdString(text);
}

QString Words(const std::string& text, const std::vector<std::string>& values = {}) {
  return Shown(Translated(text, values));
}

QString PathText(const fs::path& path) {
  return QFile::decodeName(path.c_str());
}

/// The last lines that a program printed: its message, without what it printed before.
QString LastLines(const QString& said, int count) {
  const QStringList lines = said.trimmed().split('\n');
  return QStringList(lines.mid(std::max(0, lines.size() - count))).join('\n');
}

/// The lines of the devices, from the answer of pipelines/live-session --check.
QString DevicesOf(const QString& said) {
  QStringList devices;
  for (const QString& line : said.split('\n')) {
    const bool is_device = line.startsWith("Needle: ") || line.startsWith("Probe: ") ||
                           line.startsWith("Tracker: ") || line.startsWith("  ");
    if (is_device && !line.contains("  image ") && !line.contains("  step ")) devices << line;
  }
  return devices.join('\n');
}

QLabel* Label(const char* name) {
  auto* label = new QLabel;
  label->setObjectName(name);
  label->setWordWrap(true);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return label;
}

}  // namespace

LauncherWindow::LauncherWindow(const LauncherSettings& settings, const RunContext& context)
    : settings_(settings), context_(context) {
  context_.on_progress = nullptr;  // The images are made beside the window.
  setWindowTitle(Words(Marked("Acus: exercises")));
  auto* columns = new QHBoxLayout;
  columns->addWidget(MakePatients(), 3);
  columns->addWidget(MakeExercise(), 4);
  columns->addWidget(MakeTrainee(), 4);
  status_ = Label("status");
  progress_ = new QProgressBar;
  progress_->setRange(0, 0);
  progress_->setMaximumWidth(160);
  progress_->hide();
  auto* below = new QHBoxLayout;
  below->addWidget(status_, 1);
  below->addWidget(progress_);
  auto* all = new QVBoxLayout(this);
  all->addLayout(columns, 1);
  all->addLayout(below);
  resize(1100, 700);
  Refresh();
}

LauncherWindow::~LauncherWindow() {
  stop_ = true;
  if (images_.joinable()) images_.join();
  if (process_ == nullptr) return;
  process_->disconnect(this);
  process_->terminate();
  process_->waitForFinished(10000);
}

QPushButton* LauncherWindow::Button(const char* name, const char* text,
                                    const std::function<void()>& act) {
  auto* button = new QPushButton(Words(text));
  button->setObjectName(name);
  connect(button, &QPushButton::clicked, this, act);
  buttons_.push_back(button);
  return button;
}

QWidget* LauncherWindow::MakePatients() {
  auto* group = new QGroupBox(Words(Marked("Patients")));
  workplaces_ = new QListWidget;
  workplaces_->setObjectName("workplaces");
  workplaces_->setIconSize({kIconPx, kIconPx});
  workplaces_->setWordWrap(true);
  connect(workplaces_, &QListWidget::currentRowChanged, this, [this] { ShowWorkplace(); });
  template_ = new QComboBox;
  template_->setObjectName("template");
  for (const Template& one : Templates()) template_->addItem(Words(one.text));
  auto* layout = new QVBoxLayout(group);
  layout->addWidget(workplaces_, 1);
  layout->addWidget(new QLabel(Words(Marked("A new synthetic patient:"))));
  layout->addWidget(template_);
  layout->addWidget(Button("create", Marked("Create"), [this] { Create(); }));
  return group;
}

QWidget* LauncherWindow::MakeExercise() {
  auto* group = new QGroupBox(Words(Marked("Exercise")));
  image_ = new QLabel;
  image_->setFixedSize(kImagePx, kImagePx);
  image_->setStyleSheet("background: black");
  patient_ = Label("patient");
  exercises_ = new QListWidget;
  exercises_->setObjectName("exercises");
  exercises_->setMaximumHeight(90);
  connect(exercises_, &QListWidget::currentRowChanged, this, [this] { ShowExercise(); });
  instructions_ = Label("instructions");
  devices_ = Label("devices");
  auto* layout = new QVBoxLayout(group);
  layout->addWidget(image_, 0, Qt::AlignHCenter);
  layout->addWidget(patient_);
  layout->addWidget(exercises_);
  layout->addWidget(instructions_, 1, Qt::AlignTop);
  layout->addWidget(devices_);
  layout->addWidget(Button("check", Marked("Check the devices"), [this] { CheckDevices(); }));
  return group;
}

QWidget* LauncherWindow::MakeTrainee() {
  auto* group = new QGroupBox(Words(Marked("Trainee")));
  trainee_ = new QComboBox;
  trainee_->setObjectName("trainee");
  trainee_->setEditable(true);
  connect(trainee_, &QComboBox::currentTextChanged, this, [this] { ShowTrials(); });
  trials_ = new QTableWidget(0, 3);
  trials_->setObjectName("trials");
  trials_->setHorizontalHeaderLabels(
      {Words(Marked("Session")), Words(Marked("Goals met")), Words(Marked("Result"))});
  trials_->horizontalHeader()->setSectionResizeMode(QHeaderView::Stretch);
  trials_->horizontalHeader()->setSectionResizeMode(0, QHeaderView::ResizeToContents);
  trials_->verticalHeader()->hide();
  trials_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  trials_->setSelectionBehavior(QAbstractItemView::SelectRows);
  auto* start = Button("start", Marked("Start the session"), [this] { Start(false); });
  start->setDefault(true);
  start->setMinimumHeight(44);
  auto* layout = new QVBoxLayout(group);
  layout->addWidget(new QLabel(Words(Marked("Code, not the name:"))));
  layout->addWidget(trainee_);
  layout->addWidget(start);
  layout->addWidget(
      Button("demonstration", Marked("Show a demonstration"), [this] { Start(true); }));
  layout->addWidget(trials_, 1);
  layout->addWidget(Button("report", Marked("Open the report"), [this] { OpenReport(); }));
  layout->addWidget(Button("progress", Marked("Open the progress"), [this] {
    QDesktopServices::openUrl(
        QUrl::fromLocalFile(PathText(ProgressPage(*Chosen(), Trainee(), ChosenExercise()))));
  }));
  return group;
}

const Workplace* LauncherWindow::Chosen() const {
  const int row = workplaces_->currentRow();
  return row >= 0 && row < static_cast<int>(found_.size()) ? &found_[static_cast<std::size_t>(row)]
                                                           : nullptr;
}

std::string LauncherWindow::ChosenExercise() const {
  const int row = exercises_->currentRow();
  return Chosen() == nullptr || row < 0
             ? ""
             : Chosen()->exercises[static_cast<std::size_t>(row)].file_name;
}

std::string LauncherWindow::Trainee() const {
  return trainee_->currentText().trimmed().toStdString();
}

void LauncherWindow::Refresh() {
  const std::string before = Chosen() == nullptr ? "" : Chosen()->folder.string();
  found_ = FindWorkplaces(settings_.folder);
  workplaces_->blockSignals(true);
  workplaces_->clear();
  int row = 0;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    workplaces_->addItem(Words(found_[i].patient) + '\n' + Shown(found_[i].name));
    if (found_[i].folder == before) row = static_cast<int>(i);
  }
  workplaces_->blockSignals(false);
  workplaces_->setCurrentRow(found_.empty() ? -1 : row);
  if (found_.empty()) {
    Say(Words(Marked("There is no patient yet: create one on the left.")));
    SetButtons();
  }
  for (const Workplace& workplace : found_) ShowImage(workplace.folder.string());
  MakeImages();
}

/// One thread makes the images that are missing; each is kept in its workplace.
void LauncherWindow::MakeImages() {
  stop_ = true;
  if (images_.joinable()) images_.join();
  stop_ = false;
  images_ = std::thread([this, workplaces = found_, context = context_] {
    for (const Workplace& workplace : workplaces) {
      const fs::path file = workplace.folder / kImageFile;
      if (stop_) return;
      if (fs::exists(file)) continue;
      try {
        image::WritePng(file, ImageOf(workplace.folder, kImagePx, context), "Acus");
      } catch (const std::exception&) {
        continue;  // A workplace without a image can be used all the same.
      }
      QMetaObject::invokeMethod(
          this, [this, folder = workplace.folder.string()] { ShowImage(folder); },
          Qt::QueuedConnection);
    }
  });
}

void LauncherWindow::ShowImage(const std::string& folder) {
  const QPixmap image(PathText(fs::path(folder) / kImageFile));
  for (std::size_t i = 0; i < found_.size(); ++i) {
    if (found_[i].folder == folder && !image.isNull()) {
      workplaces_->item(static_cast<int>(i))->setIcon(QIcon(image));
    }
  }
  if (Chosen() != nullptr && Chosen()->folder == folder) image_->setPixmap(image);
}

void LauncherWindow::ShowWorkplace() {
  const Workplace* workplace = Chosen();
  exercises_->clear();
  trainee_->clear();
  devices_->clear();
  if (workplace == nullptr) return;
  ShowImage(workplace->folder.string());
  patient_->setText("<b>" + Words(workplace->patient).toHtmlEscaped() + "</b>");
  for (const std::string& code : workplace->trainees) trainee_->addItem(Shown(code));
  for (const ExerciseOfWorkplace& exercise : workplace->exercises) {
    exercises_->addItem(Words(exercise.title));
  }
  exercises_->setCurrentRow(0);
  if (workplace->trouble.empty()) {
    CheckDevices();
  } else {
    Say(Shown(workplace->trouble));
    SetButtons();
  }
}

void LauncherWindow::ShowExercise() {
  const int row = exercises_->currentRow();
  if (Chosen() == nullptr || row < 0) return;
  instructions_->setText(Words(Chosen()->exercises[static_cast<std::size_t>(row)].instructions));
  ShowTrials();
}

void LauncherWindow::ShowTrials() {
  trials_shown_.clear();
  if (Chosen() != nullptr && IsTraineeCode(Trainee())) {
    trials_shown_ = TrialsOf(*Chosen(), Trainee(), ChosenExercise());
  }
  trials_->setRowCount(static_cast<int>(trials_shown_.size()));
  for (int row = 0; row < trials_->rowCount(); ++row) {
    const Trial& trial = trials_shown_[static_cast<std::size_t>(row)];
    const std::array<QString, 3> cells = {
        Shown(trial.time),
        Words(Marked("{1} of {2}"),
              {std::to_string(trial.goals_met), std::to_string(trial.num_goals)}),
        trial.passed ? Words(Marked("passed")) : Words(Marked("failed"))};
    for (int column = 0; column < 3; ++column) {
      trials_->setItem(row, column, new QTableWidgetItem(cells[static_cast<std::size_t>(column)]));
    }
  }
  if (trials_->rowCount() > 0) trials_->selectRow(trials_->rowCount() - 1);
  SetButtons();
}

void LauncherWindow::SetButtons() {
  const bool usable = Chosen() != nullptr && Chosen()->trouble.empty() && !busy();
  for (QPushButton* button : buttons_) {
    const QString name = button->objectName();
    const bool has_page =
        usable && fs::exists(ProgressPage(*Chosen(), Trainee(), ChosenExercise()));
    button->setEnabled(name == "create"     ? !busy()
                       : name == "report"   ? !trials_shown_.empty()
                       : name == "progress" ? has_page
                       : name == "start"    ? usable && IsTraineeCode(Trainee())
                                            : usable);
  }
}

void LauncherWindow::Say(const QString& text) {
  status_->setText(text);
}

void LauncherWindow::Run(const std::vector<std::string>& arguments, const QString& meanwhile,
                         const std::function<void(int, const QString&)>& after) {
  if (busy()) return;
  process_ = new QProcess(this);
  process_->setProcessChannelMode(QProcess::MergedChannels);
  QStringList words = {"--text"};
  for (const std::string& argument : arguments) words << Shown(argument);
  const auto end = [this, after](int code, const QString& said) {
    process_->deleteLater();
    process_ = nullptr;
    progress_->hide();
    after(code, said);
    SetButtons();
  };
  connect(process_, qOverload<int, QProcess::ExitStatus>(&QProcess::finished), this,
          [this, end](int code, QProcess::ExitStatus status) {
            const QString said = QString::fromUtf8(process_->readAll());
            end(status == QProcess::NormalExit ? code : -1, said);
          });
  connect(process_, &QProcess::errorOccurred, this, [this, end](QProcess::ProcessError error) {
    if (error == QProcess::FailedToStart) end(-1, process_->errorString());
  });
  Say(meanwhile);
  progress_->show();
  process_->start(PathText(settings_.live_session), words);
  SetButtons();
}

void LauncherWindow::CheckDevices() {
  if (Chosen() == nullptr) return;
  const std::string folder = Chosen()->folder.string();
  Run({"--headless", "--check", folder}, Words(Marked("The devices are being checked ...")),
      [this, folder](int code, const QString& said) {
        if (Chosen() == nullptr || Chosen()->folder != folder) return CheckDevices();
        devices_->setText(code == 0 ? DevicesOf(said) : LastLines(said, 8));
        Say(code == 0 ? Words(Marked("Ready. Type a code and start the session."))
                      : Words(Marked("Not ready: see the devices.")));
      });
}

void LauncherWindow::Start(bool as_demonstration) {
  const std::string trainee = as_demonstration ? "demonstration" : Trainee();
  std::vector<std::string> arguments = {"--trainee", trainee, "--exercise", ChosenExercise()};
  if (as_demonstration) arguments.emplace_back("--demo");
  arguments.insert(arguments.end(), settings_.session_options.begin(),
                   settings_.session_options.end());
  arguments.push_back(Chosen()->folder.string());
  Run(arguments, Words(Marked("The session runs in its window; its report is made at its end.")),
      [this, trainee](int code, const QString& said) {
        if (trainee_->findText(Shown(trainee)) < 0) trainee_->addItem(Shown(trainee));
        trainee_->setCurrentText(Shown(trainee));
        ShowTrials();
        Say(code == 0 ? Words(Marked("The session has ended; its report is on the right."))
                      : LastLines(said, 4));
      });
}

void LauncherWindow::Create() {
  const Template& chosen = Templates()[static_cast<std::size_t>(template_->currentIndex())];
  fs::path folder = settings_.folder / chosen.name;
  for (int n = 2; fs::exists(folder); ++n) {
    folder = settings_.folder / (chosen.name + ("_" + std::to_string(n)));
  }
  std::vector<std::string> arguments = {"--new"};
  arguments.insert(arguments.end(), chosen.options.begin(), chosen.options.end());
  arguments.push_back(folder.string());
  Run(arguments, Words(Marked("The patient is being made; this takes up to a minute ...")),
      [this](int code, const QString& said) {
        if (code == 0) return Refresh();
        Say(LastLines(said, 4));
      });
}

void LauncherWindow::OpenReport() {
  const int row = trials_->currentRow();
  if (row < 0 || row >= static_cast<int>(trials_shown_.size())) return;
  const fs::path page = trials_shown_[static_cast<std::size_t>(row)].folder / "report/report.html";
  QDesktopServices::openUrl(QUrl::fromLocalFile(PathText(page)));
}

}  // namespace acus::launcher
