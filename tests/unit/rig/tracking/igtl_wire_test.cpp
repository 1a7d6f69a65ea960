#include "acus/rig/tracking/igtl_wire.h"

#include <cstring>
#include <gtest/gtest.h>
#include <igtlImageMessage.h>
#include <igtlPointMessage.h>
#include <igtlPositionMessage.h>
#include <igtlQuaternionTrackingDataMessage.h>
#include <igtlStatusMessage.h>
#include <igtlTrackingDataMessage.h>
#include <igtlTransformMessage.h>
#include <igtl_header.h>
#include <igtl_ndarray.h>

#include "acus/base/math/rigid.h"

namespace acus::tracking {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix4d;
using Eigen::Vector3d;

// The truth is OpenIGTLink's own library: what it packs we read, what we pack it unpacks.

const transforms::Pose kIgtlWirePose(Eigen::Translation3d(12.5, -340.25, 1000.125) *
                                     AngleAxisd(0.7, Vector3d(1, -2, 3).normalized()));

void Set(igtl::Matrix4x4& to, const Matrix4d& from) {
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) to[i][j] = static_cast<float>(from(i, j));
  }
}

double Difference(const igtl::Matrix4x4& a, const Matrix4d& b) {
  double most = 0.0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) most = std::max(most, std::abs(a[i][j] - b(i, j)));
  }
  return most;
}

/// What a message of the library has on the wire.
template <typename Pointer>
Bytes Packed(Pointer& message) {
  message->Pack();
  const auto* data = static_cast<const std::uint8_t*>(message->GetPackPointer());
  return Bytes(data, data + message->GetPackSize());
}

/// Our reading of bytes, checksum and header included.
struct Opened {
  IgtlHeader header;
  Bytes bytes;
  ByteView content() const { return ByteView(bytes).subspan(kIgtlHeaderBytes); }
};
Opened Open(Bytes bytes) {
  const auto header = ParseHeader(bytes);
  EXPECT_TRUE(header.has_value());
  Opened opened{.header = header.value_or(IgtlHeader()), .bytes = std::move(bytes)};
  EXPECT_EQ(opened.header.body_bytes, opened.content().size());
  EXPECT_EQ(opened.header.crc, Crc64(opened.content()));
  return opened;
}

/// The library's reading of bytes, its checks included.
template <typename MessageType>
typename MessageType::Pointer Unpacked(const Bytes& bytes) {
  auto header = igtl::MessageHeader::New();
  header->InitPack();
  std::memcpy(header->GetPackPointer(), bytes.data(), kIgtlHeaderBytes);
  header->Unpack();
  auto message = MessageType::New();
  message->SetMessageHeader(header);
  message->AllocatePack();
  EXPECT_EQ(static_cast<std::size_t>(message->GetPackBodySize()), bytes.size() - kIgtlHeaderBytes);
  std::memcpy(message->GetPackBodyPointer(), bytes.data() + kIgtlHeaderBytes,
              bytes.size() - kIgtlHeaderBytes);
  EXPECT_TRUE(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) << "wrong checksum";
  return message;
}

TEST(IgtlWire, TransformGoesBothWays) {
  auto theirs = igtl::TransformMessage::New();
  theirs->SetDeviceName("ProbeToReference");
  igtl::Matrix4x4 matrix;
  Set(matrix, kIgtlWirePose.matrix());
  theirs->SetMatrix(matrix);
  auto stamp = igtl::TimeStamp::New();
  stamp->SetTime(1234567890u, 123456789u);
  theirs->SetTimeStamp(stamp);
  const Opened opened = Open(Packed(theirs));
  EXPECT_EQ(opened.header.type, "TRANSFORM");
  EXPECT_EQ(opened.header.device, "ProbeToReference");
  // The library's fractions of a second are off by some ns.
  EXPECT_NEAR(static_cast<double>(opened.header.time_ns - 1234567890123456789), 0.0, 10.0);
  const auto read = ReadTransform(opened.content());
  ASSERT_TRUE(read.has_value());
  EXPECT_LT((*read - kIgtlWirePose.matrix()).norm(), 1e-4) << "floats of 24 bits";
  EXPECT_TRUE(math::IsRigid(*read, 1e-6));

  const auto ours = Unpacked<igtl::TransformMessage>(
      PackTransform("ProbeToReference", 1234567890123456789, kIgtlWirePose));
  EXPECT_STREQ(ours->GetDeviceName(), "ProbeToReference");
  ours->GetMatrix(matrix);
  EXPECT_LT(Difference(matrix, kIgtlWirePose.matrix()), 1e-4);
  ours->GetTimeStamp(stamp);
  igtlUint32 seconds = 0, nanoseconds = 0;
  stamp->GetTimeStamp(&seconds, &nanoseconds);
  EXPECT_EQ(seconds, 1234567890u);
  EXPECT_NEAR(nanoseconds, 123456789.0, 10.0);
}

