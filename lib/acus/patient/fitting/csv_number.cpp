#include "acus/patient/fitting/csv_number.h"

#include <cmath>
#include <cstdlib>

#include "acus/base/core/error.h"

namespace acus::fitting {

double NumberAt(const std::string& cell, const std::string& where, const char* what) {
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  const bool is_number =
      end != cell.c_str() &&
      cell.find_first_not_of(" \r\t", static_cast<std::size_t>(end - cell.c_str())) == cell.npos;
  ACUS_REQUIRE(is_number && std::isfinite(value) && std::abs(value) < 1e6, where, ": ", what,
               " is '", cell, "'; a finite number is needed");
  return value;
}

}  // namespace acus::fitting
