#include "acus/assess/regression/comparison/check.h"

#include <utility>

namespace acus::comparison {

Check AtMost(std::string quantity, std::string unit, double value, double limit,
             std::string remark) {
  Check check;
  check.quantity = std::move(quantity);
  check.unit = std::move(unit);
  check.value = value;
  check.limit = limit;
  check.passed = value <= limit;
  check.remark = std::move(remark);
  return check;
}

Check Verdict(std::string quantity, bool passed, std::string remark) {
  Check check;
  check.quantity = std::move(quantity);
  check.passed = passed;
  check.remark = std::move(remark);
  return check;
}

Check OnlyInOne(std::string quantity, std::string remark) {
  Check check = Verdict(std::move(quantity), false, std::move(remark));
  check.only_in_one = true;
  return check;
}

}  // namespace acus::comparison
