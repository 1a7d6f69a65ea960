#include "acus/imaging/volume_rendering/transfer_file.h"

#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "support/temporary_folder.h"

namespace acus::volume_rendering {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class TransferFiles : public ::testing::Test {
 protected:
  fs::path Written(const std::string& nodes, const std::string& more = "") {
    const fs::path path = folder_.path() / "mine.json";
    std::ofstream(path) << R"({"format": "acus-transfer-function/1", "name": "Mine", "nodes": [)"
                        << nodes << "]" << more << "}";
    return path;
  }
  testing_support::TemporaryFolder folder_;
};

TEST_F(TransferFiles, GiveTheirNodesAndTissues) {
  const TransferFile file = ReadTransferFunction(
      Written(R"({"hu": -20, "extinction_per_mm": 0.5, "colour": [0.1, 0.2, 0.3]},
                 {"hu": 80, "extinction_per_mm": 0, "colour": [1, 1, 1]})",
              R"(, "tissues": ["liver", "vessel"])"));
  EXPECT_EQ(file.name, "Mine");
  ASSERT_EQ(file.nodes.size(), 2U);
  EXPECT_EQ(file.nodes[0].hu, -20.0);
  EXPECT_EQ(file.nodes[0].extinction_per_mm, 0.5);
  EXPECT_EQ(file.nodes[0].colour[2], 0.3F);
  EXPECT_THAT(file.tissues, ElementsAre(volume::LabelOf("liver"), volume::LabelOf("vessel")));
}

TEST_F(TransferFiles, AreFoundByNameOrPath) {
  const fs::path mine = Written(R"({"hu": 0, "extinction_per_mm": 1, "colour": [1, 1, 1]},
                                   {"hu": 1, "extinction_per_mm": 1, "colour": [1, 1, 1]})");
  EXPECT_EQ(FindTransferFunction("bone", {}).filename(), "bone.json");
  EXPECT_TRUE(fs::equivalent(FindTransferFunction("mine.json", folder_.path()), mine));
  EXPECT_TRUE(fs::equivalent(FindTransferFunction(mine.string(), {}), mine));
  EXPECT_THAT([] { FindTransferFunction("fog", {}); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("\"fog\""), HasSubstr("bone, liver, muscle, skin"))));
  EXPECT_THAT([] { FindTransferFunction("", {}); }, ThrowsMessage<InputError>(HasSubstr("bone")));
  EXPECT_THAT([this] { FindTransferFunction("none.json", folder_.path()); },
              ThrowsMessage<InputError>(HasSubstr("none.json")));
}

TEST_F(TransferFiles, AreRefusedWithTheirPlace) {
  const std::string white = R"("colour": [1, 1, 1]})";
  const std::string low = R"({"hu": 0, "extinction_per_mm": 1, )" + white;
  const auto reads = [this](const std::string& nodes, const std::string& more = "") {
    return [this, nodes, more] { ReadTransferFunction(Written(nodes, more)); };
  };
  EXPECT_THAT(reads(low), ThrowsMessage<InputError>(HasSubstr("/nodes")));
  EXPECT_THAT(reads(low + "," + low),
              ThrowsMessage<InputError>(AllOf(HasSubstr("mine.json"), HasSubstr("node 1"))));
  EXPECT_THAT(reads(low + R"(, {"hu": 9, "extinction_per_mm": -1, )" + white),
              ThrowsMessage<InputError>(HasSubstr("/nodes/1/extinction_per_mm")));
  EXPECT_THAT(reads(low + R"(, {"hu": 9000, "extinction_per_mm": 1, )" + white),
              ThrowsMessage<InputError>(HasSubstr("/nodes/1/hu")));
  EXPECT_THAT(reads(low + R"(, {"hu": 9, "extinction_per_mm": 1, "colour": [1, 2, 1]})"),
              ThrowsMessage<InputError>(HasSubstr("/nodes/1/colour/1")));
  EXPECT_THAT(
      reads(low + R"(, {"hu": 9, "extinction_per_mm": 1, )" + white, R"(, "tissues": ["livr"])"),
      ThrowsMessage<InputError>(AllOf(HasSubstr("mine.json: /tissues"), HasSubstr("'liver'"))));
}

TEST(TransferFilePresets, AllOfThemAreRead) {
  int read = 0;
  for (const auto& file : fs::directory_iterator(config::ConfigsFolder() / "transfer_functions")) {
    EXPECT_GE(ReadTransferFunction(file.path()).nodes.size(), 2U) << file.path();
    ++read;
  }
  EXPECT_GE(read, 6);
}

}  // namespace
}  // namespace acus::volume_rendering