TEST(IgtlWire, AVolumeAndPointsAreWhatTheLibraryReads) {
  std::vector<std::int16_t> hu(4 * 3 * 2);
  for (std::size_t i = 0; i < hu.size(); ++i) hu[i] = static_cast<std::int16_t>(100 * i - 1024);
  Matrix4d ras_from_voxel = kIgtlWirePose.matrix();
  ras_from_voxel.col(0) *= 0.5;
  ras_from_voxel.col(1) *= 2.0;
  ras_from_voxel.col(2) *= 3.0;
  const auto volume = Unpacked<igtl::ImageMessage>(
      PackVolume("CT", 5, {.size = {4, 3, 2}, .voxels = hu, .ras_from_voxel = ras_from_voxel}));
  EXPECT_STREQ(volume->GetDeviceName(), "CT");
  int size[3];
  volume->GetDimensions(size);
  EXPECT_EQ(std::vector<int>(size, size + 3), (std::vector<int>{4, 3, 2}));
  EXPECT_EQ(volume->GetScalarType(), igtl::ImageMessage::TYPE_INT16);
  EXPECT_EQ(std::memcmp(volume->GetScalarPointer(), hu.data(), 2 * hu.size()), 0);
  igtl::Matrix4x4 matrix;
  volume->GetMatrix(matrix);
  igtlFloat32 spacing_mm[3];  // The library takes it out of the matrix.
  volume->GetSpacing(spacing_mm);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix[row][column] *= spacing_mm[column];
  }
  Matrix4d expected = ras_from_voxel;
  expected.col(3) += ras_from_voxel * Eigen::Vector4d(1.5, 1.0, 0.5, 0.0);
  EXPECT_LT(Difference(matrix, expected), 1e-3);

  const NamedPoint points[] = {{.name = "entry", .ras_mm = {1, 2, 3}},
                               {.name = "target", .ras_mm = {-4, 5, 6}, .diameter_mm = 6.0}};
  const auto read = Unpacked<igtl::PointMessage>(PackPoints("Targets", 5, points));
  ASSERT_EQ(read->GetNumberOfPointElement(), 2);
  igtl::PointElement::Pointer point;
  read->GetPointElement(1, point);
  EXPECT_STREQ(point->GetName(), "target");
  igtlFloat32 at[3];
  point->GetPosition(at);
  EXPECT_EQ(Vector3d(at[0], at[1], at[2]), Vector3d(-4, 5, 6));
  EXPECT_EQ(point->GetRadius(), 6.0F) << "the protocol's DIAMETER, which the library calls radius";
}

