// The verdict on a suite, for people and for programs.
#pragma once

#include <string>

#include "acus/assess/regression/regression.h"

namespace acus::regression {

/// One line per case: verdict, how many checks failed, the first of them, time against expected.
std::string TextOf(const SuiteResult& result);

/// Writes into an existing folder: regression.html (the cases, and for each that moved what moved
/// by how much, forces over each other, the worst image), regression.json (acus-regression-result
/// /1), provenance.json, and for each case that was compared its folder <name>/comparison.
void WriteResult(const std::filesystem::path& folder, const SuiteResult& result,
                 const RunContext& context);

}  // namespace acus::regression
