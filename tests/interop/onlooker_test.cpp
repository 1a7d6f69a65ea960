// Who looks on: a client of OpenIGTLink's own library at a live session.
#include <atomic>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <igtlClientSocket.h>
#include <igtlImageMessage.h>
#include <igtlMessageHeader.h>
#include <igtlPointMessage.h>
#include <igtlStatusMessage.h>
#include <igtlTransformMessage.h>
#include <map>
#include <mutex>
#include <thread>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/xml_scan.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/data/volume/volume_io.h"
#include "acus/rig/tracking/socket.h"
#include "acus/run/live/live_session.h"
#include "support/layered_folder.h"
#include "support/temporary_folder.h"
#include "support/wait_until.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

template <typename Message>
typename Message::Pointer Body(igtl::Socket& socket, igtl::MessageHeader::Pointer header) {
  auto message = Message::New();
  message->SetMessageHeader(header);
  message->AllocatePack();
  socket.Receive(message->GetPackBodyPointer(), message->GetPackBodySize());
  // 1: with its checksum.
  return (message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) != 0 ? message : nullptr;
}

/// What came, the last of each name, and how often.
struct Received {
  std::map<std::string, int> count;  ///< "IMAGE CT"
  std::map<std::string, igtl::ImageMessage::Pointer> images;
  std::map<std::string, Eigen::Matrix4d> transforms;
  std::map<std::string, Eigen::Vector3d> points;
  std::string status;
  int broken = 0;
};

/// A client that receives in a thread of its own until it is destroyed.
class Onlooker {
 public:
  explicit Onlooker(int port) : socket_(igtl::ClientSocket::New()) {
    EXPECT_TRUE(testing_support::WaitUntil(
        [&] { return socket_->ConnectToServer("127.0.0.1", port) == 0; }));
    socket_->SetReceiveTimeout(100);
    thread_ = std::thread([this] { Run(); });
  }
  ~Onlooker() {
    stop_ = true;
    thread_.join();
    socket_->CloseSocket();
  }
  Received received() const {
    const std::lock_guard lock(mutex_);
    return received_;
  }
  bool Has(const std::string& what) const { return received().count.contains(what); }

 private:
  void Run() {
    auto header = igtl::MessageHeader::New();
    while (!stop_) {
      header->InitPack();
      if (socket_->Receive(header->GetPackPointer(), header->GetPackSize()) !=
          header->GetPackSize()) {
        continue;
      }
      header->Unpack();
      Take(header);
    }
  }

  void Take(igtl::MessageHeader::Pointer header) {
    const std::string type = header->GetDeviceType();
    const std::string name = header->GetDeviceName();
    socket_->SetReceiveTimeout(20'000);
    bool is_whole = true;
    if (type == "IMAGE") {
      const auto image = Body<igtl::ImageMessage>(*socket_, header);
      is_whole = image.IsNotNull();
      const std::lock_guard lock(mutex_);
      received_.images[name] = image;
    } else if (type == "TRANSFORM") {
      const auto transform = Body<igtl::TransformMessage>(*socket_, header);
      is_whole = transform.IsNotNull();
      if (is_whole) {
        igtl::Matrix4x4 matrix;
        transform->GetMatrix(matrix);
        const std::lock_guard lock(mutex_);
        for (int i = 0; i < 16; ++i)
          received_.transforms[name](i / 4, i % 4) = matrix[i / 4][i % 4];
      }
    } else if (type == "POINT") {
      const auto points = Body<igtl::PointMessage>(*socket_, header);
      is_whole = points.IsNotNull();
      for (int i = 0; is_whole && i < points->GetNumberOfPointElement(); ++i) {
        igtl::PointElement::Pointer point;
        points->GetPointElement(i, point);
        igtlFloat32 at[3];
        point->GetPosition(at);
        const std::lock_guard lock(mutex_);
        received_.points[point->GetName()] = Eigen::Vector3d(at[0], at[1], at[2]);
      }
    } else if (type == "STATUS") {
      const auto status = Body<igtl::StatusMessage>(*socket_, header);
      is_whole = status.IsNotNull();
      const std::lock_guard lock(mutex_);
      if (is_whole) received_.status = status->GetStatusString();
    } else {
      socket_->Skip(header->GetBodySizeToRead(), 0);
    }
    socket_->SetReceiveTimeout(100);
    const std::lock_guard lock(mutex_);
    ++received_.count[type + " " + name];
    if (!is_whole) ++received_.broken;
  }

  igtl::ClientSocket::Pointer socket_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  Received received_;
  std::thread thread_;
};

/// A session with two virtual hands in the layered patient, whose reference frame is turned.
class ALiveSession : public testing::Test {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(
        folder_, R"({"needle_force": {}, "ultrasound": {}, "ct_slice": {}})");
    WriteTextFile(folder_ / "corridor.csv", "name,x_mm,y_mm,z_mm\ntarget,1,20,18\nentry,2,20,0\n");
    WriteTextFile(folder_ / "reference.tfm",
                  "#Insight Transform File V1.0\n#Transform 0\nTransform: "
                  "AffineTransform_double_3_3\nParameters: 0 -1 0 1 0 0 0 0 1 10 20 30\n"
                  "FixedParameters: 0 0 0\n");
    port_ = tracking::PortOf(tracking::ListenTcp("127.0.0.1", 0));
    WriteTextFile(folder_ / "devices.json", Message(R"({"format": "acus-devices/1", "devices": [
      {"name": "right", "driver": "virtual_hand", "virtual_hand": {"repeats": true, "path": [
        {"time_s": 0, "translation_mm": [0, 0, -35]}, {"time_s": 1, "translation_mm": [0, 0, -10]},
        {"time_s": 2, "translation_mm": [0, 0, -35]}]}},
      {"name": "left", "driver": "virtual_hand"}],
      "needle": {"device": "right"}, "probe": {"device": "left"},
      "send_out": {"host": "localhost", "port": )",
                                                    port_, "}}"));
    LiveOptions options;
    options.session_folder = folder_ / "session";
    session_.emplace(
        scenario::ReadScenario(
            folder_ / "scene.json",
            std::vector<scenario::Override>{
                {"/patient/corridor", (folder_ / "corridor.csv").string()},
                {"/patient/ct_from_reference_file", (folder_ / "reference.tfm").string()}}),
        ReadLiveDevices(folder_ / "devices.json"), options, context_);
    session_->Start();
  }

  bool PollUntil(const std::function<bool()>& done) {
    return testing_support::WaitUntil([&] {
      EXPECT_TRUE(session_->Poll());
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      return done();
    });
  }

  testing_support::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
  RunContext context_;
  int port_ = 0;
  std::optional<LiveSession> session_;
};

