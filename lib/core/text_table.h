// Tables on a terminal.
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

}  // namespace acus
