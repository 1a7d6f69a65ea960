#include "benchmarks/machine.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace acus::benchmarks {
namespace {

TEST(Machine, IsDescribedWithoutNamesOfPlaces) {
  const nlohmann::json facts = MachineFacts();
  EXPECT_GE(facts.at("cores").get<int>(), 1);
  EXPECT_GT(facts.at("memory_gb").get<double>(), 0.0);
  for (const char* key : {"cpu", "system", "virtual", "compiler", "acus"}) {
    const std::string text = facts.at(key);
    EXPECT_FALSE(text.empty()) << key;
    EXPECT_EQ(text.find("/home"), text.npos) << text;
  }
}

}  // namespace
}  // namespace acus::benchmarks