Eigen::Matrix4d MatrixOf(igtl::ImageMessage& image) {
  igtl::Matrix4x4 of_middle;
  image.GetMatrix(of_middle);
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = of_middle[i / 4][i % 4];
  igtlFloat32 spacing_mm[3];  // The library takes it out of the matrix.
  image.GetSpacing(spacing_mm);
  for (int i = 0; i < 3; ++i) matrix.col(i) *= spacing_mm[i];
  int size[3];
  image.GetDimensions(size);
  matrix.col(3) -=
      matrix * Eigen::Vector4d(0.5 * (size[0] - 1), 0.5 * (size[1] - 1), 0.5 * (size[2] - 1), 0.0);
  return matrix;
}

TEST_F(ALiveSession, ShowsPatientTargetStatusToolsAndImages) {
  const Onlooker onlooker(port_);
  const std::vector<std::string> once = {"IMAGE CT", "IMAGE Labels", "POINT Targets",
                                         "TRANSFORM ReferenceToRas", "TRANSFORM TargetToRas"};
  EXPECT_TRUE(PollUntil([&] {
    const Received now = onlooker.received();
    for (const std::string& what : once) {
      if (!now.count.contains(what)) return false;
    }
    return now.count.contains("STATUS Acus") && now.count.contains("TRANSFORM ProbeToReference") &&
           now.count.contains("TRANSFORM NeedleToReference") &&
           now.count.contains("IMAGE Ultrasound") && now.count.at("IMAGE Ultrasound") >= 10;
  }));
  const Received all = onlooker.received();
  EXPECT_EQ(all.broken, 0);
  for (const std::string& what : once) EXPECT_EQ(all.count.at(what), 1) << what;
  EXPECT_THAT(all.status, HasSubstr("Running: Layers"));

  const Eigen::DiagonalMatrix<double, 4> ras_from_lps(-1, -1, 1, 1);
  Eigen::Matrix4d ct_from_reference = session_->scene().ct_from_reference.matrix();
  EXPECT_TRUE(all.transforms.at("ReferenceToRas").isApprox(ras_from_lps * ct_from_reference, 1e-6));
  EXPECT_TRUE(all.points.at("target").isApprox(Eigen::Vector3d(-1, -20, 18), 1e-6));
  EXPECT_TRUE(all.points.at("entry").isApprox(Eigen::Vector3d(-2, -20, 0), 1e-6));
  EXPECT_TRUE(all.transforms.at("TargetToRas")
                  .col(3)
                  .head<3>()
                  .isApprox(Eigen::Vector3d(-1, -20, 18), 1e-6));

  const volume::CtVolume ct = volume::ReadCt(folder_ / "ct.nrrd", "", RunContext());
  igtl::ImageMessage& sent = *all.images.at("CT");
  int size[3];
  sent.GetDimensions(size);
  EXPECT_EQ(size[0] * size[1] * size[2], static_cast<int>(ct.voxels.size()));
  EXPECT_EQ(sent.GetScalarType(), igtl::ImageMessage::TYPE_INT16);
  EXPECT_EQ(sent.GetEndian(), igtl::ImageMessage::ENDIAN_LITTLE);
  const auto* hu = static_cast<const std::int16_t*>(sent.GetScalarPointer());
  EXPECT_TRUE(std::equal(ct.voxels.begin(), ct.voxels.end(), hu));
  EXPECT_TRUE(MatrixOf(sent).isApprox(ras_from_lps * ct.geometry.ct_from_index().matrix(), 1e-5));
  const volume::LabelMap labels = volume::ReadLabelMap(folder_ / "labels.seg.nrrd");
  igtl::ImageMessage& map = *all.images.at("Labels");
  EXPECT_TRUE(std::equal(labels.voxels.begin(), labels.voxels.end(),
                         static_cast<const std::uint8_t*>(map.GetScalarPointer())));
}

