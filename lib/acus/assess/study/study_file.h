// The file of a study: participants, exercises, order and analysis.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace acus::study {

struct Participant {
  std::string code;
  std::string group;
  bool consent = false;
  std::string hand;  ///< The hand that holds the needle: right or left.
};

struct QuestionItem {
  std::string key;
  std::string text;
  bool reversed = false;  ///< Counted from the other end of the scale.
};

struct Questionnaire {
  std::string key;
  std::string title;
  std::vector<std::string> scale;  ///< Words of the answers 1, 2, ...
  std::vector<QuestionItem> items;
};

enum class OrderKind { kRandom, kBalanced, kFixed };

struct AnalysisSettings {
  double confidence = 0.95;
  int bootstrap_draws = 2000;
  double separating_auc = 0.95;
  double power = 0.8;
  double alpha = 0.05;
};

struct Study {
  std::filesystem::path file;
  std::string name;
  std::vector<std::string> groups;
  std::vector<Participant> participants;
  std::vector<std::string> exercises;  ///< Names of the exercises, as in training.json.
  std::vector<std::filesystem::path> exercise_files;
  int trials = 3;
  OrderKind order = OrderKind::kRandom;
  std::uint64_t seed = 0;
  std::vector<Questionnaire> questionnaires;
  AnalysisSettings analysis;

  /// Null if no participant has this code.
  const Participant* Find(const std::string& code) const;
};

/// Reads an acus-study file and the exercises and questionnaires that it names.
/// @throws InputError listing all problems: keys, ranges, a code twice, a group that is not listed,
///     two exercises of one name.
Study ReadStudy(const std::filesystem::path& path);

/// Exercises in the order in which a participant does them.
struct PlannedOrder {
  std::string code;
  std::vector<std::string> exercises;
};

/// The order for every participant, by Study::order; depends on the seed only. Balanced: within
/// each group, participants in random order take the rows of a cyclic Latin square in order.
std::vector<PlannedOrder> PlanOrder(const Study& study);

/// order.csv: code,group,place,exercise; a row per exercise of each participant.
std::string OrderCsv(const Study& study);

/// answers.csv to fill in: code,questionnaire,item,answer; the answers are empty.
std::string EmptyAnswersCsv(const Study& study);

}  // namespace acus::study
