// Tables on a terminal, and numbers for people.
#pragma once

#include <string>
#include <vector>

namespace acus {

/// Columns side by side, two spaces apart, under a ruled header; columns of numbers (and "-") flush
/// right, others flush left. Every line ends with '\n'. @pre every row is as long as the header.
std::string TextTable(const std::vector<std::string>& header,
                      const std::vector<std::vector<std::string>>& rows);

/// `value` with `decimals` digits after the point.
std::string FixedText(double value, int decimals);

/// `value` with at most `digits` significant digits, but all of those before the point: 1234 with
/// three digits is "1234", not "1.23e+03". Powers of ten only from 1e9 on and for the very small.
std::string RoundedText(double value, int digits);

}  // namespace acus
