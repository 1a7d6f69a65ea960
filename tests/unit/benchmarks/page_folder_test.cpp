#include "benchmarks/page_folder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "benchmarks/machine.h"
#include "support/temporary_folder.h"

namespace acus::benchmarks {
namespace {

class PageFolder : public testing::Test {
 protected:
  PageFolder() {
    std::filesystem::create_directories(templates);
    std::filesystem::create_directories(data);
    WriteTextFile(data / "probe.csv",
                  "knob,value,model,error,error_unit,reference,step_us_median,step_us_p999,"
                  "preparation_s,memory_mb,is_default,is_paper,unusable\n"
                  "n,1,,0.5,N,,2,,,,0,0,\nn,2,,0.25,N,,4,,,,1,0,\n");
    WriteTextFile(templates / "one.template",
                  "See [that page](models/that.md#part), {{= [probe | n | 2 | error N]}} N.\n"
                  "{{require [probe | n | 1 | error N] < 0.4}}\n");
    WriteTextFile(templates / "notes.txt", "{{");
  }
  testing_support::TemporaryFolder folder;
  std::filesystem::path templates = folder.path() / "templates";
  std::filesystem::path data = folder.path() / "data";
};

TEST_F(PageFolder, ElsewhereLinksToNothing) {
  const auto files = MakePages(templates, data, Claims::kAreMarked);
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files.at("one.md"), "See that page, 0.25 N.\n **(not so in this run: 0.5 < 0.4)** \n");
}

TEST_F(PageFolder, NamesTheTemplateThatIsWrong) {
  try {
    MakePages(templates, data, Claims::kMustHold);
    FAIL() << "a claim does not hold";
  } catch (const InputError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("one.template:\nline 2: ")) << error.what();
  }
  std::filesystem::remove(templates / "one.template");
  EXPECT_THROW(MakePages(templates, data, Claims::kMustHold), InputError);
  EXPECT_THROW(MakePages(data / "nowhere", data, Claims::kMustHold), InputError);
}

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
