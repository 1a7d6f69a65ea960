#include "acus/assess/study/study_file.h"

#include <algorithm>
#include <set>

#include "acus/assess/study/csv_cell.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/run/training/exercise.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Questionnaire ReadQuestionnaire(const fs::path& path) {
  const json file = config::ReadConfig(path, "acus-questionnaire");
  Questionnaire read;
  read.key = file.at("key");
  read.title = file.at("title");
  read.scale = file.at("scale").get<std::vector<std::string>>();
  std::set<std::string> keys;
  for (const json& item : file.at("items")) {
    read.items.push_back({item.at("key"), item.at("text"), item.at("reversed")});
    ACUS_REQUIRE(keys.insert(read.items.back().key).second, path.string(), ": /items: \"",
                 read.items.back().key, "\" is there twice");
  }
  return read;
}

std::vector<Participant> ParticipantsOf(const json& list, const std::vector<std::string>& groups,
                                        const std::string& file) {
  std::vector<Participant> participants;
  std::set<std::string> codes;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const json& entry = list[i];
    const std::string where = Message(file, ": /participants/", i, ": ");
    Participant person{entry.at("code"), entry.at("group"), entry.at("consent"), entry.at("hand")};
    ACUS_REQUIRE(codes.insert(person.code).second, where, "the code ", person.code,
                 " is there twice");
    ACUS_REQUIRE(std::ranges::find(groups, person.group) != groups.end(), where, "the group \"",
                 person.group, "\" is not among /groups");
    participants.push_back(std::move(person));
  }
  return participants;
}

/// Fisher-Yates.
template <typename T>
void Shuffle(std::vector<T>& values, RandomStream& random) {
  for (std::size_t i = values.size(); i > 1; --i) {
    const auto j = static_cast<std::size_t>(random.Uniform() * static_cast<double>(i));
    std::swap(values[i - 1], values[std::min(j, i - 1)]);
  }
}

std::vector<std::string> Rotated(const std::vector<std::string>& exercises, std::size_t by) {
  std::vector<std::string> row = exercises;
  std::ranges::rotate(row, row.begin() + static_cast<std::ptrdiff_t>(by % row.size()));
  return row;
}

/// Each participant's row of the Latin square, in the order of Study::participants.
std::vector<std::size_t> BalancedRows(const Study& study) {
  std::vector<std::size_t> rows(study.participants.size());
  for (const std::string& group : study.groups) {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < study.participants.size(); ++i) {
      if (study.participants[i].group == group) members.push_back(i);
    }
    RandomStream random(study.seed, "rows of " + group);
    Shuffle(members, random);
    for (std::size_t n = 0; n < members.size(); ++n) rows[members[n]] = n;
  }
  return rows;
}

}  // namespace

const Participant* Study::Find(const std::string& code) const {
  const auto found = std::ranges::find(participants, code, &Participant::code);
  return found == participants.end() ? nullptr : &*found;
}

Study ReadStudy(const fs::path& path) {
  const json file = config::ReadConfig(path, "acus-study");
  const fs::path folder = fs::absolute(path).parent_path();
  Study study;
  study.file = path;
  study.name = file.at("name");
  study.groups = file.at("groups").get<std::vector<std::string>>();
  study.participants = ParticipantsOf(file.at("participants"), study.groups, path.string());
  for (const std::string name : file.at("exercises")) {
    study.exercise_files.push_back(config::FindConfig(name, folder));
    study.exercises.push_back(training::ReadExercise(study.exercise_files.back()).name);
    ACUS_REQUIRE(std::ranges::count(study.exercises, study.exercises.back()) == 1, path.string(),
                 ": /exercises: two are named \"", study.exercises.back(), "\"");
  }
  study.trials = file.at("trials");
  const std::string order = file.at("order");
  study.order = order == "fixed"      ? OrderKind::kFixed
                : order == "balanced" ? OrderKind::kBalanced
                                      : OrderKind::kRandom;
  study.seed = file.at("seed");
  for (const std::string name : file.at("questionnaires")) {
    study.questionnaires.push_back(ReadQuestionnaire(config::FindConfig(name, folder)));
  }
  const json& analysis = file.at("analysis");
  study.analysis = {analysis.at("confidence"), analysis.at("bootstrap_draws"),
                    analysis.at("separating_auc"), analysis.at("power"), analysis.at("alpha")};
  return study;
}

std::vector<PlannedOrder> PlanOrder(const Study& study) {
  const std::vector<std::size_t> rows = BalancedRows(study);
  std::vector<PlannedOrder> orders;
  for (std::size_t i = 0; i < study.participants.size(); ++i) {
    PlannedOrder order{study.participants[i].code, study.exercises};
    if (study.order == OrderKind::kBalanced) order.exercises = Rotated(study.exercises, rows[i]);
    if (study.order == OrderKind::kRandom) {
      RandomStream random(study.seed, "order " + order.code);
      Shuffle(order.exercises, random);
    }
    orders.push_back(std::move(order));
  }
  return orders;
}

std::string OrderCsv(const Study& study) {
  std::string csv = "code,group,place,exercise\n";
  for (const PlannedOrder& order : PlanOrder(study)) {
    for (std::size_t place = 0; place < order.exercises.size(); ++place) {
      csv += Message(order.code, ",", CsvCell(study.Find(order.code)->group), ",", place + 1, ",",
                     CsvCell(order.exercises[place]), "\n");
    }
  }
  return csv;
}

std::string EmptyAnswersCsv(const Study& study) {
  std::string csv = "code,questionnaire,item,answer\n";
  for (const Participant& person : study.participants) {
    if (!person.consent) continue;
    for (const Questionnaire& questionnaire : study.questionnaires) {
      for (const QuestionItem& item : questionnaire.items) {
        csv += person.code + "," + questionnaire.key + "," + item.key + ",\n";
      }
    }
  }
  return csv;
}

}  // namespace acus::study
