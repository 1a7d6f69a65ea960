// The verdict on a suite, as pages and as JSON.
#pragma once

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

}  // namespace acus::regression