TEST(IgtlWire, TrackingDataGoesBothWays) {
  auto theirs = igtl::TrackingDataMessage::New();
  for (const char* name : {"Channel 0", "a name of twenty characters"}) {
    auto element = igtl::TrackingDataElement::New();
    element->SetName(std::string(name).substr(0, 19).c_str());
    element->SetType(igtl::TrackingDataElement::TYPE_6D);
    igtl::Matrix4x4 matrix;
    Set(matrix, kIgtlWirePose.matrix());
    element->SetMatrix(matrix);
    theirs->AddTrackingDataElement(element);
  }
  const auto tools = ReadTrackingData(Open(Packed(theirs)).content());
  ASSERT_TRUE(tools.has_value());
  ASSERT_EQ(tools->size(), 2u);
  EXPECT_EQ((*tools)[0].name, "Channel 0");
  EXPECT_LT(((*tools)[1].matrix - kIgtlWirePose.matrix()).norm(), 1e-4);

  const std::pair<std::string, transforms::Pose> sent[] = {{"Needle", kIgtlWirePose},
                                                           {"Probe", {}}};
  const auto ours = Unpacked<igtl::TrackingDataMessage>(PackTrackingData("Acus", 5, sent));
  ASSERT_EQ(ours->GetNumberOfTrackingDataElements(), 2);
  igtl::TrackingDataElement::Pointer element;
  ours->GetTrackingDataElement(0, element);
  EXPECT_STREQ(element->GetName(), "Needle");
  igtl::Matrix4x4 matrix;
  element->GetMatrix(matrix);
  EXPECT_LT(Difference(matrix, kIgtlWirePose.matrix()), 1e-4);

  const auto start = Unpacked<igtl::StartTrackingDataMessage>(PackStartTrackingData("Acus", 20));
  EXPECT_EQ(start->GetResolution(), 20);
  auto request = igtl::StartTrackingDataMessage::New();
  request->SetResolution(50);
  request->SetCoordinateName("Patient");
  EXPECT_EQ(ReadStartTrackingData(Open(Packed(request)).content()), 50);
}

TEST(IgtlWire, PositionsAndQuaternionsAreRead) {
  const Eigen::Quaterniond& q = kIgtlWirePose.quaternion();
  auto position = igtl::PositionMessage::New();
  position->SetPosition(12.5f, -340.25f, 1000.125f);
  position->SetQuaternion(static_cast<float>(q.x()), static_cast<float>(q.y()),
                          static_cast<float>(q.z()), static_cast<float>(q.w()));
  auto read = ReadPosition(Open(Packed(position)).content());
  ASSERT_TRUE(read.has_value());
  EXPECT_LT((*read - kIgtlWirePose.matrix()).norm(), 1e-4);
  // The short forms, cut by hand: the library's own packing of them writes past its buffer.
  const Opened whole = Open(Packed(position));
  read = ReadPosition(whole.content().first(24));
  ASSERT_TRUE(read.has_value());
  EXPECT_LT((*read - kIgtlWirePose.matrix()).norm(), 1e-4) << "w from the other three";
  EXPECT_FALSE(ReadPosition(whole.content().first(16)).has_value());
  read = ReadPosition(whole.content().first(12));
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ((*read)(1, 3), -340.25);
  EXPECT_EQ((*read)(0, 0), 1.0);

  auto list = igtl::QuaternionTrackingDataMessage::New();
  auto element = igtl::QuaternionTrackingDataElement::New();
  element->SetName("Stylus");
  element->SetPosition(12.5f, -340.25f, 1000.125f);
  element->SetQuaternion(static_cast<float>(q.x()), static_cast<float>(q.y()),
                         static_cast<float>(q.z()), static_cast<float>(q.w()));
  list->AddQuaternionTrackingDataElement(element);
  const auto tools = ReadQuaternionTrackingData(Open(Packed(list)).content());
  ASSERT_TRUE(tools.has_value() && tools->size() == 1);
  EXPECT_EQ((*tools)[0].name, "Stylus");
  EXPECT_LT(((*tools)[0].matrix - kIgtlWirePose.matrix()).norm(), 1e-4);
}

