#include "acus/patient/segmentation/spine/vertebrae.h"

#include <gmock/gmock.h>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/spine_profile.h"
#include "acus/patient/segmentation/voxels/crop.h"
#include "lumbar_back.h"

namespace acus::segmentation {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Seed 3: the method was developed on 1 and 2.
const LumbarBack& Back() {
  static const LumbarBack back = MakeLumbarBack(3);
  return back;
}

/// The vertebra that a point belongs to in the exact anatomy, or nothing.
std::string TruthAt(const phantom::Anatomy& anatomy, const Eigen::Vector3d& p) {
  if (anatomy.LabelAt(p) != volume::LabelOf("bone")) return "";
  for (const phantom::Part& part : anatomy.parts()) {
    const bool vertebra = part.name.size() <= 3 && (part.name[0] == 'L' || part.name[0] == 'T');
    if (vertebra && part.shape.distance_mm(p / anatomy.scale()) <= 0.0) return part.name;
  }
  return "";
}

TEST(Vertebrae, DiscsLieWhereTheAnatomyHasThem) {
  const LumbarBack& lumbar = Back();
  const auto planes = FindDiscPlanes(lumbar.scan.ct, CanalLineOf(lumbar.found));
  for (const char* name : {"disc_L1L2", "disc_L2L3", "disc_L3L4", "disc_L4L5"}) {
    const Eigen::Vector3d disc = lumbar.anatomy.Landmark(name);
    double nearest_mm = 100.0;
    for (const DiscPlane& plane : planes) {
      nearest_mm = std::min(nearest_mm, std::abs((disc - plane.point_mm).dot(plane.normal)));
    }
    EXPECT_LT(nearest_mm, 3.0) << name;
  }
}

TEST(Vertebrae, ArePartedAndNamedFromAStart) {
  const LumbarBack& lumbar = Back();
  const Eigen::Vector3d in_l3 =
      0.5 * (lumbar.anatomy.Landmark("disc_L2L3") + lumbar.anatomy.Landmark("disc_L3L4"));
  const Vertebrae found = FindVertebrae(lumbar.scan.ct, lumbar.found, NamedVertebra{"L3", in_l3});
  std::map<std::string, std::array<std::size_t, 3>> counts;  // Both, ours, theirs.
  const volume::Geometry& g = lumbar.scan.ct.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const auto label = found.labels.At(i, j, k);
        const std::string ours = label == 0 ? "" : found.labels.names.at(label);
        const std::string theirs =
            TruthAt(lumbar.anatomy, g.ct_from_index() * Eigen::Vector3d(i, j, k));
        if (!ours.empty()) ++counts[ours][1];
        if (!theirs.empty()) ++counts[theirs][2];
        if (!ours.empty() && ours == theirs) ++counts[ours][0];
      }
    }
  }
  for (const char* name : {"L1", "L2", "L3", "L4", "L5"}) {
    const auto [both, ours, theirs] = counts[name];
    const double dice = 2.0 * static_cast<double>(both) / static_cast<double>(ours + theirs);
    std::cout << name << ": Dice " << dice << '\n';
    EXPECT_GT(dice, 0.85) << name;
  }
  // From the head, one after the other.
  for (std::size_t n = 1; n < found.list.size(); ++n) {
    EXPECT_LT(found.list[n].centre_mm.z(), found.list[n - 1].centre_mm.z() - 15.0);
  }
  for (std::size_t n = 0; n < found.list.size(); ++n) {
    if (!found.list[n].is_whole) continue;
    const Eigen::Array3i centre =
        (g.index_from_ct() * found.list[n].centre_mm).array().round().cast<int>();
    EXPECT_EQ(found.labels.At(centre[0], centre[1], centre[2]), n + 1) << found.list[n].name;
  }
  EXPECT_EQ(found.discs.size() + 1, found.list.size());
  EXPECT_THAT(VertebraeSentence(found), HasSubstr("to S1"));
}

