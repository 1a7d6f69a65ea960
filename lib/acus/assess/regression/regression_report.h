// The verdict on a suite, as pages and as JSON.
#pragma once

#include <filesystem>
#include <string>

#include "acus/assess/regression/regression.h"

namespace acus::regression {

/// One line per case: verdict, number of failed checks, the first of them, time relative to
/// expected.
std::string TextOf(const SuiteResult& result);

/// Writes into an existing folder: regression.html (the cases, and for each changed case its
/// differences, forces overlaid, the worst image), regression.json (acus-regression-result/1),
/// provenance.json, and for each compared case its folder <name>/comparison.
void WriteResult(const std::filesystem::path& folder, const SuiteResult& result,
                 const RunContext& context);

/// The same for servers that run tests: JUnit XML, a test case for each case. What moved and what
/// is new is a failure, what has no result an error. Whole or not at all.
void WriteJUnit(const std::filesystem::path& file, const SuiteResult& result);

/// What to do about a result that is not as expected.
std::string AdviceText(const SuiteResult& result);

}  // namespace acus::regression
