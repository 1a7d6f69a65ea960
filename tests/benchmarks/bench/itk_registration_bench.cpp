// What ITK's own registrations make of two phases of a 4D CT whose motion is known, for
// developer/breathing-accuracy: demons and B-splines, plain settings, not tuned.
#include <algorithm>
#include <functional>
#include <iostream>
#include <itkBSplineTransform.h>
#include <itkBSplineTransformParametersAdaptor.h>
#include <itkDiffeomorphicDemonsRegistrationFilter.h>
#include <itkFastSymmetricForcesDemonsRegistrationFilter.h>
#include <itkImage.h>
#include <itkImageRegistrationMethodv4.h>
#include <itkLBFGS2Optimizerv4.h>
#include <itkLinearInterpolateImageFunction.h>
#include <itkMeanSquaresImageToImageMetricv4.h>
#include <itkMultiThreaderBase.h>
#include <itkResampleImageFilter.h>
#include <string>

#include "acus/base/core/error.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/breathing_registration/capture.h"
#include "acus/patient/breathing_registration/level_image.h"

namespace {

namespace fs = std::filesystem;
using namespace acus;
using Eigen::Vector3d;
using ItkImage = itk::Image<float, 3>;
using ItkField = itk::Image<itk::Vector<float, 3>, 3>;

constexpr double kFinestMm = 2.0;  // As acus-breathing, unless voxels are larger.
constexpr int kGrids = 3;

/// The reference and a phase on one grid, in the units of contrast that acus-breathing uses.
struct ImagePair {
  volume::Grid<float> fixed, moving;
};

template <class Image>
typename Image::Pointer EmptyOn(const volume::Geometry& g) {
  auto out = Image::New();
  typename Image::SizeType size;
  typename Image::SpacingType spacing;
  typename Image::PointType origin;
  typename Image::DirectionType direction;
  for (unsigned axis = 0; axis < 3; ++axis) {
    size[axis] = static_cast<itk::SizeValueType>(g.size[axis]);
    spacing[axis] = g.spacing_mm[axis];
    origin[axis] = g.origin_mm[axis];
    for (unsigned row = 0; row < 3; ++row) direction[row][axis] = g.direction(row, axis);
  }
  out->SetRegions(size);
  out->SetSpacing(spacing);
  out->SetOrigin(origin);
  out->SetDirection(direction);
  out->Allocate();
  return out;
}

ItkImage::Pointer InItk(const volume::Grid<float>& image) {
  auto out = EmptyOn<ItkImage>(image.geometry);
  std::ranges::copy(image.voxels, out->GetBufferPointer());
  return out;
}

/// Coarsest last.
std::vector<ImagePair> Pyramid(const volume::CtVolume& reference, const volume::CtVolume& phase) {
  using namespace breathing_registration;
  const double finest_mm = std::max(kFinestMm, reference.geometry.spacing_mm.maxCoeff());
  std::vector<ImagePair> out;
  for (int n = 0; n < kGrids; ++n) {
    const volume::Geometry grid = CubicGrid(reference.geometry, finest_mm * (1 << n));
    out.push_back(n == 0 ? ImagePair{Averaged(reference, grid, 2), Averaged(phase, grid, 2)}
                         : ImagePair{Averaged(out.back().fixed, grid, 2),
                                     Averaged(out.back().moving, grid, 2)});
  }
  return out;
}

/// Where a place of the reference has moved to, CT space, mm.
using PlaceInPhase = std::function<Vector3d(const Vector3d&)>;

/// Demons from coarse to fine: 60 steps on each grid, smoothed by one and a half voxels.
template <class Demons>
PlaceInPhase ByDemons(const std::vector<ImagePair>& pyramid) {
  ItkField::Pointer field;
  for (std::size_t n = pyramid.size(); n-- > 0;) {
    auto demons = Demons::New();
    demons->SetFixedImage(InItk(pyramid[n].fixed));
    demons->SetMovingImage(InItk(pyramid[n].moving));
    demons->SetNumberOfIterations(60);
    demons->SetStandardDeviations(1.5);
    demons->SmoothDisplacementFieldOn();
    if (field != nullptr) {
      auto finer = itk::ResampleImageFilter<ItkField, ItkField>::New();
      finer->SetInput(field);
      finer->SetOutputParametersFromImage(EmptyOn<ItkField>(pyramid[n].fixed.geometry));
      finer->SetInterpolator(itk::LinearInterpolateImageFunction<ItkField, double>::New());
      finer->Update();
      demons->SetInitialDisplacementField(finer->GetOutput());
    }
    demons->Update();
    field = demons->GetOutput();
    field->DisconnectPipeline();
  }
  auto between = itk::LinearInterpolateImageFunction<ItkField, double>::New();
  between->SetInputImage(field);
  return [field, between](const Vector3d& p) -> Vector3d {
    ItkField::PointType at;
    for (unsigned axis = 0; axis < 3; ++axis) at[axis] = p[axis];
    if (!between->IsInsideBuffer(at)) return p;
    const auto u = between->Evaluate(at);
    return p + Vector3d(u[0], u[1], u[2]);
  };
}

/// B-splines with nodes some 40, 20 and 10 mm apart, mean squares of a fifth of the voxels.
PlaceInPhase ByBSplines(const std::vector<ImagePair>& pyramid) {
  using Transform = itk::BSplineTransform<double, 3, 3>;
  using Method = itk::ImageRegistrationMethodv4<ItkImage, ItkImage, Transform>;
  using Adaptor = itk::BSplineTransformParametersAdaptor<Transform>;
  const volume::Geometry& g = pyramid.front().fixed.geometry;
  auto transform = Transform::New();
  Transform::PhysicalDimensionsType extent;
  Transform::MeshSizeType mesh;
  Transform::OriginType origin;
  Transform::DirectionType direction;
  for (unsigned axis = 0; axis < 3; ++axis) {
    extent[axis] = g.spacing_mm[axis] * static_cast<double>(g.size[axis] - 1);
    mesh[axis] =
        std::max<itk::SizeValueType>(1, static_cast<itk::SizeValueType>(extent[axis] / 40.0));
    origin[axis] = g.origin_mm[axis];
    for (unsigned row = 0; row < 3; ++row) direction[row][axis] = g.direction(row, axis);
  }
  transform->SetTransformDomainOrigin(origin);
  transform->SetTransformDomainDirection(direction);
  transform->SetTransformDomainPhysicalDimensions(extent);
  transform->SetTransformDomainMeshSize(mesh);
  transform->SetIdentity();

  auto optimizer = itk::LBFGS2Optimizerv4::New();
  optimizer->SetMaximumIterations(40);
  auto method = Method::New();
  method->SetFixedImage(InItk(pyramid.front().fixed));
  method->SetMovingImage(InItk(pyramid.front().moving));
  method->SetMetric(itk::MeanSquaresImageToImageMetricv4<ItkImage, ItkImage>::New());
  method->SetOptimizer(optimizer);
  method->SetInitialTransform(transform);
  method->InPlaceOn();
  method->SetMetricSamplingStrategy(Method::MetricSamplingStrategyEnum::REGULAR);
  method->SetMetricSamplingPercentage(0.2);
  method->SetNumberOfLevels(kGrids);
  Method::ShrinkFactorsArrayType shrink(kGrids);
  Method::SmoothingSigmasArrayType sigma(kGrids);
  Method::TransformParametersAdaptorsContainerType adaptors;
  for (unsigned n = 0; n < kGrids; ++n) {
    shrink[n] = 1U << (kGrids - 1 - n);
    sigma[n] = n + 1 < kGrids ? 0.5 * static_cast<double>(shrink[n]) : 0.0;
    auto adaptor = Adaptor::New();
    adaptor->SetTransform(transform);
    Transform::MeshSizeType finer = mesh;
    for (unsigned axis = 0; axis < 3; ++axis) finer[axis] <<= n;
    adaptor->SetRequiredTransformDomainMeshSize(finer);
    adaptor->SetRequiredTransformDomainOrigin(origin);
    adaptor->SetRequiredTransformDomainDirection(direction);
    adaptor->SetRequiredTransformDomainPhysicalDimensions(extent);
    adaptors.push_back(adaptor.GetPointer());
  }
  method->SetShrinkFactorsPerLevel(shrink);
  method->SetSmoothingSigmasPerLevel(sigma);
  method->SetSmoothingSigmasAreSpecifiedInPhysicalUnits(false);
  method->SetTransformParametersAdaptorsPerLevel(adaptors);
  method->Update();
  return [transform](const Vector3d& p) -> Vector3d {
    Transform::InputPointType at;
    for (unsigned axis = 0; axis < 3; ++axis) at[axis] = p[axis];
    const auto moved = transform->TransformPoint(at);
    return {moved[0], moved[1], moved[2]};
  };
}

PlaceInPhase RegisteredBy(const std::string& method, const std::vector<ImagePair>& pyramid) {
  using itk::DiffeomorphicDemonsRegistrationFilter;
  using itk::FastSymmetricForcesDemonsRegistrationFilter;
  if (method == "demons") {
    return ByDemons<DiffeomorphicDemonsRegistrationFilter<ItkImage, ItkImage, ItkField>>(pyramid);
  }
  if (method == "symmetric") {
    return ByDemons<FastSymmetricForcesDemonsRegistrationFilter<ItkImage, ItkImage, ItkField>>(
        pyramid);
  }
  ACUS_REQUIRE(method == "bspline", "method '", method, "'; demons, symmetric or bspline");
  return ByBSplines(pyramid);
}

/// Error of every landmark: mm, tissue, distance to the wall.
void PrintErrors(const fs::path& folder, const std::string& reference, const std::string& phase,
                 const PlaceInPhase& place) {
  const auto known = breathing_registration::ReadKnownLandmarks(folder / "landmarks.csv");
  for (const auto& point : known.points) {
    const Vector3d found = place(point.at_mm.at(reference));
    std::cout << (found - point.at_mm.at(phase)).norm() << " " << point.tissue << " "
              << point.wall_mm << "\n";
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    ACUS_REQUIRE(argc == 5, "usage: bench_itk_registration METHOD FOLDER REFERENCE PHASE");
    itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(2);
    const fs::path folder = argv[2];
    const auto reference = volume::ReadCt(folder / argv[3], "", {});
    const auto phase = volume::ReadCt(folder / argv[4], "", {});
    PrintErrors(folder, argv[3], argv[4], RegisteredBy(argv[1], Pyramid(reference, phase)));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "bench_itk_registration: " << error.what() << "\n";
    return 1;
  }
}