TEST(Vertebrae, AreNamedFromTheSacrumIfTheCtShowsItsWings) {
  const LumbarBack& lumbar = Back();
  const Vertebrae found = FindVertebrae(lumbar.scan.ct, lumbar.found, std::nullopt);
  EXPECT_EQ(found.named_from, NamedFrom::kSacrum);
  const Eigen::Vector3d in_l3 =
      0.5 * (lumbar.anatomy.Landmark("disc_L2L3") + lumbar.anatomy.Landmark("disc_L3L4"));
  const auto l3 = std::ranges::find(found.list, "L3", &Vertebra::name);
  ASSERT_NE(l3, found.list.end());
  EXPECT_LT((l3->centre_mm - in_l3).norm(), 10.0);
  EXPECT_THAT(VertebraeSentence(found), HasSubstr("to S1, from the head. Named from the sacrum"));
}

TEST(Vertebrae, AreNumberedInAFieldOfViewWithoutTheWings) {
  const LumbarBack& lumbar = Back();
  Box box{Eigen::Array3i(40, 0, 0), lumbar.scan.ct.geometry.size - 1};
  box.high[0] = 110;
  const auto labels = Cropped(lumbar.found, box);
  volume::LabelMap narrow(labels.geometry);
  narrow.voxels = labels.voxels;
  narrow.names = lumbar.found.names;
  const Vertebrae found = FindVertebrae(Cropped(lumbar.scan.ct, box), narrow, std::nullopt);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.named_from, NamedFrom::kNothing);
  EXPECT_EQ(found.list.front().name, "vertebra_1");
  EXPECT_EQ(found.labels.names.size(), found.list.size());
  EXPECT_THAT(VertebraeSentence(found), AllOf(HasSubstr("wings"), HasSubstr("--vertebra L3=")));
}

/// Exact voxels of single vertebrae, as a label map made elsewhere has them.
volume::LabelMap ExactVertebrae(const LumbarBack& lumbar,
                                const std::map<std::string, std::string>& name_of) {
  volume::LabelMap out(lumbar.scan.ct.geometry);
  const volume::Geometry& g = out.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const auto name =
            name_of.find(TruthAt(lumbar.anatomy, g.ct_from_index() * Eigen::Vector3d(i, j, k)));
        if (name == name_of.end()) continue;
        out.At(i, j, k) = static_cast<volume::Label>(*NumberOfVertebra(name->second) + 1);
      }
    }
  }
  return out;
}

TEST(Vertebrae, NamesOfALabelMapStayAndGoOnUpAndDown) {
  const LumbarBack& lumbar = Back();
  const auto imported = ExactVertebrae(lumbar, {{"L2", "L2"}, {"L3", "L3"}});
  const Vertebrae found = FindVertebrae(lumbar.scan.ct, lumbar.found, std::nullopt, &imported);
  EXPECT_EQ(found.named_from, NamedFrom::kImport);
  const auto is_named = [&](const char* name) {
    return std::ranges::find(found.list, name, &Vertebra::name);
  };
  for (const char* name : {"L1", "L2", "L3", "L4", "L5"}) {
    ASSERT_NE(is_named(name), found.list.end()) << name;
  }
  for (const char* name : {"L1", "L4"}) {
    const auto next = name == std::string("L1") ? "disc_L1L2" : "disc_L4L5";
    EXPECT_LT((is_named(name)->centre_mm - lumbar.anatomy.Landmark(next)).norm(), 45.0) << name;
  }
  // The voxels are those of the map.
  const auto l3 = static_cast<volume::Label>(is_named("L3") - found.list.begin() + 1);
  const auto theirs = static_cast<volume::Label>(*NumberOfVertebra("L3") + 1);
  for (std::size_t n = 0; n < imported.voxels.size(); ++n) {
    ASSERT_EQ(found.labels.voxels[n] == l3, imported.voxels[n] == theirs);
  }
}

TEST(Vertebrae, NamesOfALabelMapThatDoNotFollowEachOtherStay) {
  const LumbarBack& lumbar = Back();
  const auto imported = ExactVertebrae(lumbar, {{"L2", "L1"}, {"L3", "L3"}});
  const Vertebrae found = FindVertebrae(lumbar.scan.ct, lumbar.found, std::nullopt, &imported);
  EXPECT_THAT(found.doubt, HasSubstr("do not follow"));
  EXPECT_EQ(std::ranges::count(found.list, "L1", &Vertebra::name), 1);
  EXPECT_EQ(std::ranges::count(found.list, "L2", &Vertebra::name), 0);
}

