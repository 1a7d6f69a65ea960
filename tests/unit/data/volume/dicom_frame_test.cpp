#include "acus/data/volume/dicom_frame.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "support/structure_set_writer.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

class SameFrame : public testing::Test {
 protected:
  void Require(const DicomFrame& labels, const DicomFrame& ct, bool accept = false) {
    warnings_.clear();
    RunContext context;
    context.on_warning = [&](std::string_view text) { warnings_.emplace_back(text); };
    RequireSameFrame(labels, ct, accept, "s.dcm", context);
  }
  std::vector<std::string> warnings_;
};

TEST_F(SameFrame, IsTakenWithoutAWordWhereNothingDiffersOrIsSaid) {
  for (const DicomFrame& labels :
       {DicomFrame{{"1.2"}, {"1.9"}}, DicomFrame{{"1.2"}, {}}, DicomFrame{{}, {"1.9"}},
        DicomFrame{}, DicomFrame{{"1.3", "1.2"}, {"1.8", "1.9"}}}) {
    Require(labels, {{"1.2"}, {"1.9"}});
    EXPECT_THAT(warnings_, IsEmpty());
  }
  Require({{"1.2"}, {"1.9"}}, {});
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(SameFrame, IsAnotherOneOnlyByOption) {
  const auto both = AllOf(HasSubstr("s.dcm: its frame of reference is 1.3, that of the CT 1.2"),
                          HasSubstr("drawn on series 1.8, the CT is 1.9"));
  EXPECT_THAT(
      [&] {
        Require({{"1.3"}, {"1.8"}}, {{"1.2"}, {"1.9"}});
      },
      ThrowsMessage<InputError>(AllOf(both, HasSubstr("--accept-implausible"))));
  EXPECT_THAT(
      [&] {
        Require({{"1.3"}, {}}, {{"1.2"}, {"1.9"}});
      },
      ThrowsMessage<InputError>(HasSubstr("is 1.3, that of the CT 1.2. Coord")));
  Require({{"1.3"}, {"1.8"}}, {{"1.2"}, {"1.9"}}, true);
  EXPECT_THAT(warnings_, ElementsAre(both));
}

TEST_F(SameFrame, OfAnotherSeriesIsNamed) {
  Require({{"1.2"}, {"1.8"}}, {{"1.2"}, {"1.9"}});
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("drawn on series 1.8, the CT is 1.9")));
  // Some programs write a frame of their own beside the right series.
  Require({{"1.3"}, {"1.9"}}, {{"1.2"}, {"1.9"}});
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("but it was drawn on the series of the CT")));
}

TEST(FrameOf, CtAndStructureSetIsRead) {
  const testing_support::TemporaryFolder folder;
  for (const int z : {0, 2, 4}) {
    testing_support::WriteDicomSlice(folder / (std::to_string(z) + ".dcm"),
                                     {.series_uid = "1.9",
                                      .columns = 4,
                                      .rows = 3,
                                      .position_mm = {0, 0, static_cast<double>(z)},
                                      .stored = std::vector<std::int16_t>(12),
                                      .frame_uid = "1.2"});
  }
  const DicomFrame ct = FrameOfCt(folder / ".", "", 1);
  EXPECT_THAT(ct.uids, ElementsAre("1.2"));
  EXPECT_THAT(ct.series, ElementsAre("1.9"));
  const testing_support::TemporaryFolder other;
  testing_support::WriteStructureSet(other / "s.dcm",
                                     {{.name = "A", .frame_uid = "1.2"},
                                      {.name = "B", .frame_uid = "1.3"},
                                      {.name = "C", .frame_uid = "1.2"}},
                                     {.frame_uid = "1.4", .series_uid = "1.8"});
  EXPECT_THAT(FrameOfLabels(other / "s.dcm").uids, ElementsAre("1.2", "1.3"));
  EXPECT_THAT(FrameOfLabels(other / "s.dcm").series, ElementsAre("1.8"));
  testing_support::WriteStructureSet(other / "s.dcm", {{.name = "A"}},
                                     {.frame_uid = "1.4", .series_uid = ""});
  EXPECT_THAT(FrameOfLabels(other / "s.dcm").uids, ElementsAre("1.4"));
}

}  // namespace
}  // namespace acus::volume
