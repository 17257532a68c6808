// film_until_killed SOURCE SPEED MP4 CSV: films until it is killed. Ends with 1 if it cannot.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include "tactile/video/video_capture.hpp"

int main(int argc, char** argv) {
  if (argc != 5) return 1;
  try {
    tactile::video::VideoCapture capture({.source = argv[1], .speed = std::atof(argv[2]), .log = {}});
    capture.start_film(argv[3], argv[4]);
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
