// No model takes memory in a step, for its load, or for the image.
#include <atomic>
#include <cstdlib>
#include <gtest/gtest.h>

#include "acus/physics/tissue/displacement_functions.h"
#include "acus/physics/tissue/fem_field.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "acus/physics/tissue/spring_model.h"
#include "support/allocation_counter.h"
#include "support/box_mesh.h"
#include "support/fem_needle_scene.h"
#include "support/layered_tissue.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define ACUS_COUNTS_MALLOC 1
// Eigen takes its memory from malloc itself, past operator new.
extern "C" void* __libc_malloc(std::size_t size);
static std::atomic<long> num_mallocs{0};
extern "C" [[gnu::noinline]] void* malloc(std::size_t size) {
  ++num_mallocs;
  return __libc_malloc(size);
}
#endif

namespace acus::tissue {
namespace {

using Eigen::Vector3d;

const testing_support::Layers kBody{{{0, "skin"}, {2, "fat"}, {20, "liver"}, {70, "bone"}}};

long NumTaken() {
#ifdef ACUS_COUNTS_MALLOC
  return testing_support::num_allocations + num_mallocs;
#else
  return testing_support::num_allocations;
#endif
}

template <class Model, class Field>
void ExpectNoAllocation(const Model& model, Field field) {
  auto state = model.NewState();
  TissueLoad load;
  Vector3d sum = Vector3d::Zero();
  const long before = NumTaken();
  for (int n = 0; n < 4000; ++n) {
    ToolSample sample;
    sample.time_s = 0.001 * n;
    const double z = 75.0 * std::abs(std::sin(0.004 * n)) - 3.0;
    sample.tip_in_ct_mm = Vector3d(0.3 * std::sin(0.1 * n), 0.1, n % 500 == 0 ? z - 40.0 : z);
    sample.axis_in_ct = Vector3d(0.02 * std::cos(0.1 * n), 0, 1);
    sample.needle_valid = n % 100 != 7;
    sum += model.Step(state, sample).force_in_ct_n;
    if (n % 10 != 0) continue;
    model.LoadOf(state, load);
    field.Update(load);
    sum += field.DisplacementMm(Vector3d(1, 2, z));
  }
  EXPECT_EQ(NumTaken() - before, 0);
  EXPECT_GT(sum.norm(), 1.0);
}

TEST(TissueModels, CountingFindsWhatEigenTakes) {
  const long before = NumTaken();
  Eigen::VectorXd* vector = new Eigen::VectorXd(1000);
  vector->setZero();
  asm volatile("" : : "r"(vector->data()) : "memory");  // Or the compiler does without it.
  delete vector;
#ifdef ACUS_COUNTS_MALLOC
  EXPECT_GE(NumTaken() - before, 2);
#else
  EXPECT_GE(NumTaken() - before, 1);
#endif
}

forces::ForceTable RelaxingForces() {
  forces::ForceTable table = testing_support::RoundForces();
  table.num_times = 2;
  table.times[1] = {
      .relaxation = {.share = {0.4, 0.3, 0.0}, .time_s = {0.5, 16.0, 1.0}, .num_terms = 2},
      .friction_rate = 0.1,
      .friction_dwell = 0.05};
  for (const char* tissue : {"skin", "fat", "liver"}) {
    table.tissue[volume::LabelOf(tissue)].time = table.times[1];
    table.time_of[volume::LabelOf(tissue)] = 1;
  }
  return table;
}

mechanics::ElasticityTable RelaxingElasticity() {
  mechanics::ElasticityTable table = testing_support::RoundElasticity();
  table.relaxation.term[0] = {0.4, 0.5};
  table.relaxation.term[1] = {0.3, 16.0};
  table.relaxation.num_terms = 2;
  return table;
}

TEST(TissueModels, SpringsTakeNoMemoryInAStep) {
  for (const forces::ForceTable& table : {testing_support::RoundForces(), RelaxingForces()}) {
    const SpringModel model({}, table, testing_support::Trocar18(),
                            testing_support::RoundElasticity(), kBody.Tissues(), kBody.At());
    ExpectNoAllocation(model, SpringField(model));
  }
}

TEST(TissueModels, APlaneThatRelaxesTakesNoMemoryInAStep) {
  const PlaneModel2010 model({}, {}, RelaxingForces(), testing_support::Trocar18(),
                             RelaxingElasticity(), kBody.At());
  ExpectNoAllocation(model, PlaneField2010(model));
}

TEST(TissueModels, ThePlaneTakesNoMemoryInAStep) {
  for (const PlaneUpdate update : {PlaneUpdate::kRestricted, PlaneUpdate::kFull}) {
    PlaneSettings settings;
    settings.spacing_mm = update == PlaneUpdate::kFull ? 9.0 : 3.0;
    settings.update = update;
    const PlaneModel2010 model(settings, {}, testing_support::RoundForces(),
                               testing_support::Trocar18(), testing_support::RoundElasticity(),
                               kBody.At());
    ExpectNoAllocation(model, PlaneField2010(model));
  }
}

TEST(TissueModels, DisplacementFunctionsTakeNoMemory) {
  const DisplacementFunctions functions({}, [](const Vector3d& p) { return p.z() < 0 ? 0 : 0.02; });
  DisplacementFunctionsField field(functions);
  TissueLoad load;
  load.needle.in_contact = load.needle.pierced = true;
  load.needle.tip_in_ct_mm = Vector3d(0, 0, 30);
  load.needle.friction_n = load.needle.cutting_n = 1.0;
  const long before = NumTaken();
  double sum = 0.0;
  for (int n = 0; n < 1000; ++n) {
    field.Update(load);
    sum += field.DisplacementMm(Vector3d(1, 2, 0.05 * n)).z();
  }
  EXPECT_EQ(NumTaken() - before, 0);
  EXPECT_GT(sum, 1.0);
}

TEST(TissueModels, TheImageOfFiniteElementsTakesNoMemory) {
  const mesh::TetraMesh box = testing_support::BoxMesh({6, 6, 6}, {0, 0, 0}, {30, 30, 30}, 0.15);
  std::vector<int> nodes;
  for (int i = 0; i < box.nodes_mm.cols(); i += i % 3 == 0 ? 1 : 2) nodes.push_back(i);
  const auto size = static_cast<Eigen::Index>(3 * nodes.size());
  const FemImage image(
      box, {mechanics::Compliance::FromMatrix(nodes, Eigen::MatrixXd::Identity(size, size),
                                              mechanics::Storage::kDouble),
            mechanics::ImageBlock::FromMatrix(nodes, Eigen::MatrixXf::Identity(size, size))});
  FemField field(image);
  TissueLoad load;
  load.num_points = TissueLoad::kMaxPoints;
  Vector3d sum = Vector3d::Zero();
  const long before = NumTaken();
  for (int n = 0; n < 50; ++n) {
    for (int p = 0; p < load.num_points; ++p) {
      // Also at nodes, outside, and where nodes are not stored.
      load.point[p] = {Vector3d(0.17 * p, 15 + 0.1 * n, 0.3 * ((p * p) % 100)), Vector3d(1, 2, 3)};
    }
    field.Update(load);
    sum += field.DisplacementMm(Vector3d(15, 15, 0.5 * n));
  }
  EXPECT_EQ(NumTaken() - before, 0);
  EXPECT_GT(sum.norm(), 1.0);
}

TEST(TissueModels, FiniteStrainTakesNoMemoryInAStep) {
  testing_support::SceneOptions options;
  options.reach_mm = 15.0;
  options.contact.strain.emplace();
  options.contact.strain->element = mechanics::ElementKind::kLinear;
  options.contact.strain->corridor = {{0, 0, 65}, {0, 0, 20}, 12.0};
  testing_support::FemScene scene(options);
  TissueLoad load;
  const long before = NumTaken();
  for (int n = 0; n < 1500; ++n) {
    // In, jumps, and out.
    const double depth_mm = 30.0 * std::abs(std::sin(0.004 * n)) - 3.0;
    scene.StepAt(n % 200 == 0 ? depth_mm - 10.0 : depth_mm, 0.3 * std::sin(0.1 * n));
    scene.model.LoadOf(scene.state, load);
  }
  EXPECT_EQ(NumTaken() - before, 0);
  EXPECT_GT(scene.model.strain()->region().num_nodes(), 20);
}

}  // namespace
}  // namespace acus::tissue
