#include "tactile/capture/find_sources.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/capture/camera_streams.hpp"
#include "tactile/capture/libcaer_camera.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/transport/dv/dv_stream_server.hpp"

namespace tactile::capture {
namespace {

namespace fs = std::filesystem;

/// A sysfs of our own, and a folder for devices.
class FindSources : public testing::Test {
 protected:
  void add_usb(const std::string& port, const std::string& vendor, const std::string& product, const std::string& version,
               const std::string& serial, const std::string& name = "") const {
    const fs::path device = places_.sysfs / "bus" / "usb" / "devices" / port;
    write_whole(device / "idVendor", vendor + "\n");
    write_whole(device / "idProduct", product + "\n");
    write_whole(device / "bcdDevice", version + "\n");
    if (!serial.empty()) write_whole(device / "serial", serial + "\n");
    if (!name.empty()) write_whole(device / "product", name + "\n");
  }
  void add_video(const std::string& node, const std::string& name, const std::string& index, const std::string& serial) const {
    const fs::path entry = places_.sysfs / "class" / "video4linux" / node;
    write_whole(entry / "name", name + "\n");
    write_whole(entry / "index", index + "\n");
    // The entry's `device` is a link to the interface, below the USB device that knows the serial number.
    const fs::path usb = places_.sysfs / "usb-of" / node;
    fs::create_directories(usb / "1-1:1.0");
    if (!serial.empty()) write_whole(usb / "serial", serial + "\n");
    fs::create_directory_symlink(usb / "1-1:1.0", entry / "device");
    write_whole(places_.devices / node, "");
  }

  test::TemporaryFolder folder_;
  // Port 1 of this machine has no DV stream.
  SourcePlaces places_{.sysfs = folder_ / "sys", .devices = folder_ / "dev", .stream = "tcp://127.0.0.1:1"};
};

TEST_F(FindSources, FindsNothingWhereNothingIs) {
  EXPECT_TRUE(find_camera_sources(places_).empty());
  EXPECT_TRUE(find_video_devices(places_).empty());
}

TEST_F(FindSources, DistinguishesTheVendorsCamerasAndShowsHowToReachThem) {
  add_usb("1-1", "152a", "8419", "0409", "DXM00017");
  add_usb("1-2", "152a", "8419", "040a", "DXM00018");
  add_usb("2-1", "152a", "8419", "0108", "DXA00003");
  add_usb("2-2", "152a", "841a", "0004", "", "DAVIS346");
  add_usb("3-1", "046d", "0825", "0012", "ABCD", "Webcam");
  add_usb("usb1", "1d6b", "0002", "0601", "0000:00:14.0");
  const std::vector<FoundSource> found = find_camera_sources(places_);
  ASSERT_EQ(found.size(), 4U);
  for (const FoundSource& source : found) EXPECT_EQ(source.text, "") << "none can be opened: they are not there";
  const auto begins = [&](std::size_t i, const std::string& text) { return found[i].description.find(text) == 0; };
  EXPECT_TRUE(begins(0, "DVXplorer Mini DXM00017, firmware 9: ")) << found[0].description;
  EXPECT_TRUE(begins(1, "DVXplorer Mini DXM00018, firmware 10: ")) << found[1].description;
  EXPECT_TRUE(begins(2, "DVXplorer DXA00003, firmware 8: ")) << found[2].description;
  EXPECT_TRUE(begins(3, "DAVIS346, firmware 4: ")) << found[3].description;
  for (const std::size_t i : {1U, 3U}) {
    EXPECT_NE(found[i].description.find("libcaer does not support it; run scripts/dv-bridge"), std::string::npos);
  }
  for (const std::size_t i : {0U, 2U}) {
    EXPECT_NE(found[i].description.find(is_built_with_libcaer() ? "cannot be opened" : "no libcaer; run scripts/dv-bridge"),
              std::string::npos)
        << found[i].description;
  }
}

TEST_F(FindSources, IsNotPutOffByWhatItCannotRead) {
  add_usb("1-1", "152a", "8419", "garbage", "");
  write_whole(places_.sysfs / "bus" / "usb" / "devices" / "1-3" / "idVendor", "");
  write_whole(places_.sysfs / "bus" / "usb" / "devices" / "1-4" / "uevent", "");
  const std::vector<FoundSource> found = find_camera_sources(places_);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].description.find("DVXplorer, firmware 0: "), 0U) << found[0].description;
}

TEST_F(FindSources, FindsAStreamThatAnswers) {
  events::Stream stream = events::event_stream_declaration({640, 480}, "DVXplorer_DXM00001");
  set_info(stream, readout_mode_attribute, "variable-5000");
  transport::NetworkAddress address;
  address.host = "127.0.0.1";
  transport::DvStreamServer server(address, stream);
  places_.stream = server.address().text();
  places_.stream_patience = std::chrono::seconds(30);
  const std::vector<FoundSource> found = find_camera_sources(places_);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].text, server.address().text());
  EXPECT_EQ(found[0].description, "DV stream of events from DVXplorer_DXM00001, 640x480, read-out variable-5000");
}

TEST_F(FindSources, ListsVideoDevicesThatTakePictures) {
  add_video("video10", "Webcam C270", "0", "5A2B");
  add_video("video11", "Webcam C270", "1", "5A2B");
  add_video("video2", "Capture card", "0", "");
  write_whole(places_.sysfs / "class" / "video4linux" / "v4l-subdev0" / "name", "sensor\n");
  const std::vector<FoundSource> found = find_video_devices(places_);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].text, (places_.devices / "video2").string());
  EXPECT_EQ(found[0].description, "Capture card");
  EXPECT_EQ(found[1].text, (places_.devices / "video10").string());
  EXPECT_EQ(found[1].description, "Webcam C270, serial 5A2B");
}

}  // namespace
}  // namespace tactile::capture
