#include "acus/physics/mechanics/condensation/compliance_file.h"

#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/physics/mechanics/condensation/compliance_layout.h"
#include "support/condensed_box.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::mechanics {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using testing_support::CondensedBox;
using testing_support::TemporaryFolder;

constexpr ElementKind kElement = ElementKind::kLinear;

class ComplianceFile : public ::testing::Test {
 protected:
  ComplianceFileCost Write(Storage storage = Storage::kFloat, bool has_image = true) {
    Condensation condensation = box_.Condense();
    return WriteCompliance(path_, condensation, KeyOf(box_.mesh, box_.elasticity, kElement),
                           box_.mesh.nodes_mm.cols(), has_image ? box_.visible : std::vector<int>{},
                           storage, RunContext{});
  }
  CondensedTissue Open(ComplianceCheck check = ComplianceCheck::kEverything) {
    return OpenCompliance(path_, box_.mesh, box_.elasticity, kElement, check);
  }
  /// Writes the file with `bytes` at a place of it.
  template <class T>
  void Overwrite(std::size_t at, T value) {
    std::string text = ReadTextFile(path_);
    std::memcpy(text.data() + at, &value, sizeof value);
    WriteTextFile(path_, text);
  }
  void ExpectRefused(const std::string& why, ComplianceCheck check = ComplianceCheck::kEverything) {
    EXPECT_THAT([&] { Open(check); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("compliance.acc: "), HasSubstr(why),
                                                HasSubstr("acus-mesh --mesh"))));
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "compliance.acc";
  CondensedBox box_;
};

TEST_F(ComplianceFile, GivesBackWhatWasCondensed) {
  const Condensation condensation = box_.Condense();
  for (const Storage storage : {Storage::kFloat, Storage::kDouble}) {
    Write(storage);
    const CondensedTissue tissue = Open();
    const Compliance exact = condensation.Compliance(storage);
    EXPECT_EQ(tissue.compliance.storage(), storage);
    ASSERT_TRUE(std::ranges::equal(tissue.compliance.nodes(), box_.reachable));
    for (int i = 0; i < 3 * exact.num_nodes(); ++i) {
      for (int j = 0; j < 3 * exact.num_nodes(); ++j) {
        ASSERT_EQ(tissue.compliance.At(i, j), exact.At(i, j));
      }
    }
  }
}

TEST_F(ComplianceFile, GivesBackTheImageBlock) {
  Condensation condensation = box_.Condense();
  condensation.SetVisible(box_.visible);
  const int size = 3 * static_cast<int>(box_.reachable.size());
  Eigen::MatrixXf exact(3 * box_.visible.size(), size);
  condensation.ImageColumns(0, size, exact.data());
  Write();
  const CondensedTissue tissue = Open();
  ASSERT_TRUE(std::ranges::equal(tissue.image.nodes(), box_.visible));
  for (int j = 0; j < size; ++j) {
    const Eigen::Map<const Eigen::VectorXf> got(tissue.image.Column(j), exact.rows());
    ASSERT_LT((got - exact.col(j)).norm(), 1e-6f * exact.col(j).norm());
  }
}

TEST_F(ComplianceFile, NeedsNoImageBlock) {
  const ComplianceFileCost cost = Write(Storage::kFloat, false);
  EXPECT_EQ(cost.image_mib, 0.0);
  EXPECT_EQ(Open().image.num_nodes(), 0);
  const auto n = static_cast<double>(box_.reachable.size());
  EXPECT_NEAR(cost.compliance_mib, 9 * n * n * 4 / 1024 / 1024, 1e-9);
  EXPECT_LT(std::filesystem::file_size(path_), 9 * n * n * 4 + 3 * 4096);
}

TEST_F(ComplianceFile, StaysMappedWhileEitherPartIsInUse) {
  Write();
  CondensedTissue tissue = Open();
  const double first = tissue.compliance.At(0, 0);
  Compliance kept = tissue.compliance;
  tissue = {};
  std::filesystem::remove(path_);
  EXPECT_EQ(kept.At(0, 0), first);
}

TEST_F(ComplianceFile, TheSameIsWrittenToTheBit) {
  const std::string key = Write().key;
  const std::string bytes = ReadTextFile(path_);
  EXPECT_EQ(Write().key, key);
  EXPECT_EQ(ReadTextFile(path_), bytes);
  EXPECT_NE(Write(Storage::kDouble).key, key);
}

TEST_F(ComplianceFile, MissingOrOtherFilesAreDistinguishedFromOurs) {
  ExpectRefused("there is no such file");
  WriteTextFile(path_, "");
  ExpectRefused("is empty");
  WriteTextFile(path_, "<VTKFile type=\"UnstructuredGrid\">");
  ExpectRefused("is not a compliance file");
  std::filesystem::remove(path_);
  std::filesystem::create_directory(path_);
  EXPECT_THAT([&] { Open(); }, ThrowsMessage<InputError>(HasSubstr("is a folder")));
}

TEST_F(ComplianceFile, ForAnotherMeshSaysSo) {
  Write();
  box_.mesh.nodes_mm(0, 100) += 1e-9;
  ExpectRefused("another mesh, of 729 nodes; the mesh in use has 729 but differs");
  box_.mesh = testing_support::BoxMesh({3, 3, 3}, {0, 0, 0}, {1, 1, 1});
  ExpectRefused("another mesh, of 729 nodes; the mesh in use has 64;");
}