TEST_F(ALiveSession, SendsALateOnlookerAllAndAnEarlyOneNothingTwice) {
  const Onlooker early(port_);
  EXPECT_TRUE(PollUntil([&] { return early.Has("IMAGE CT") && early.Has("STATUS Acus"); }));
  const Onlooker late(port_);
  EXPECT_TRUE(PollUntil([&] {
    return late.Has("IMAGE CT") && late.Has("STATUS Acus") && late.Has("POINT Targets");
  }));
  EXPECT_EQ(early.received().count.at("IMAGE CT"), 1);
  EXPECT_EQ(late.received().count.at("IMAGE CT"), 1);
}

// The scene that Slicer opens names the server, and has a node of the right kind for all of it.
TEST_F(ALiveSession, HasASceneWithANodeForAllThatIsSent) {
  const Onlooker onlooker(port_);
  EXPECT_TRUE(PollUntil([&] {
    return onlooker.Has("IMAGE Ultrasound") && onlooker.Has("TRANSFORM NeedleToReference") &&
           onlooker.Has("IMAGE Labels");
  }));
  const fs::path file = folder_ / "session" / "slicer.mrml";
  const auto elements = core::ScanXml(ReadTextFile(file), file.string());
  std::map<std::string, std::string> tag_of;             // By id.
  std::map<std::string, const core::XmlElement*> named;  // "LinearTransform ProbeToReference"
  for (const auto& element : elements) {
    if (const auto id = element.Attribute("id")) {
      EXPECT_TRUE(tag_of.emplace(*id, element.name).second) << *id;
    }
    named[element.name + " " + element.Attribute("name").value_or("")] = &element;
  }
  const auto& connector = *named.at("IGTLConnector Acus");
  EXPECT_EQ(connector.Attribute("serverPort"), std::to_string(port_));
  EXPECT_EQ(connector.Attribute("serverHostname"), "localhost");
  EXPECT_EQ(connector.Attribute("connectorType"), "CLIENT");
  for (const auto& [what, count] : onlooker.received().count) {
    const std::string name = what.substr(what.find(' ') + 1);
    if (what.starts_with("IMAGE")) {
      EXPECT_TRUE(named.contains("Volume " + name)) << what;
    } else if (what.starts_with("TRANSFORM")) {
      EXPECT_TRUE(named.contains("LinearTransform " + name)) << what;
    }
  }
  // Every reference leads to a node of the scene, or to a colour table of Slicer's own.
  for (const auto& element : elements) {
    std::istringstream references(element.Attribute("references").value_or(""));
    for (std::string reference; std::getline(references, reference, ';');) {
      const std::string id = reference.substr(reference.find(':') + 1);
      EXPECT_TRUE(tag_of.contains(id) || id.starts_with("vtkMRMLColorTableNode")) << reference;
    }
    if (const auto stored = element.Attribute("fileName")) {
      EXPECT_TRUE(fs::exists(file.parent_path() / *stored)) << *stored;
    }
  }
  const auto parent = [&](const std::string& node) {
    return named.at(node)->Attribute("references").value_or("");
  };
  const std::string reference = *named.at("LinearTransform ReferenceToRas")->Attribute("id");
  for (const char* child : {"LinearTransform ProbeToReference", "LinearTransform NeedleToReference",
                            "Volume Ultrasound"}) {
    EXPECT_THAT(parent(child), HasSubstr("transform:" + reference + ";")) << child;
  }
  EXPECT_THAT(parent("Volume CT"), testing::Not(HasSubstr("transform:")));
}

TEST_F(ALiveSession, HasItsTargetsAsMarkups) {
  const auto targets = transforms::ReadLandmarks(folder_ / "session" / "target.mrk.json");
  EXPECT_THAT(targets.names, testing::ElementsAre("entry", "target"));
  EXPECT_TRUE(targets.points_mm.col(1).isApprox(Eigen::Vector3d(1, 20, 18)));
}

}  // namespace
}  // namespace acus::live