TEST(Vertebrae, OfALabelMapAreThereWithoutASpine) {
  const LumbarBack& lumbar = Back();
  const auto imported = ExactVertebrae(lumbar, {{"L2", "L2"}, {"L3", "L3"}});
  const volume::LabelMap empty(lumbar.scan.ct.geometry);
  const Vertebrae found = FindVertebrae(lumbar.scan.ct, empty, std::nullopt, &imported);
  ASSERT_EQ(found.list.size(), 2U);
  EXPECT_EQ(found.list[1].name, "L3");
  const Eigen::Vector3d in_l3 =
      0.5 * (lumbar.anatomy.Landmark("disc_L2L3") + lumbar.anatomy.Landmark("disc_L3L4"));
  EXPECT_LT((found.list[1].centre_mm - in_l3).norm(), 8.0);
}

/// In slices of 5 mm the middle of a body is less dense than its end plates, like a disc.
TEST(Vertebrae, AreNotPartedBetweenTheirPedicles) {
  const LumbarBack& lumbar = Back();
  const CanalLine line = CanalLineOf(lumbar.found);
  const auto discs = FindDiscPlanes(lumbar.scan.ct, line);
  const SpineProfile profile(line, lumbar.found);
  std::vector<DiscPlane> parted;
  for (std::size_t n = 0; n < discs.size(); ++n) {
    if (n > 0) {  // Pedicles are at the upper half of a body.
      const int step = (2 * discs[n].step + discs[n - 1].step) / 3;
      parted.push_back({line.points_mm[static_cast<std::size_t>(step)],
                        line.tangent[static_cast<std::size_t>(step)], 50.0, step});
    }
    parted.push_back(discs[n]);
  }
  ASSERT_GE(discs.size(), 5U);
  const int dropped = DropDiscsWithinVertebrae(profile, parted);
  EXPECT_EQ(dropped, static_cast<int>(discs.size()) - 1);
  ASSERT_EQ(parted.size(), discs.size());
  for (std::size_t n = 0; n < discs.size(); ++n) EXPECT_EQ(parted[n].step, discs[n].step);
  EXPECT_EQ(DropDiscsWithinVertebrae(profile, parted), 0);
}

/// The CT in a file whose axes are turned against those of the patient.
TEST(Vertebrae, AreTheSameInAnObliqueGrid) {
  LumbarBack lumbar = Back();
  Eigen::Vector3d in_l3 =
      0.5 * (lumbar.anatomy.Landmark("disc_L2L3") + lumbar.anatomy.Landmark("disc_L3L4"));
  const Vertebrae straight =
      FindVertebrae(lumbar.scan.ct, lumbar.found, NamedVertebra{"L3", in_l3});
  volume::LabelMap filled = lumbar.found;
  FillBodies(lumbar.scan.ct, filled);

  const Eigen::Isometry3d turn = Eigen::Translation3d(5, -40, 12) *
                                 Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitX());
  for (volume::Geometry* g : {&lumbar.scan.ct.geometry, &lumbar.found.geometry}) {
    g->direction = turn.linear() * g->direction;
    g->origin_mm = turn * g->origin_mm;
  }
  const Vertebrae oblique =
      FindVertebrae(lumbar.scan.ct, lumbar.found, NamedVertebra{"L3", turn * in_l3});
  EXPECT_EQ(oblique.labels.voxels, straight.labels.voxels);
  EXPECT_TRUE(oblique.labels.geometry.Matches(lumbar.scan.ct.geometry));
  ASSERT_EQ(oblique.list.size(), straight.list.size());
  for (std::size_t n = 0; n < oblique.list.size(); ++n) {
    EXPECT_EQ(oblique.list[n].name, straight.list[n].name);
    EXPECT_LT((oblique.list[n].centre_mm - turn * straight.list[n].centre_mm).norm(), 1e-6);
  }
  for (std::size_t n = 0; n < oblique.discs.size(); ++n) {
    EXPECT_LT((oblique.discs[n].normal - turn.linear() * straight.discs[n].normal).norm(), 1e-9);
  }
  FillBodies(lumbar.scan.ct, lumbar.found);
  EXPECT_EQ(lumbar.found.voxels, filled.voxels);
  EXPECT_TRUE(lumbar.found.geometry.Matches(lumbar.scan.ct.geometry));
}