TEST(IgtlWire, StatusGoesBothWays) {
  auto theirs = igtl::StatusMessage::New();
  theirs->SetCode(igtl::StatusMessage::STATUS_OK);
  theirs->SetStatusString("ready to track");
  EXPECT_EQ(ReadStatus(Open(Packed(theirs)).content()), "OK: ready to track");
  theirs->SetCode(igtl::StatusMessage::STATUS_NOT_READY);
  theirs->SetErrorName("Camera");
  EXPECT_EQ(ReadStatus(Open(Packed(theirs)).content()), "code 13: Camera: ready to track");
  const auto ours = Unpacked<igtl::StatusMessage>(PackStatus("Acus", 1, false, "no probe"));
  EXPECT_EQ(ours->GetCode(), igtl::StatusMessage::STATUS_NOT_READY);
  EXPECT_STREQ(ours->GetStatusString(), "no probe");
}

TEST(IgtlWire, ImagesKeepPixelsAndPlace) {
  for (const int channels : {1, 3}) {
    Image image{.width = 7, .height = 5, .channels = channels};
    for (int i = 0; i < 35 * channels; ++i) image.pixels.push_back(std::uint8_t(3 * i));
    image.reference_from_pixel = kIgtlWirePose.matrix();
    image.reference_from_pixel.col(0) *= 0.5;
    image.reference_from_pixel.col(1) *= 0.25;
    const Bytes bytes = PackImage("Ultrasound", 77, image);

    const auto theirs = Unpacked<igtl::ImageMessage>(bytes);
    int size[3];
    theirs->GetDimensions(size);
    EXPECT_EQ(size[0], 7);
    EXPECT_EQ(size[1], 5);
    EXPECT_EQ(theirs->GetNumComponents(), channels);
    EXPECT_EQ(std::memcmp(theirs->GetScalarPointer(), image.pixels.data(), 35 * channels), 0);
    float spacing[3];
    theirs->GetSpacing(spacing);
    EXPECT_NEAR(spacing[0], 0.5, 1e-6);
    EXPECT_NEAR(spacing[1], 0.25, 1e-6);
    // The protocol places the middle of the image: pixel (3, 2) here.
    float origin[3];
    theirs->GetOrigin(origin);
    const Eigen::Vector4d middle = image.reference_from_pixel * Eigen::Vector4d(3, 2, 0, 1);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(origin[i], middle[i], 1e-4);

    const auto back = ReadImage(Open(bytes).content());
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(back->pixels, image.pixels);
    EXPECT_EQ(back->channels, channels);
    EXPECT_LT((back->reference_from_pixel - image.reference_from_pixel).norm(), 1e-3);
  }
}

TEST(IgtlWire, ImagesThatAreNotImagesAreTurnedDown) {
  auto volume = igtl::ImageMessage::New();
  volume->SetDimensions(4, 4, 2);
  volume->SetScalarType(igtl::ImageMessage::TYPE_UINT8);
  volume->AllocateScalars();
  EXPECT_FALSE(ReadImage(Open(Packed(volume)).content()).has_value());
  auto deep = igtl::ImageMessage::New();
  deep->SetDimensions(4, 4, 1);
  deep->SetScalarType(igtl::ImageMessage::TYPE_INT16);
  deep->AllocateScalars();
  EXPECT_FALSE(ReadImage(Open(Packed(deep)).content()).has_value());
}

TEST(IgtlWire, Protocol3CarriesWhetherAToolIsSeen) {
  for (const bool valid : {true, false}) {
    const Opened opened =
        Open(PackTransformWithStatus("ProbeToReference", 9, kIgtlWirePose, valid));
    EXPECT_EQ(opened.header.version, 2);
    const auto body = SplitBody(opened.header, opened.content());
    ASSERT_TRUE(body.has_value());
    ASSERT_EQ(body->metadata.size(), 2u);
    EXPECT_EQ(body->metadata[0].first, "TransformValid");
    EXPECT_EQ(SaysValid(body->metadata), valid);
    const auto matrix = ReadTransform(body->content);
    ASSERT_TRUE(matrix.has_value());
    EXPECT_LT((*matrix - kIgtlWirePose.matrix()).norm(), 1e-4);
  }
  EXPECT_TRUE(SaysValid({})) << "protocol 2 says nothing";
  EXPECT_FALSE(SaysValid({{"TransformStatus", "OUT_OF_VIEW"}}));
}

