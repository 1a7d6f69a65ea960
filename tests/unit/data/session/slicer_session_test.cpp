#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/random.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/session_import.h"
#include "acus/data/session/slicer_scene.h"
#include "acus/data/session/zip_archive.h"
#include "acus/data/transforms/itk_transform_file.h"
#include "acus/data/transforms/transform_file.h"
#include "support/fuzz.h"
#include "support/slicer_files.h"
#include "support/temporary_folder.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::ItkTransformFile;
using testing_support::ZipFile;

std::vector<std::uint8_t> Bytes(const std::string& text) {
  return {text.begin(), text.end()};
}

Eigen::Isometry3d SlicerSessionRandomPose(std::uint64_t index) {
  RandomStream random(23, "slicer", index);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(random.Normal(), random.Normal(), random.Normal(), 1.0)
                      .normalized()
                      .toRotationMatrix();
  pose.translation() << 50.0 * random.Normal(), 50.0 * random.Normal(), 50.0 * random.Normal();
  return pose;
}

/// How ITK stores what Slicer shows as "to parent": in LPS, and the other way round.
Eigen::Matrix4d StoredByItk(const Eigen::Isometry3d& ras_to_parent) {
  return math::RasFromLps(ras_to_parent).inverse().matrix();
}

/// A recording of two needle poses and one fixed transform, as Slicer saves it.
class SlicerSession : public testing::Test {
 protected:
  void SetUp() override {
    files_["Tip.h5"] =
        ItkTransformFile(StoredByItk(SlicerSessionRandomPose(100)), {1, 2, 3}, scratch());
    files_["Needle-Sequence.mrb"] = Bundle();
    files_["scene.mrml"] = Scene("node1:0.5;node2:0.75");
  }

  fs::path scratch() const { return folder_ / "scratch"; }

  std::string Bundle() const {
    std::string scene = "<MRML version=\"Slicer4.4.0\">\n";
    std::map<std::string, std::string> files;
    for (int i = 1; i <= 2; ++i) {
      const std::string number = std::to_string(i);
      const std::string file = "Data/N " + number + ".h5";
      files["N/" + file] =
          ItkTransformFile(StoredByItk(SlicerSessionRandomPose(i)), {4, 5, 6}, scratch());
      scene += "<LinearTransform id=\"node" + number + "\" name=\"NeedleToReference\" " +
               "storageNodeRef=\"store" + number + "\"></LinearTransform>\n" +
               "<TransformStorage id=\"store" + number + "\" fileName=\"Data/N%20" + number +
               ".h5\"></TransformStorage>\n";
    }
    // A view of the scene holds copies with the same ids; they must not count.
    scene +=
        "<SceneView id=\"view\"><LinearTransform id=\"node1\" storageNodeRef=\"none\">"
        "</LinearTransform></SceneView>\n</MRML>";
    files["N/N.mrml"] = scene;
    return ZipFile(files, scratch());
  }

  static std::string Scene(const std::string& index_values) {
    return "<?xml version=\"1.0\"?>\n<!-- a scene -->\n<MRML version=\"Slicer4.4.0\">\n"
           "<LinearTransform id=\"tip\" name=\"NeedleTipToNeedle\" storageNodeRef=\"tip_store\" "
           "/>\n"
           "<TransformStorage id=\"tip_store\" fileName=\"Tip.h5\" />\n"
           "<LinearTransform id=\"now\" name=\"NeedleToReference\" "
           "matrixTransformToParent=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\" />\n"
           "<Sequence id=\"seq\" name=\"NeedleToReference-Sequence\" storageNodeRef=\"seq_store\" "
           "indexUnit=\"s\" indexValues=\"" +
           index_values +
           "\" />\n"
           "<SequenceStorage id=\"seq_store\" fileName=\"Needle-Sequence.mrb\" />\n</MRML>\n";
  }

  /// Writes the files into a folder and reads that.
  ImportedSession Read() {
    for (const auto& [name, content] : files_) WriteTextFile(folder_ / "scene" / name, content);
    return ReadAnySession(folder_ / "scene", {}, RunContext{});
  }

