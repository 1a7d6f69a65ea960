// Hard cases with their bounds: a test says what is hard, and states each value that it measured
// next to its bound. With ACUS_BOUNDS=FOLDER all that is stated is also kept, for the page of
// developer/stability.
//
//   const HardCase hard("A million changes of contact, each of which could add round-off.");
//   Largest error_n;
//   for (...) error_n.Add(...);
//   hard.Expect("force against a fresh solve", error_n, AtMost(1e-9), "N");
#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <source_location>
#include <string>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::testing_support {

/// What a measured value is held to. None holds for what is not a number.
struct Bound {
  enum class Sense { kBelow, kAtMost, kAbove, kAtLeast, kExactly };

  Sense sense = Sense::kAtMost;
  double value = 0.0;

  bool Holds(double measured) const {
    switch (sense) {
      case Sense::kBelow:
        return measured < value;
      case Sense::kAtMost:
        return measured <= value;
      case Sense::kAbove:
        return measured > value;
      case Sense::kAtLeast:
        return measured >= value;
      case Sense::kExactly:
        return measured == value;
    }
    return false;
  }
  const char* Sign() const {
    constexpr const char* kSigns[] = {"<", "<=", ">", ">=", "=="};
    return kSigns[static_cast<int>(sense)];
  }
};

inline Bound Below(double value) {
  return {Bound::Sense::kBelow, value};
}
inline Bound AtMost(double value) {
  return {Bound::Sense::kAtMost, value};
}
inline Bound Above(double value) {
  return {Bound::Sense::kAbove, value};
}
inline Bound AtLeast(double value) {
  return {Bound::Sense::kAtLeast, value};
}
inline Bound Exactly(double value) {
  return {Bound::Sense::kExactly, value};
}

/// Largest of the values added (0 before); no number from the first on that is none.
class Largest {
 public:
  void Add(double value) {
    if (std::isnan(value_) || value <= value_) return;
    value_ = value;
  }
  operator double() const { return value_; }  // NOLINT: it stands for its value.

 private:
  double value_ = 0.0;
};

/// Smallest of the values added (infinite before); no number from the first on that is none.
class Smallest {
 public:
  void Add(double value) {
    if (std::isnan(value_) || value >= value_) return;
    value_ = value;
  }
  operator double() const { return value_; }  // NOLINT: it stands for its value.

 private:
  double value_ = HUGE_VAL;
};

/// Curves for the page, where an image says more than a number.
struct BoundPlot {
  struct Curve {
    std::string name = {};
    std::vector<double> x = {};
    std::vector<double> y = {};

    void Add(double at_x, double at_y) {
      x.push_back(at_x);
      y.push_back(at_y);
    }
  };

  std::string title = {};
  std::string x_label = {};  ///< With the unit: "depth [mm]".
  std::string y_label = {};
  bool log_x = false;
  bool log_y = false;
  std::vector<Curve> curves = {};
};

/// A hard case of the test that runs. One per test; made where the test begins.
class HardCase {
 public:
  /// @param what_is_hard  One sentence, for somebody who does not know the code.
  explicit HardCase(std::string what_is_hard,
                    std::source_location where = std::source_location::current())
      : what_is_hard_(std::move(what_is_hard)), file_(FileBelowRoot(where.file_name())) {}

  /// Fails the test, and goes on, if `measured` is not within `bound` or not a number.
  /// @param quantity  What was measured, and at which setting: it names the row of the page.
  /// @param unit      "" for a count or a share.
  template <typename Value>
  void Expect(const std::string& quantity, const Value& measured, Bound bound,
              const std::string& unit = "",
              std::source_location where = std::source_location::current()) const {
    ExpectNumber(quantity, static_cast<double>(measured), bound, unit, where);
  }

  /// An image beside the values.
  void Plot(const BoundPlot& plot) const {
    nlohmann::json curves = nlohmann::json::array();
    for (const BoundPlot::Curve& curve : plot.curves) {
      curves.push_back({{"name", curve.name}, {"x", curve.x}, {"y", curve.y}});
    }
    Keep({{"kind", "plot"},
          {"title", plot.title},
          {"x_label", plot.x_label},
          {"y_label", plot.y_label},
          {"log_x", plot.log_x},
          {"log_y", plot.log_y},
          {"curves", curves}});
  }

  /// What the reader should know beside the values: how many were run, from which seed.
  void Note(const std::string& name, const std::string& value) const {
    Keep({{"kind", "note"}, {"name", name}, {"value", value}});
  }

 private:
  void ExpectNumber(const std::string& quantity, double measured, Bound bound,
                    const std::string& unit, const std::source_location& where) const {
    const bool holds =
        std::isfinite(measured) && std::isfinite(bound.value) && bound.Holds(measured);
    Keep({{"kind", "bound"},
          {"quantity", quantity},
          {"unit", unit},
          {"sense", bound.Sign()},
          {"bound", bound.value},
          {"measured", measured},
          {"holds", holds}});
    if (holds) return;
    ADD_FAILURE_AT(where.file_name(), static_cast<int>(where.line()))
        << quantity << ": " << measured << " " << unit << " is not " << bound.Sign() << " "
        << bound.value << " " << unit << "\n"
        << what_is_hard_;
  }

  static std::string FileBelowRoot(const std::string& file) {
    const auto tests = file.rfind("/tests/");
    return tests == std::string::npos ? file : file.substr(tests + 1);
  }

  /// "needle" of tests/stability/needle_rod_test.cpp and of tests/unit/physics/needle/rod_test.cpp.
  std::string Module() const {
    const std::filesystem::path path(file_);
    const std::string folder = path.parent_path().filename().string();
    if (folder != "stability") return folder;
    const std::string name = path.stem().string();
    return name.substr(0, name.find('_'));
  }

  /// One line, in one write: tests run side by side.
  void Keep(nlohmann::json record) const {
    const char* folder = std::getenv("ACUS_BOUNDS");
    if (folder == nullptr || *folder == '\0') return;
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    record["module"] = Module();
    record["file"] = file_;
    record["hard"] = what_is_hard_;
    record["suite"] = test == nullptr ? "" : test->test_suite_name();
    record["test"] = test == nullptr ? "" : test->name();
    std::filesystem::create_directories(folder);
    std::ofstream out(std::filesystem::path(folder) / (Module() + ".jsonl"),
                      std::ios::app | std::ios::binary);
    const std::string line = record.dump() + "\n";
    out.write(line.data(), static_cast<std::streamsize>(line.size()));
    if (!out.flush()) ADD_FAILURE() << "cannot keep the bounds in " << folder;
  }

  std::string what_is_hard_;
  std::string file_;
};

}  // namespace acus::testing_support
