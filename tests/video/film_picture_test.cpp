#include "tactile/video/film_picture.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace tactile::video {
namespace {

TEST(FilmPicture, IsThePictureWhereItFits) {
  const cv::Mat grey = (cv::Mat_<unsigned char>(2, 2) << 1, 2, 3, 4);
  EXPECT_EQ(cv::norm(film_picture(grey, {2, 2}), grey, cv::NORM_INF), 0);
  const cv::Mat colour(2, 4, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(cv::norm(film_picture(colour, {4, 2}), colour, cv::NORM_INF), 0);
}

TEST(FilmPicture, RepeatsTheLastRowAndColumnOfOddSides) {
  const cv::Mat odd = (cv::Mat_<unsigned char>(1, 3) << 1, 2, 3);
  const cv::Mat even = (cv::Mat_<unsigned char>(2, 4) << 1, 2, 3, 3, 1, 2, 3, 3);
  EXPECT_EQ(film_size({3, 1}), cv::Size(4, 2));
  EXPECT_EQ(cv::norm(film_picture(odd, {3, 1}), even, cv::NORM_INF), 0);
}

TEST(FilmPicture, KeepsTheFilmsSizeWhateverThePictures) {
  const cv::Mat large(128, 60, CV_8UC3, cv::Scalar::all(180));
  const cv::Mat picture = film_picture(large, {95, 63});
  EXPECT_EQ(picture.size(), cv::Size(96, 64));
  EXPECT_EQ(cv::norm(picture, cv::Mat(64, 96, CV_8UC3, cv::Scalar::all(180)), cv::NORM_INF), 0);
}

TEST(FilmPicture, LeavesAlphaAndTheLowerBitsOut) {
  const cv::Mat with_alpha(2, 2, CV_8UC4, cv::Scalar(1, 2, 3, 99));
  EXPECT_EQ(cv::norm(film_picture(with_alpha, {2, 2}), cv::Mat(2, 2, CV_8UC3, cv::Scalar(1, 2, 3)), cv::NORM_INF), 0);
  const cv::Mat deep = (cv::Mat_<unsigned short>(2, 2) << 0, 255, 256, 65535);
  const cv::Mat upper = (cv::Mat_<unsigned char>(2, 2) << 0, 0, 1, 255);
  EXPECT_EQ(cv::norm(film_picture(deep, {2, 2}), upper, cv::NORM_INF), 0);
}

TEST(FilmPicture, IsEmptyForOtherPixels) {
  EXPECT_TRUE(film_picture({}, {2, 2}).empty());
  EXPECT_TRUE(film_picture(cv::Mat(2, 2, CV_32FC1), {2, 2}).empty());
  EXPECT_TRUE(film_picture(cv::Mat(2, 2, CV_8UC2), {2, 2}).empty());
}

}  // namespace
}  // namespace tactile::video
