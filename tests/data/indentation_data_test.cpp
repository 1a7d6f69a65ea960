// Meat that was pressed in and held (perineal_indentation): the shape of loading and relaxation,
// fitted to two specimens and checked on others.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <set>
#include <span>
#include <string>

#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/indentation_fit.h"
#include "support/shared_data.h"

namespace acus::fitting {
namespace {

namespace fs = std::filesystem;

/// Of the largest force: while loading at 1/4, 1/2 and 3/4 of the greatest depth; in the hold after
/// 0.5, 1, 2, 5 and 9 s.
constexpr int kNumMarks = 8;
constexpr const char* kMarkNames[kNumMarks] = {
    "1/4 of the depth", "1/2", "3/4", "0.5 s", "1 s", "2 s", "5 s", "9 s"};

std::vector<double> MarksOf(const IndentationTest& test, std::span<const double> force) {
  const double deepest_mm = std::ranges::max(test.depth_mm);
  const double largest = *std::ranges::max_element(force);
  std::size_t hold = 0;
  while (test.depth_mm[hold] < deepest_mm - 0.02) ++hold;
  std::vector<double> marks;
  for (const double share : {0.25, 0.5, 0.75}) {
    const double at_mm = share * deepest_mm;
    std::size_t i = 1;
    while (test.depth_mm[i] < at_mm) ++i;
    const double along = (at_mm - test.depth_mm[i - 1]) / (test.depth_mm[i] - test.depth_mm[i - 1]);
    marks.push_back((force[i - 1] + along * (force[i] - force[i - 1])) / largest);
  }
  for (const double held_s : {0.5, 1.0, 2.0, 5.0, 9.0}) {
    std::size_t i = hold;
    while (i + 1 < force.size() && test.time_s[i] < test.time_s[hold] + held_s) ++i;
    marks.push_back(force[i] / largest);
  }
  return marks;
}

/// "FF2" of FF2_1A, "230403-RDG1" of 230403-RDG1f.
std::string SpecimenOf(const std::string& name) {
  return name.substr(0, name.find_first_of("12", name.find_first_of("FfR")) + 1);
}

/// Standard deviation of repeats about the mean of their specimen.
double ScatterOfRepeats(const std::vector<std::string>& specimen,
                        const std::vector<double>& values) {
  double squares = 0.0;
  double freedoms = 0.0;
  for (const std::string& name : std::set<std::string>(specimen.begin(), specimen.end())) {
    std::vector<double> repeats;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (specimen[i] == name) repeats.push_back(values[i]);
    }
    const double mean = math::Mean(repeats);
    for (const double v : repeats) squares += (v - mean) * (v - mean);
    freedoms += static_cast<double>(repeats.size()) - 1.0;
  }
  return std::sqrt(squares / freedoms);
}

struct Meat {
  std::vector<IndentationTest> fitted;  ///< FF1 and RDG1 of the first day.
  std::vector<IndentationTest> others;  ///< All other specimens, and the second day.
};

Meat ReadMeat(const fs::path& root) {
  Meat meat;
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    const bool is_fitted = name.starts_with("FF1_") || name.starts_with("RDG1_");
    (is_fitted ? meat.fitted : meat.others).push_back(ReadIndentationTest(file));
  }
  return meat;
}

TEST(IndentedMeat, TheShapeOfTwoSpecimensIsThatOfOthersWithinTheirScatter) {
  const auto root = testing_support::SharedData("mechanics/indentation_meat");
  if (!root) GTEST_SKIP() << "test data mechanics/indentation_meat is not here";
  const Meat meat = ReadMeat(*root);
  ASSERT_EQ(meat.fitted.size(), 24u);
  ASSERT_GT(meat.others.size(), 40u);
  std::vector<IndentationFit> fits;
  std::vector<double> own;
  for (const IndentationTest& test : meat.fitted) {
    fits.push_back(FitIndentation(test));
    ASSERT_TRUE(fits.back().converged) << test.name << ": " << fits.back().message;
    own.push_back(fits.back().relative_rms);
  }
  const IndentationShape shape = FitSharedShape(meat.fitted, fits);
  std::printf("  %s", std::string(NameOf(shape.law)).c_str());
  for (const double p : shape.parameters) std::printf(" %.3f", p);
  for (int k = 0; k < shape.relaxation.num_terms; ++k) {
    std::printf(", %.3f with %.2f s", shape.relaxation.share[k], shape.relaxation.time_s[k]);
  }
  std::printf("; own fits leave %.4f (median), at most %.4f\n", math::Median(own),
              std::ranges::max(own));
  std::vector<std::vector<double>> measured(kNumMarks);
  std::vector<std::vector<double>> off(kNumMarks);
  std::vector<double> rms;
  std::vector<std::string> specimen;
  for (const IndentationTest& test : meat.others) {
    const IndentationFit fit = FitWithShape(test, shape);
    ASSERT_TRUE(fit.converged) << test.name;
    const std::vector<double> replayed = ReplayIndentation(shape, test, fit.contact_mm.value);
    const std::vector<double> found = MarksOf(test, test.force_n);
    const std::vector<double> foretold = MarksOf(test, replayed);
    for (int m = 0; m < kNumMarks; ++m) {
      measured[m].push_back(found[m]);
      off[m].push_back(foretold[m] - found[m]);
    }
    rms.push_back(fit.relative_rms);
    specimen.push_back(SpecimenOf(test.name));
  }
  std::printf("  %zu others: %.4f of the largest force (median RMS), at most %.4f\n", rms.size(),
              math::Median(rms), std::ranges::max(rms));
  for (int m = 0; m < kNumMarks; ++m) {
    const double scatter = ScatterOfRepeats(specimen, measured[m]);
    const double bias = math::Mean(off[m]);
    const auto within =
        std::ranges::count_if(off[m], [&](double o) { return std::abs(o) < 2.0 * scatter; });
    const double share = static_cast<double>(within) / static_cast<double>(off[m].size());
    std::printf("| %s | %.3f | %.3f | %+.3f | %.0f |\n", kMarkNames[m], math::Mean(measured[m]),
                scatter, bias, 100.0 * share);
    EXPECT_LT(std::abs(bias), scatter) << kMarkNames[m];
    EXPECT_GE(share, 0.85) << kMarkNames[m];  // 0.95 of repeats about their own mean.
  }
}

}  // namespace
}  // namespace acus::fitting
