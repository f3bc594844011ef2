// Files that the viewer writes: pictures that are whole, videos that last as long as what they show.
#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

#include <osg/Image>
#include <osgDB/ReadFile>

#include "tests/support/files.h"
#include "tests/support/process.h"
#include "viewer/capture.h"

namespace palp::test {
namespace {

class CaptureTest : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }
  ScratchFolder folder_;
};

// Red at the bottom, blue at the top.
Picture picture(int width, int height) {
  Picture p{width, height, std::vector<std::uint8_t>(3u * static_cast<std::size_t>(width * height))};
  for (std::size_t i = 0; i < p.rgb.size(); i += 3) p.rgb[i + (i < p.rgb.size() / 2 ? 0 : 2)] = 250;
  return p;
}

// Returns the value that ffprobe prints for an entry of the stream.
std::string probe(const std::string& file, const std::string& entry) {
  const Outcome probed =
      run_program({"ffprobe", "-v", "error", "-count_frames", "-select_streams", "v:0", "-show_entries",
                   "stream=" + entry, "-of", "default=nokey=1:noprint_wrappers=1", file});
  return probed.output.substr(0, probed.output.find('\n'));
}

TEST_F(CaptureTest, APngHoldsThePicture) {
  Capture capture;
  capture.write_png(path("a.png"), picture(64, 32));
  EXPECT_TRUE(capture.finish());
  osg::ref_ptr<osg::Image> image = osgDB::readRefImageFile(path("a.png"));
  ASSERT_TRUE(image);
  EXPECT_EQ(image->s(), 64);
  EXPECT_EQ(image->t(), 32);
  EXPECT_GT(image->getColor(3, 2).r(), 0.9f);  // OSG's images begin at the bottom
  EXPECT_GT(image->getColor(3, 29).b(), 0.9f);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1) << "no half file is left";
}

TEST_F(CaptureTest, AFolderThatIsNotThereIsSaidAndCounted) {
  Capture capture;
  capture.write_png(path("nowhere/a.png"), picture(8, 8));
  EXPECT_FALSE(capture.finish());
  EXPECT_THROW(Capture().open_video(path("nowhere/a.mp4"), 64, 32, 30), std::runtime_error);
}

TEST_F(CaptureTest, AVideoKeepsThePaceOfTheClock) {
  Capture capture;
  capture.open_video(path("v.mp4"), 65, 33, 20);  // odd sizes lose a pixel
  for (const double time : {0.0, 0.05, 0.5, 0.501, 1.0}) EXPECT_TRUE(capture.write_video(picture(65, 33), time));
  EXPECT_FALSE(capture.write_video(picture(64, 32), 1.1)) << "another size";
  EXPECT_TRUE(capture.finish());
  EXPECT_EQ(probe(path("v.mp4"), "nb_read_frames"), "21");  // 0 to 1 s at 20 a second
  EXPECT_EQ(probe(path("v.mp4"), "width"), "64");
  EXPECT_EQ(capture.dropped_video_pictures(), 1u);
}

}  // namespace
}  // namespace palp::test
