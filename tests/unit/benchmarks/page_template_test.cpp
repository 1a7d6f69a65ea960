#include "benchmarks/page_template.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "benchmarks/expression.h"
#include "benchmarks/measured_tables.h"
#include "benchmarks/tradeoff_report.h"
#include "support/temporary_folder.h"

namespace acus::benchmarks {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

Row RowOf(const char* knob, const char* value, double error, const char* unit, double step_us) {
  Row row;
  row.knob = knob;
  row.value = value;
  row.error = error;
  row.error_unit = unit;
  row.step_us_median = step_us;
  return row;
}

/// Errors that fall with the square of the size, in two units; one value that must not be used.
PageData Data() {
  PageData data;
  auto& rows = data.sweeps["tissue"];
  for (const auto& [value, size] : {std::pair("4", 4.0), {"2", 2.0}, {"1", 1.0}}) {
    rows.push_back(RowOf("size_mm", value, 0.1 * size * size, "N", 12.0 / size));
    rows.push_back(RowOf("size_mm", value, 3.0 * size, "%", 12.0 / size));
  }
  rows[2].is_default = rows[3].is_default = true;
  rows.push_back(RowOf("model", "2D, coarse", 0.7, "N", 1.0));
  rows.back().is_paper = true;
  rows.push_back(RowOf("model", "wild", 1e9, "N", 0.5));
  rows.back().unusable = "diverged";
  data.facts["machine"] = {{"cpu", "Abacus 9"}, {"cores", 2}, {"lost", nullptr}};
  return data;
}

TEST(Expression, IsArithmeticOverMeasuredNumbers) {
  const PageData data = Data();
  EXPECT_DOUBLE_EQ(ValueOf("2 + 3 * (4 - 1) / 2", data), 6.5);
  EXPECT_DOUBLE_EQ(ValueOf("-2 * -[machine | cores]", data), 4.0);
  EXPECT_DOUBLE_EQ(ValueOf("[tissue | size_mm | 2 | error N]", data), 0.4);
  EXPECT_DOUBLE_EQ(ValueOf("[tissue | size_mm | default | error %]", data), 6.0);
  EXPECT_DOUBLE_EQ(ValueOf("[tissue|size_mm|1|step_us_median]", data), 12.0);
  EXPECT_DOUBLE_EQ(ValueOf("max([tissue | size_mm | * | step_us_median]; 5)", data), 12.0);
  EXPECT_DOUBLE_EQ(ValueOf("min([tissue | size_mm | * | error %])", data), 3.0);
  EXPECT_DOUBLE_EQ(ValueOf("mean([tissue | size_mm | * | error %])", data), 7.0);
  EXPECT_NEAR(ValueOf("log([tissue | size_mm | 4 | error N] / [tissue | size_mm | 1 | error N]) / "
                      "log(4)",
                      data),
              2.0, 1e-12);
  // What must not be used is no number.
  EXPECT_DOUBLE_EQ(ValueOf("max([tissue | model | * | error N])", data), 0.7);
}

TEST(Expression, WhatWasNotMeasuredIsNoNumber) {
  const PageData data = Data();
  for (const char* text :
       {"[machine | lost]", "1 + [tissue | size_mm | 8 | error N]",
        "max([tissue | size_mm | 8 | error N]; 2)", "[tissue | size_mm | 4 | preparation_s]"}) {
    EXPECT_TRUE(std::isnan(ValueOf(text, data))) << text;
  }
}

TEST(Expression, SaysWhatItCannotUnderstand) {
  const PageData data = Data();
  for (const char* text : {"", "1 +", "2 3", "(1", "[machine", "[machine]", "[nothing | cores]",
                           "[nothing | a | b | error N]", "[tissue | size | 1 | error N]",
                           "[tissue | size_mm | 1 | speed]", "[tissue | size_mm | * | error N]",
                           "median(1)", "max 1", "[machine | cpu]"}) {
    EXPECT_THROW(ValueOf(text, data), InputError) << text;
  }
}

TEST(Claims, AreComparedAndChained) {
  const PageData data = Data();
  EXPECT_EQ(Check("1 < 2 <= 2 < 3", data).holds, true);
  EXPECT_EQ(Check("1 < 2 > 3", data).holds, false);
  EXPECT_EQ(Check("3 >= 3 and 2 > 3", data).holds, false);
  EXPECT_EQ(Check("1 < [tissue | size_mm | 8 | error N]", data).holds, std::nullopt);
  EXPECT_EQ(Check("1 < [machine | cores] < 1.5", data).values, "1 < 2 < 1.5");
  EXPECT_THROW(Check("1 + 2", data), InputError);
}

TEST(PageTemplate, FillsInNumbersAndFacts) {
  const Page page = MakePage(
      "On {{text machine | cpu}}: {{= [tissue | size_mm | 2 | error N]}} N,\n"
      "{{require 0.3 < [tissue | size_mm | 2 | error N] < 0.5}}\n"
      "{{= 1000 / 3 : 4}} of it{{require 1 < 2}}.\n",
      Data(), Claims::kMustHold);
  EXPECT_EQ(page.text, "On Abacus 9: 0.4 N,\n333.3 of it.\n");
}

TEST(PageTemplate, RefusesWhatNoLongerHoldsAndSaysWhere) {
  const char* text = "One.\n{{require [tissue | size_mm | 2 | error N] < 0.3}}\nIt is {{= 1 +}}.\n";
  EXPECT_THAT(
      [&] { MakePage(text, Data(), Claims::kMustHold); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("line 2: what the text says no longer holds"),
                                      HasSubstr("0.4 < 0.3"), HasSubstr("line 3: "))));
  EXPECT_THROW(MakePage("{{= [tissue | size_mm | 8 | error N]}}", Data(), Claims::kMustHold),
               InputError);
  EXPECT_THROW(MakePage("{{sum 1}}", Data(), Claims::kAreMarked), InputError);
  EXPECT_THROW(MakePage("{{= 1", Data(), Claims::kAreMarked), InputError);
}

