#include "acus/run/entry/presets.h"

#include <filesystem>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::entry {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

/// A folder of presets that ends with its test.
class PresetFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "needles");
    fs::create_directories(folder_ / "schema");
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string SummaryOf(const std::string& text) {
    WriteTextFile(folder_ / "needles" / "a.json", text);
    return PresetsOf(folder_, "needles").at(0).summary;
  }

  fs::path folder_;
};

TEST_F(PresetFolder, HasItsKindsWithoutTheSchemas) {
  EXPECT_THAT(PresetKinds(folder_), ElementsAre("needles"));
}

TEST_F(PresetFolder, SaysWhatEachPresetIs) {
  EXPECT_EQ(SummaryOf(R"({"description": "thin", "name": "A"})"), "thin");
  EXPECT_EQ(SummaryOf(R"({"name": "A"})"), "A");
  EXPECT_EQ(SummaryOf("// Of 0.7 mm, and\n// long. Not more.\n{\"x\": 1}"), "Of 0.7 mm, and long");
  EXPECT_EQ(SummaryOf("{\n  // Inside.\n  \"x\": 1}"), "Inside");
  EXPECT_EQ(SummaryOf("{\"x\": 1}"), "");
  EXPECT_EQ(SummaryOf("{\"x\": "), "") << "a broken file is listed, too";
}

TEST_F(PresetFolder, RefusesKindsThatAreNotThere) {
  EXPECT_THAT([this] { PresetsOf(folder_, "needels"); },
              ThrowsMessage<InputError>(HasSubstr("Did you mean needles?")));
  EXPECT_THAT([this] { PresetsOf(folder_, "../needles"); },
              ThrowsMessage<InputError>(HasSubstr("kinds: needles")));
  EXPECT_THAT([] { PresetKinds("/nowhere"); },
              ThrowsMessage<InputError>(HasSubstr("ACUS_CONFIGS")));
}

TEST(Presets, OfAcusAllSayWhatTheyAre) {
  const fs::path configs = fs::path(ACUS_SOURCE_DIR) / "configs";
  for (const std::string& kind : PresetKinds(configs)) {
    EXPECT_THAT(PresetsOf(configs, kind), Not(Contains(Field(&Preset::summary, "")))) << kind;
  }
}

}  // namespace
}  // namespace acus::entry