TEST(Vertebrae, ANameThatCannotBeIsRefused) {
  const LumbarBack& lumbar = Back();
  const Eigen::Vector3d in_l3 =
      0.5 * (lumbar.anatomy.Landmark("disc_L2L3") + lumbar.anatomy.Landmark("disc_L3L4"));
  const auto find = [&](const std::string& name, const Eigen::Vector3d& p) {
    FindVertebrae(lumbar.scan.ct, lumbar.found, NamedVertebra{name, p});
  };
  EXPECT_THAT([&] { find("S1", in_l3); }, ThrowsMessage<InputError>(HasSubstr("does not fit")));
  EXPECT_THAT([&] { find("C1", in_l3); }, ThrowsMessage<InputError>(HasSubstr("does not fit")));
  EXPECT_THAT([&] { find("L3", in_l3 + Eigen::Vector3d(60, 0, 0)); },
              ThrowsMessage<InputError>(HasSubstr("vertebrae.csv")));
  const volume::LabelMap empty(lumbar.scan.ct.geometry);
  EXPECT_TRUE(FindVertebrae(lumbar.scan.ct, empty, std::nullopt).empty());
  EXPECT_THAT(([&] {
                FindVertebrae(lumbar.scan.ct, empty, NamedVertebra{"L3", in_l3});
              }),
              ThrowsMessage<InputError>(HasSubstr("no spine")));
}

TEST(Vertebrae, NamesAreReadFromOneArgument) {
  const NamedVertebra l3 = ParseVertebra("L3=-2.5,110,1e2");
  EXPECT_EQ(l3.name, "L3");
  EXPECT_EQ(l3.point_mm, Eigen::Vector3d(-2.5, 110, 100));
  for (const char* text : {"", "L3", "L3=", "L3=1,2", "L3=1,2,3,4", "L3=1,2,x", "L3=1,2,nan"}) {
    EXPECT_THAT([&] { ParseVertebra(text); },
                ThrowsMessage<InputError>(HasSubstr("L3=-2.5,110,140")))
        << text;
  }
  EXPECT_THAT([] { ParseVertebra("L9=1,2,3"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("L9"), HasSubstr("T1 to T12"))));
}

TEST(Vertebrae, MarrowWithinABodyIsBone) {
  // The exact bone of one body, with a hole that its cortex does not close off in any slice.
  LumbarBack lumbar = Back();
  const Eigen::Vector3d centre =
      0.5 * (lumbar.anatomy.Landmark("disc_L2L3") + lumbar.anatomy.Landmark("disc_L3L4"));
  const volume::Geometry& g = lumbar.scan.ct.geometry;
  const auto bone = volume::LabelOf("bone");
  std::vector<std::size_t> hole;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k) - centre;
        const bool core = p.norm() < 7.0;
        const bool way_out =
            std::abs(p.y()) < 2.0 && std::abs(p.z()) < 3.0 && p.x() > 0 && p.x() < 26.0;
        if ((core || way_out) && lumbar.found.At(i, j, k) == bone) {
          hole.push_back(g.Index(i, j, k));
        }
      }
    }
  }
  ASSERT_GT(hole.size(), 300U);
  for (const std::size_t at : hole) lumbar.found.voxels[at] = volume::LabelOf("soft_tissue");
  FillBodies(lumbar.scan.ct, lumbar.found);
  const auto filled =
      std::ranges::count_if(hole, [&](std::size_t at) { return lumbar.found.voxels[at] == bone; });
  EXPECT_GT(static_cast<double>(filled), 0.9 * static_cast<double>(hole.size()));
}

}  // namespace
}  // namespace acus::segmentation