TEST(IgtlWire, SizesInsideABodyAreNotBelieved) {
  const Opened good = Open(PackTransformWithStatus("Probe", 9, kIgtlWirePose, true));
  for (std::size_t at = 0; at < 8; ++at) {
    Bytes body(good.content().begin(), good.content().end());
    body[at] = 0xff;
    const auto parts = SplitBody(good.header, body);
    if (parts) {
      EXPECT_LE(parts->content.size(), body.size()) << at;
    }
  }
  for (std::size_t size = 0; size < good.content().size(); ++size) {
    const auto parts = SplitBody(good.header, good.content().first(size));
    if (parts) {
      EXPECT_NE(parts->content.size(), 48u) << size;
    }
  }
}

TEST(IgtlWire, StampsKeepNanoseconds) {
  for (const std::int64_t time_ns :
       {std::int64_t{1}, std::int64_t{999'999'999}, std::int64_t{1'700'000'000'123'456'789}}) {
    EXPECT_LE(std::abs(NsFromStamp(StampFromNs(time_ns)) - time_ns), 1) << time_ns;
  }
  EXPECT_EQ(StampFromNs(0), 0u);
  EXPECT_EQ(StampFromNs(-5), 0u) << "a stamp before 1970 is none";
}

TEST(IgtlWire, TablesAndTextsKeepEveryBit) {
  const NumberTable table{.columns = 3, .values = {1.0, -0.1, 1e300, 5e-324, -0.0, 1.0 / 3.0}};
  const Bytes message = PackTable("Steps", 7, table);
  const auto header = ParseHeader(ByteView(message).first(kIgtlHeaderBytes));
  ASSERT_TRUE(header);
  EXPECT_EQ(header->type, "NDARRAY");
  EXPECT_EQ(header->time_ns, 7);
  const ByteView content = ByteView(message).subspan(kIgtlHeaderBytes);
  EXPECT_EQ(header->crc, Crc64(content));
  const auto read = ReadTable(content);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->columns, 3u);
  ASSERT_EQ(read->values.size(), 6u);
  EXPECT_EQ(std::memcmp(read->values.data(), table.values.data(), 48), 0);
  for (std::size_t size = 0; size < content.size(); ++size) {
    EXPECT_FALSE(ReadTable(content.first(size))) << size;
  }
  Bytes wrong(content.begin(), content.end());
  wrong[3] = 3;  // Rows.
  EXPECT_FALSE(ReadTable(wrong));
  wrong[3] = 2;
  wrong[0] = 10;  // 32-bit numbers.
  EXPECT_FALSE(ReadTable(wrong));

  const Bytes text = PackText("Images", "{\"a\": 1}");
  const ByteView body = ByteView(text).subspan(kIgtlHeaderBytes);
  EXPECT_EQ(ReadText(body), "{\"a\": 1}");
  for (std::size_t size = 0; size < body.size(); ++size) EXPECT_FALSE(ReadText(body.first(size)));
}

/// OpenIGTLink's own library reads what we pack.
TEST(IgtlWire, TheLibraryReadsTables) {
  const NumberTable table{.columns = 2, .values = {1.5, -2.25, 1.0 / 3.0, 1e-9, 4.0, 5.0}};
  Bytes message = PackTable("Steps", 7, table);
  igtl_ndarray_info info;
  igtl_ndarray_init_info(&info);
  ASSERT_EQ(igtl_ndarray_unpack(IGTL_TYPE_PREFIX_NONE, message.data() + kIgtlHeaderBytes, &info,
                                message.size() - kIgtlHeaderBytes),
            1);
  EXPECT_EQ(info.type, IGTL_NDARRAY_STYPE_TYPE_FLOAT64);
  ASSERT_EQ(info.dim, 2);
  EXPECT_EQ(info.size[0], 3);
  EXPECT_EQ(info.size[1], 2);
  EXPECT_EQ(std::memcmp(info.array, table.values.data(), 48), 0);
  igtl_ndarray_free_info(&info);
}

}  // namespace
}  // namespace acus::tracking