TEST(PageTemplate, OfAnotherRunSaysWhereItIsNotSo) {
  const Page page = MakePage(
      "Small{{require [tissue | size_mm | 2 | error N] < 0.3}} and "
      "{{= [tissue | size_mm | 8 | error N]}}.{{require [machine | lost] < 1}}\n",
      Data(), Claims::kAreMarked);
  EXPECT_EQ(page.text,
            "Small **(not so in this run: 0.4 < 0.3)**  and –. **(not measured in this run)** \n");
}

TEST(MeasuredTables, ShowSettingsBelowEachOther) {
  EXPECT_EQ(SettingsTable("sweep tissue\nknob size_mm = size, mm\ncolumn mN = 1000 * error N\n"
                          "column % = error %\ncolumn s = preparation_s\n",
                          Data()),
            "| size, mm | mN | % | s |\n|---|---|---|---|\n"
            "| 4 | 1600 | 12 | – |\n| **2** | 400 | 6 | – |\n| 1 | 100 | 3 | – |\n");
  EXPECT_EQ(
      SettingsTable("sweep tissue\nknob size_mm = size\nknob model\ncolumn N = error N\n", Data()),
      "| knob | value | N |\n|---|---|---|\n| size | 4 | 1.6 |\n| size | **2** | 0.4 |\n"
      "| size | 1 | 0.1 |\n| model | 2D, coarse (paper) | 0.7 |\n"
      "| model | wild (unusable) | 1e+09 |\n");
  EXPECT_THROW(SettingsTable("sweep tissue\nknob colour\ncolumn N = error N", Data()), InputError);
  EXPECT_THROW(SettingsTable("sweep tissue\nknob model", Data()), InputError);
  EXPECT_THROW(SettingsTable("sweep tissue\nrow model", Data()), InputError);
}

TEST(MeasuredTables, ShowValuesSideBySide) {
  EXPECT_EQ(
      ValuesTable("sweep tissue\ntitle N\nat 4 = 4 mm\nat 1\nrow size_mm = size\ncell error N\n"
                  "cell error %\ncolumn us = step_us_median @ 2",
                  Data()),
      "| N | 4 mm | 1 | us |\n|---|---|---|---|\n| size | 1.6 / 12 | 0.1 / 3 | 6 |\n");
  EXPECT_EQ(ValuesTable("sweep tissue\nat wild\nat 7\nrow model\ncell error N\ncell error N\n"
                        "unusable diverges",
                        Data()),
            "|  | wild | 7 |\n|---|---|---|\n| model | diverges | – / – |\n");
}

TEST(MeasuredTables, DrawFigures) {
  const char* asked =
      "figure f\nsweep tissue\ntitle Costs\nx step_us_median = us\ny error N = N\n"
      "line size_mm = size\npoints model";
  const Page page = MakePage(std::string("{{") + asked + "}}", Data(), Claims::kMustHold);
  EXPECT_EQ(page.text, "![Costs](figures/f.svg)");
  const std::string& svg = page.figures.at("f");
  for (const char* text : {">size<", ">2D, coarse (paper)<", ">default<", "Costs"}) {
    EXPECT_TRUE(svg.find(text) != svg.npos) << text;
  }
  EXPECT_TRUE(svg.find("wild") == svg.npos) << "it must not be used";
  EXPECT_THROW(FigureSvg("sweep tissue\nx error N = N\ny error N = N", Data()), InputError);
}

TEST(PageData, ReadsWhatASweepHasWritten) {
  const testing_support::TemporaryFolder folder;
  const auto rows = Data().sweeps.at("tissue");
  WriteTextFile(folder.path() / "tissue.csv", CsvText(rows));
  WriteTextFile(folder.path() / "machine.json", "{\"cores\": 2}");
  const PageData data = PageData::Read(folder.path());
  EXPECT_EQ(CsvText(data.Sweep("tissue")), CsvText(rows));
  EXPECT_DOUBLE_EQ(ValueOf("[tissue | model | 2D, coarse | error N]", data), 0.7);
  EXPECT_DOUBLE_EQ(ValueOf("[machine | cores]", data), 2.0);
  WriteTextFile(folder.path() / "tissue.csv", "knob,value\n1,2\n");
  EXPECT_THROW(PageData::Read(folder.path()), InputError);
  EXPECT_THROW(PageData::Read(folder.path() / "nowhere"), InputError);
}

}  // namespace
}  // namespace acus::benchmarks
