#include "tactile/live/touch_strength.hpp"

#include <gtest/gtest.h>

namespace tactile::live {
namespace {

using namespace std::chrono_literals;

/// Runs of 3 s with a touch of 0.4 s, seen every 20 ms.
class Session {
 public:
  void run(const std::string& name, double touch_per_s, double background_per_s = 100'000, std::chrono::milliseconds lasts = 3s) {
    double events = 0;
    for (std::chrono::milliseconds t{0}; t <= lasts; t += 20ms) {
      strength.see(name, static_cast<std::uint64_t>(events), now_);
      events += 0.02 * (background_per_s + (t >= 1s && t < 1400ms ? touch_per_s : 0));
      now_ += 20ms;
    }
  }
  void pause() {
    for (int i = 0; i < 100; ++i) strength.see("", 0, now_ += 20ms);
  }

  TouchStrength strength;

 private:
  TouchStrength::Time now_{};
};

TEST(TouchStrength, NamesARunWhoseTouchesAreMuchWeakerThanEarlierOnes) {
  Session session;
  for (const char* name : {"fan/01", "fan/02", "fan/03"}) {
    session.run(name, 1e6);
    session.pause();
    EXPECT_FALSE(session.strength.warning()) << "there is too little to compare with";
  }
  session.run("fan/04", 4e5);
  session.pause();
  EXPECT_FALSE(session.strength.warning()) << "another object is weaker, too";
  session.run("fan/05", 1e5);
  EXPECT_FALSE(session.strength.warning()) << "it has not ended";
  session.pause();
  EXPECT_EQ(
      session.strength.warning().value_or(""),
      "the touches of fan/05 caused 10 % of the events of the earlier runs: out of focus, too dark, or touched more weakly");
  session.run("fan/06", 9e5);
  session.pause();
  EXPECT_FALSE(session.strength.warning()) << "the next one is as before";
}

TEST(TouchStrength, AConstantBackgroundIsNoTouchAndAShortRunIsNotCompared) {
  Session session;
  for (const char* name : {"mug/01", "mug/02", "mug/03"}) session.run(name, 1e6);
  session.run("mug/04", 1e5, 5e6);
  session.pause();
  EXPECT_TRUE(session.strength.warning()) << "more light noise does not hide it";
  session.run("mug/05", 1e6);
  session.run("mug/06", 0, 1e5, 500ms);
  session.pause();
  EXPECT_FALSE(session.strength.warning()) << "it was ended at once";
}

TEST(TouchStrength, WeakRunsAreNoMeasureForLaterOnes) {
  Session session;
  for (const char* name : {"mug/01", "mug/02", "mug/03"}) session.run(name, 1e6);
  for (const char* name : {"mug/04", "mug/05", "mug/06", "mug/07", "mug/08", "mug/09"}) {
    session.run(name, 1e5);
    session.pause();
    EXPECT_TRUE(session.strength.warning()) << name << ": it is still out of focus";
  }
}

TEST(TouchStrength, ARunThatIsRepeatedCountsOnce) {
  Session session;
  for (int i = 0; i < 4; ++i) session.run("cup/01", 1e6);
  session.run("cup/02", 1e6);
  session.run("cup/03", 1e5);
  session.pause();
  EXPECT_FALSE(session.strength.warning()) << "there are two runs to compare with";
  session.run("cup/04", 1e6);
  session.run("cup/05", 1e5);
  session.pause();
  EXPECT_TRUE(session.strength.warning());
}

}  // namespace
}  // namespace tactile::live