TEST_F(ComplianceFile, TissuesAndFixedNodesBelongToTheMesh) {
  Write();
  box_.mesh.fixed_nodes[500] = 1;
  ExpectRefused("another mesh");
  box_.mesh.fixed_nodes[500] = 0;
  Open();
  box_.elasticity.tissue[3] = {0.01, 0.4};
  box_.elasticity.named.set(3);
  Open();  // A row that no element asks for changes nothing.
  box_.mesh.tissue[7] = 3;
  ExpectRefused("another mesh");
}

TEST_F(ComplianceFile, CannotBelongToAMeshWithoutTissues) {
  Write();
  box_.mesh.tissue.clear();
  EXPECT_THAT([&] { Open(); }, ThrowsMessage<InputError>(HasSubstr("has no tissue ids")));
}

TEST_F(ComplianceFile, ForOtherElasticConstantsSaysSo) {
  Write();
  box_.elasticity.tissue[4].poissons_ratio = 0.46;
  ExpectRefused("other elastic constants");
}

TEST_F(ComplianceFile, FromAnotherVersionOrMachineSaysSo) {
  Write();
  Overwrite(offsetof(ComplianceHeader, version), std::uint32_t{7});
  ExpectRefused("has format version 7; this program reads version 1");
  Write();
  Overwrite(offsetof(ComplianceHeader, byte_order), kOtherByteOrder);
  ExpectRefused("the other byte order");
}

TEST_F(ComplianceFile, CutOffFilesAreRefusedAtAnyLength) {
  Write();
  const std::string whole = ReadTextFile(path_);
  for (const std::size_t size : {std::size_t{3}, std::size_t{8}, std::size_t{200},
                                 std::size_t{4096}, whole.size() / 2, whole.size() - 1}) {
    WriteTextFile(path_, whole.substr(0, size));
    EXPECT_THROW(Open(ComplianceCheck::kNothing), InputError) << size;
  }
  WriteTextFile(path_, whole + "x");
  ExpectRefused("cut off or joined", ComplianceCheck::kNothing);
}

TEST_F(ComplianceFile, EveryFlippedBitOfHeaderAndTablesIsSeenWithoutReadingTheRest) {
  Write();
  const std::string whole = ReadTextFile(path_);
  const ComplianceLayout layout(box_.reachable.size(), box_.visible.size(), 4);
  std::string damaged = whole;
  for (std::size_t at = 0; at < layout.compliance_at; at += at < 400 ? 1 : 37) {
    damaged[at] = static_cast<char>(whole[at] ^ (1 << (at % 8)));
    std::ofstream(path_, std::ios::binary) << damaged;
    EXPECT_THROW(Open(ComplianceCheck::kNothing), InputError) << at;
    damaged[at] = whole[at];
  }
}

TEST_F(ComplianceFile, FlippedBitsOfNumbersAreSeenByTheCheckThatCoversThem) {
  Write();
  const ComplianceLayout layout(box_.reachable.size(), box_.visible.size(), 4);
  const std::string whole = ReadTextFile(path_);
  Overwrite(layout.compliance_at + layout.compliance_bytes / 2, char{99});
  ExpectRefused("its numbers are damaged", ComplianceCheck::kCompliance);
  EXPECT_NO_THROW(Open(ComplianceCheck::kNothing));
  WriteTextFile(path_, whole);
  Overwrite(layout.image_at + layout.image_bytes - 1, char{99});
  EXPECT_NO_THROW(Open(ComplianceCheck::kCompliance));
  ExpectRefused("its numbers are damaged", ComplianceCheck::kEverything);
}

TEST_F(ComplianceFile, SurvivesDamageOfAnyKind) {
  Write();
  const int refused = testing_support::ReadDamagedCopies(ReadTextFile(path_), path_, 150, [&] {
    const CondensedTissue tissue = Open();
    // What is read can be used to its ends.
    const int last = 3 * tissue.compliance.num_nodes() - 1;
    EXPECT_TRUE(std::isfinite(tissue.compliance.At(last, last)));
  });
  EXPECT_GT(refused, 135);
}

TEST(Checksum, ReportsEveryChangeOfOneWordAndEveryLength) {
  const std::string zeros(100, '\0');
  std::set<std::uint64_t> sums;
  for (std::size_t size = 0; size <= zeros.size(); ++size) {
    EXPECT_TRUE(sums.insert(Checksum(zeros.data(), size)).second);
  }
  for (std::size_t at = 0; at < zeros.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string changed = zeros;
      changed[at] = static_cast<char>(1 << bit);
      EXPECT_TRUE(sums.insert(Checksum(changed.data(), changed.size())).second) << at;
    }
  }
}

TEST(ComplianceWriting, IntoNowhereIsAnErrorAndLeavesNothing) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "file", "x");
  const CondensedBox box;
  Condensation condensation = box.Condense();
  EXPECT_THROW(WriteCompliance(folder / "file/compliance.acc", condensation,
                               KeyOf(box.mesh, box.elasticity, kElement), box.mesh.nodes_mm.cols(),
                               {}, Storage::kFloat, RunContext{}),
               InputError);
  const std::atomic<bool> stop{true};
  RunContext context;
  context.stop = &stop;
  EXPECT_THROW(WriteCompliance(folder / "compliance.acc", condensation,
                               KeyOf(box.mesh, box.elasticity, kElement), box.mesh.nodes_mm.cols(),
                               {}, Storage::kFloat, context),
               Cancelled);
  EXPECT_FALSE(std::filesystem::exists(folder / "compliance.acc"));
}

}  // namespace
}  // namespace acus::mechanics