  void Expect(const ImportedSession& imported) {
    EXPECT_EQ(imported.needle_frame, "NeedleTip");
    ASSERT_EQ(imported.session.needle.size(), 2U);
    EXPECT_EQ(imported.session.needle[0].time_ns, 500'000'000);
    EXPECT_EQ(imported.session.needle[1].time_ns, 750'000'000);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Isometry3d truth = SlicerSessionRandomPose(i + 1) * SlicerSessionRandomPose(100);
      EXPECT_LT((imported.session.needle[i].reference_from_tool.matrix() - truth.matrix()).norm(),
                1e-11);
    }
  }

  testing_support::TemporaryFolder folder_;
  std::map<std::string, std::string> files_;
};

TEST_F(SlicerSession, ComposesRecordedAndFixedTransformsInRas) {
  Expect(Read());
}

TEST_F(SlicerSession, ReadsABundleOfTheWholeScene) {
  std::map<std::string, std::string> files;
  for (const auto& [name, content] : files_) files["Saved/" + name] = content;
  WriteTextFile(folder_ / "all.mrb", ZipFile(files, scratch()));
  Expect(ReadAnySession(folder_ / "all.mrb", {}, RunContext{}));
}

TEST_F(SlicerSession, TakesTheMatrixOfTheSceneIfThereIsNoFile) {
  const std::string stored = "storageNodeRef=\"tip_store\"";
  std::string& scene = files_["scene.mrml"];
  std::string numbers;
  for (int i = 0; i < 16; ++i)
    numbers += NumberText(SlicerSessionRandomPose(100).matrix()(i / 4, i % 4)) + " ";
  scene.replace(scene.find(stored), stored.size(), "matrixTransformToParent=\"" + numbers + "\"");
  Expect(Read());
}

TEST_F(SlicerSession, SaysWhatIsWrongAndWhere) {
  const auto expect = [&](const std::string& name, const std::string& content,
                          const char* message) {
    const std::string good = files_[name];
    files_[name] = content;
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<InputError>(HasSubstr(message)));
    files_[name] = good;
  };
  expect("scene.mrml", Scene("node1:0.5;node3:0.75"), "has no node node3");
  expect("scene.mrml", Scene("node1"), "index value 'node1'");
  expect("scene.mrml", Scene("node1:nan"), "index value 'node1:nan'");
  expect("scene.mrml", Scene(""), "no recorded transforms with time stamps");
  expect("scene.mrml", "<MRML>", "scene.mrml:1: is not valid XML");
  expect("scene.mrml", "<html></html>", "is not a Slicer scene");
  expect("Needle-Sequence.mrb", "rubbish", "is not a zip archive");
  expect("Needle-Sequence.mrb", ZipFile({{"a", "b"}}, scratch()), "must hold one scene");
  expect("Tip.h5", "rubbish", "is not an HDF5 file");
  std::string outside = Scene("node1:0.5;node2:0.75");
  outside.replace(outside.find("Tip.h5"), 6, "../Tip.h5");
  expect("scene.mrml", outside, "does not lie beside it");
  files_["second.mrml"] = "<MRML></MRML>";
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<InputError>(HasSubstr("has 2 Slicer scenes")));
}

TEST_F(SlicerSession, SurvivesDamagedFiles) {
  Read();
  for (const char* name : {"scene.mrml", "Tip.h5", "Needle-Sequence.mrb"}) {
    const int refused = testing_support::ReadDamagedCopies(
        files_[name], folder_ / "scene" / name, 300,
        [&] { ReadAnySession(folder_ / "scene", {}, RunContext{}); });
    EXPECT_GT(refused, 50) << name;
    WriteTextFile(folder_ / "scene" / name, files_[name]);
  }
}

TEST(ItkTransformFile, RefusesOtherNumbersOfParameters) {
  const testing_support::TemporaryFolder folder;
  const std::string good =
      ItkTransformFile(Eigen::Matrix4d::Identity(), {0, 0, 0}, folder / "a.h5");
  const auto affine = [](const std::string& bytes, const char* label) {
    return transforms::ReadItkAffines({{label, [&] { return Bytes(bytes); }}}).front();
  };
  EXPECT_EQ(affine(good, "a.h5"), Eigen::Matrix4d::Identity());
  EXPECT_THAT([&] { affine({}, "a.h5"); }, ThrowsMessage<InputError>(HasSubstr("a.h5")));
  Eigen::Matrix4d singular = Eigen::Matrix4d::Zero();
  EXPECT_THAT([&] { transforms::RasToParentFromItk(singular, "a.h5"); },
              ThrowsMessage<InputError>(HasSubstr("a.h5: the transform has no inverse")));
  EXPECT_THAT(
      [&] {
        affine(ItkTransformFile(Eigen::Matrix4d::Identity() * NAN, {0, 0, 0}, folder / "b.h5"),
               "b.h5");
      },
      ThrowsMessage<InputError>(HasSubstr("not finite")));
}

