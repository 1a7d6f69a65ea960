#include "acus/window/layout.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/window/command.h"
#include "acus/window/marks.h"

namespace acus::window {
namespace {

bool Overlap(const Rectangle& a, const Rectangle& b) {
  return a.left < b.left + b.width && b.left < a.left + a.width && a.top < b.top + b.height &&
         b.top < a.top + a.height;
}

std::vector<ViewKind> FirstKinds(std::size_t count) {
  return {kViewKinds.begin(), kViewKinds.begin() + static_cast<std::ptrdiff_t>(count)};
}

TEST(Layout, ViewsAndStatusFillTheWindowWithoutOverlap) {
  for (const auto& [width, height] : {std::pair{1280, 800}, {640, 480}, {1921, 1077}}) {
    for (std::size_t count = 1; count <= kViewKinds.size(); ++count) {
      const Layout layout = LayOut(width, height, FirstKinds(count), {});
      ASSERT_EQ(layout.views.size(), count);
      long area = static_cast<long>(layout.status.width) * layout.status.height;
      for (const Layout::View& view : layout.views) {
        EXPECT_GE(view.place.left, 0);
        EXPECT_LE(view.place.left + view.place.width, width);
        EXPECT_LE(view.place.top + view.place.height, layout.status.top);
        EXPECT_FALSE(Overlap(view.place, layout.status));
        for (const Layout::View& other : layout.views) {
          if (other.kind != view.kind) {
            EXPECT_FALSE(Overlap(view.place, other.place));
          }
        }
        area += static_cast<long>(view.place.width) * view.place.height;
      }
      EXPECT_GT(area, 0.98 * width * height) << count << " views, " << width << " x " << height;
    }
  }
}

TEST(Layout, LeavesRoomForTheExercise) {
  for (const auto& [width, height] : {std::pair{1280, 800}, {640, 480}, {500, 900}}) {
    for (std::size_t count = 1; count <= kViewKinds.size(); ++count) {
      const Layout layout = LayOut(width, height, FirstKinds(count), {}, true);
      EXPECT_GE(layout.exercise.width, 125);
      EXPECT_FALSE(Overlap(layout.exercise, layout.status));
      for (const Layout::View& view : layout.views) {
        EXPECT_FALSE(Overlap(view.place, layout.exercise));
        EXPECT_GT(view.place.width, 0);
      }
    }
  }
  EXPECT_TRUE(LayOut(320, 240, FirstKinds(1), {}, true).exercise.empty());
}

TEST(Layout, OfThreeViewsSquareImagesFillMoreThanInRows) {
  const Layout layout = LayOut(1280, 800, FirstKinds(3), {});
  EXPECT_GE(Fit(layout.views[0].place, 1.0, 1.0).width, 650);
  for (const int other : {1, 2}) {
    EXPECT_GE(Fit(layout.views[static_cast<std::size_t>(other)].place, 1.0, 1.0).width, 340);
  }
}

TEST(Layout, TitlesAreNotPrintedOverImages) {
  const TextSizes sizes = SizesFor(800);
  const Rectangle place{.left = 100, .top = 50, .width = 400, .height = 300};
  for (const ViewKind kind : kViewKinds) {
    const Rectangle image = ImageRoom(kind, place, sizes);
    EXPECT_GE(image.top, place.top + 5 + sizes.normal_px) << TitleOf(kind);
    EXPECT_LE(image.top + image.height, place.top + place.height);
  }
}

TEST(Layout, TheFirstOfThreeImagesIsTheLargestPartOfTheWindow) {
  const Layout layout = LayOut(1280, 800, FirstKinds(3), {}, true);
  EXPECT_GE(layout.views[0].place.width, 630);
  EXPECT_LE(layout.exercise.width, 290);
}

TEST(Layout, ViewsAreChosenByName) {
  EXPECT_EQ(ViewsOf("volume,ultrasound"),
            (std::vector<ViewKind>{ViewKind::kVolume, ViewKind::kUltrasound}));
  EXPECT_EQ(ViewsOf("camera,ultrasound,3d,volume,ct,effects,ct").size(), kViewKinds.size());
  for (const char* bad : {"", "volumes", "3d,", "3d, ct", ","}) {
    EXPECT_THROW(ViewsOf(bad), InputError) << bad;
  }
}

TEST(Layout, AViewAloneGetsAllTheRoomAndOneNotShownDoesNot) {
  const auto shown = FirstKinds(3);
  const Layout alone = LayOut(1280, 800, shown, ViewKind::kUltrasound);
  ASSERT_EQ(alone.views.size(), 1U);
  EXPECT_EQ(alone.views[0].kind, ViewKind::kUltrasound);
  EXPECT_EQ(alone.views[0].place.width, 1280);
  EXPECT_EQ(LayOut(1280, 800, shown, ViewKind::kEffect).views.size(), 3U);
}

TEST(Layout, FindsTheViewUnderThePointer) {
  const Layout layout = LayOut(1280, 800, FirstKinds(5), {});
  for (const Layout::View& view : layout.views) {
    const auto* found =
        layout.At(view.place.left + view.place.width / 2, view.place.top + view.place.height / 2);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->kind, view.kind);
    EXPECT_EQ(layout.Find(view.kind), &view);
  }
  EXPECT_EQ(layout.At(640, 799), nullptr) << "the status bar is no view";
}

TEST(Layout, TinyWindowsHaveNoNegativeSizes) {
  for (const int size : {1, 2, 20, 60}) {
    const Layout layout = LayOut(size, size, FirstKinds(5), {});
    for (const Layout::View& view : layout.views) {
      EXPECT_GE(view.place.width, 0);
    }
    EXPECT_GE(layout.status.height, 0);
  }
}

TEST(Fit, KeepsProportionsInTheMiddle) {
  const Rectangle fit = Fit({.left = 10, .top = 20, .width = 400, .height = 100}, 200.0, 100.0);
  EXPECT_EQ(fit.width, 200);
  EXPECT_EQ(fit.height, 100);
  EXPECT_EQ(fit.left, 110);
  EXPECT_EQ(fit.top, 20);
  EXPECT_TRUE(Fit({.left = 0, .top = 0, .width = 100, .height = 100}, 0.0, 5.0).empty());
}

TEST(Keys, EveryCommandHasOneAndAName) {
  for (int i = 0; i <= static_cast<int>(Command::kHelp); ++i) {
    const auto command = static_cast<Command>(i);
    EXPECT_FALSE(NameOf(command).empty()) << i;
    int count = 0;
    for (const KeyHelp& key : Keys()) count += key.command == command ? 1 : 0;
    EXPECT_EQ(count, 1) << NameOf(command);
  }
}

}  // namespace
}  // namespace acus::window
