#include "benchmarks/tradeoff_report.h"

#include <gtest/gtest.h>

namespace acus::benchmarks {
namespace {

// As developer/accuracy_pages/measured.py reads it.
TEST(TradeoffReport, TableHasNoCommasInTextsAndNothingWhereNothingWasMeasured) {
  Row row;
  row.knob = "model";
  row.value = "2D, coarse";
  row.error = 0.25;
  row.error_unit = "N, largest";
  row.step_us_median = 3.0;
  row.is_default = true;
  EXPECT_EQ(CsvText({row}),
            "knob,value,model,error,error_unit,reference,step_us_median,step_us_p999,"
            "preparation_s,memory_mb,is_default,is_paper,unusable\n"
            "model,2D; coarse,,0.25,N; largest,,3,,,,1,0,\n");
}

}  // namespace
}  // namespace acus::benchmarks