TEST(ZipArchive, BoundsWhatItUnpacksAndVerifiesIt) {
  const testing_support::TemporaryFolder folder;
  const std::string zeros(5'000'000, '\0');  // Becomes a few kB.
  const std::string bytes = ZipFile({{"zeros", zeros}}, folder / "bomb.zip");
  EXPECT_LT(bytes.size(), 10'000U);
  const ZipArchive archive(folder / "bomb.zip");
  EXPECT_EQ(archive.names(), std::vector<std::string>{"zeros"});
  EXPECT_EQ(archive.Read("zeros", 5'000'000).size(), zeros.size());
  EXPECT_THAT([&] { archive.Read("zeros", 4'999'999); },
              ThrowsMessage<InputError>(HasSubstr("at most 4999999 are read")));
  EXPECT_THAT([&] { archive.Read("ones", 10); },
              ThrowsMessage<InputError>(HasSubstr("has no file 'ones'")));
  std::string damaged = bytes;
  damaged[bytes.size() / 3] = static_cast<char>(damaged[bytes.size() / 3] ^ 1);
  const ZipArchive broken({damaged.begin(), damaged.end()}, "broken.zip");
  EXPECT_THAT([&] { broken.Read("zeros", 5'000'000); },
              ThrowsMessage<InputError>(HasSubstr("broken.zip: 'zeros' is damaged")));
}

TEST(ReadTransform, ReadsItkTransformsInHdf5) {
  const testing_support::TemporaryFolder folder;
  const auto read = [&](const std::vector<testing_support::ItkTransformPart>& parts) {
    testing_support::ItkTransformsFile(parts, folder / "t.h5");
    return transforms::ReadTransform(folder / "t.h5");
  };
  const testing_support::ItkTransformPart shift{"TranslationTransform_double_3_3", {1, 2, 3}, {}};
  const testing_support::ItkTransformPart turn{
      "AffineTransform_double_3_3", {0, -1, 0, 1, 0, 0, 0, 0, 1, 10, 0, 0}, {0, 0, 0}};
  EXPECT_LT((read({turn}) * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(10, 1, 0)).norm(), 1e-12);
  // The last part first, as in a text file.
  EXPECT_LT(
      (read({{"CompositeTransform_double_3_3", {}, {}}, shift, turn}) * Eigen::Vector3d(1, 0, 0) -
       Eigen::Vector3d(11, 3, 3))
          .norm(),
      1e-12);
  EXPECT_THROW(read({shift, turn}), InputError);
  EXPECT_THROW(read({{"BSplineTransform_double_3_3", std::vector<double>(300), {4, 4, 4}}}),
               InputError);
  EXPECT_THROW(
      read({{"AffineTransform_double_3_3", {2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, {0, 0, 0}}}),
      InputError);
  EXPECT_THROW(read({}), InputError);
  const std::string valid = testing_support::ItkTransformsFile({turn}, folder / "t.h5");
  EXPECT_GT(testing_support::ReadDamagedCopies(valid, folder / "d.h5", 300,
                                               [&] { transforms::ReadTransform(folder / "d.h5"); }),
            10);
  // A text in the heap that is longer than the heap: libhdf5 1.10 copies it, and crashes.
  std::string crashes = valid;
  const std::size_t heap = crashes.find("GCOL");
  ASSERT_NE(heap, crashes.npos);
  crashes[heap + 29] = 1;  // 1 TB more: byte 5 of the size of its first object.
  WriteTextFile(folder / "c.h5", crashes);
  EXPECT_THAT([&] { transforms::ReadTransform(folder / "c.h5"); },
              ThrowsMessage<InputError>(HasSubstr("c.h5: cannot be read; the file is damaged")));
}

}  // namespace
}  // namespace acus::session
