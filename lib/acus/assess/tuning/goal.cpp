#include "acus/assess/tuning/goal.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::tuning {
namespace {

/// The unit of a number, and its factor to the goal's unit.
struct Unit {
  std::string name;
  double factor;
};

struct Part {
  std::string name;
  std::vector<Unit> units;
  double least;  ///< In the goal's unit, as is `most`.
  double most;
};

struct Grammar {
  std::string option;
  std::string example;
  std::vector<Part> parts;
};

const Grammar& BudgetGrammar() {
  static const Grammar grammar = {"--budget",
                                  "force=0.5ms,image=16ms",
                                  {{"force", {{"us", 1.0}, {"ms", 1e3}, {"s", 1e6}}, 1e-3, 1e9},
                                   {"image", {{"us", 1e-3}, {"ms", 1.0}, {"s", 1e3}}, 1e-6, 1e6}}};
  return grammar;
}

const Grammar& AccuracyGrammar() {
  static const Grammar grammar = {
      "--accuracy",
      "force=0.02N,image=35dB",
      {{"force", {{"N", 1.0}, {"mN", 1e-3}}, 1e-12, 1e6}, {"image", {{"dB", 1.0}}, 1e-3, 200.0}}};
  return grammar;
}

std::string UnitsText(const Part& part) {
  std::string text;
  for (const Unit& unit : part.units) {
    if (!text.empty()) text += &unit == &part.units.back() ? " or " : ", ";
    text += unit.name;
  }
  return text;
}

[[noreturn]] void Refuse(const Grammar& grammar, const std::string& text, const std::string& why) {
  std::string parts;
  for (const Part& part : grammar.parts) {
    if (!parts.empty()) parts += ", ";
    parts += part.name + "=NUMBER with the unit " + UnitsText(part);
  }
  throw InputError(Message(grammar.option, " ", text, ": ", why, "; allowed: ", parts,
                           ", one or both, such as ", grammar.option, " ", grammar.example));
}

/// "0.5ms", converted to the unit of the goal.
double ValueOf(const Grammar& grammar, const std::string& text, const Part& part,
               const std::string& value) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc()) {
    Refuse(grammar, text, Message("'", value, "' of ", part.name, " does not begin with a number"));
  }
  const std::string unit(end, value.data() + value.size());
  for (const Unit& known : part.units) {
    if (unit != known.name) continue;
    const double scaled = number * known.factor;
    if (!(scaled >= part.least && scaled <= part.most)) {
      Refuse(grammar, text,
             Message("'", value, "' of ", part.name, " must be from ", part.least / known.factor,
                     known.name, " to ", part.most / known.factor, known.name));
    }
    return scaled;
  }
  if (unit.empty()) {
    Refuse(grammar, text, Message("'", value, "' of ", part.name, " has no unit"));
  }
  Refuse(grammar, text, Message("'", unit, "' is no unit of ", part.name));
}

Goal Parse(const Grammar& grammar, GoalKind kind, const std::string& text) {
  Goal goal{.kind = kind};
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string item = text.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t equals = item.find('=');
    if (equals == item.npos) Refuse(grammar, text, Message("'", item, "' has no '='"));
    const std::string name = item.substr(0, equals);
    const Part* part = nullptr;
    for (const Part& known : grammar.parts) {
      if (known.name == name) part = &known;
    }
    if (part == nullptr) Refuse(grammar, text, Message("'", name, "' is no part of a simulation"));
    std::optional<double>& limit = name == "force" ? goal.force : goal.image;
    if (limit) Refuse(grammar, text, Message(name, " is named twice"));
    limit = ValueOf(grammar, text, *part, item.substr(equals + 1));
  }
  return goal;
}

}  // namespace

Goal ParseBudget(const std::string& text) {
  return Parse(BudgetGrammar(), GoalKind::kBudget, text);
}

Goal ParseAccuracy(const std::string& text) {
  return Parse(AccuracyGrammar(), GoalKind::kAccuracy, text);
}

double ParseForceAccuracyN(const std::string& text) {
  const Goal goal = ParseAccuracy(text);
  ACUS_REQUIRE(
      goal.force && !goal.image, "--accuracy ", text,
      ": the sweep of one model measures errors of forces only; allowed: force=NUMBER with "
      "the unit N or mN, such as --accuracy force=0.05N");
  return *goal.force;
}

Goal LiveBudget(double force_rate_hz, double image_rate_hz) {
  ACUS_ASSERT(force_rate_hz > 0.0 && image_rate_hz > 0.0);
  return {.kind = GoalKind::kBudget, .force = 1e6 / force_rate_hz, .image = 1e3 / image_rate_hz};
}

std::string TextOf(const Goal& goal) {
  const bool budget = goal.kind == GoalKind::kBudget;
  std::string text;
  if (goal.force) {
    text =
        budget ? Message("force=", 1e-3 * *goal.force, "ms") : Message("force=", *goal.force, "N");
  }
  if (goal.image) {
    if (!text.empty()) text += ",";
    text += Message("image=", *goal.image, budget ? "ms" : "dB");
  }
  return text;
}

}  // namespace acus::tuning
