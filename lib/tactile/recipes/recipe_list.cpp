#include <array>
#include <vector>

#include "tactile/recipes/step.hpp"

namespace tactile::recipes {
namespace {

constexpr std::array kev_s{50.0, 100.0, 200.0, 500.0, 1000.0};
constexpr std::array hot_counts{10.0, 30.0, 100.0, 300.0, 1000.0};
constexpr std::array line_counts{5.0, 10.0, 20.0, 50.0, 100.0};
constexpr std::array lost_shares{10.0, 20.0, 40.0, 60.0, 80.0};
constexpr std::array ns_per_event{100.0, 200.0, 500.0, 1000.0, 2000.0};
constexpr std::array flicker_shares{0.1, 0.3, 1.0, 3.0, 10.0};
constexpr std::array jitters_us{100.0, 300.0, 1000.0, 3000.0, 10'000.0};
constexpr std::array units_us{200.0, 500.0, 1000.0, 2000.0, 5000.0};
constexpr std::array delays_ms{5.0, 10.0, 20.0, 50.0, 100.0};
constexpr std::array shifts_px{2.0, 5.0, 10.0, 20.0, 40.0};
constexpr std::array angles_deg{1.0, 2.0, 5.0, 10.0, 20.0};
constexpr std::array growths{2.0, 5.0, 10.0, 20.0, 40.0};
constexpr std::array once{1.0};
constexpr std::array swapped_shares{10.0, 25.0, 50.0, 75.0, 100.0};
constexpr std::array higher_thresholds{10.0, 20.0, 50.0, 100.0, 200.0};
constexpr std::array amplitudes_px{1.0, 2.0, 3.0, 5.0, 8.0};

constexpr RecipeParameter packet_ms{"packet_ms", "ms", 10, 0.1, 1000, "Duration of a packet; DV sends one every 10 ms."};
constexpr RecipeParameter direction_deg{
    "direction_deg", "degrees", 0, -360, 360, "Direction in the picture: 0 to the right, 90 downwards."};
constexpr std::array in_packets{packet_ms};
constexpr std::array in_bursts{RecipeParameter{"burst_ms", "ms", 10, 0.1, 1000, "Mean duration of a burst."}};
constexpr std::array with_queue{
    RecipeParameter{"queue_us", "us", 1000, 1, 1e6, "How far the read-out may lag before events are lost."}};
constexpr std::array late_packets{RecipeParameter{"share", "%", 20, 0, 100, "Share of the packets that are late."}, packet_ms};
constexpr std::array to_a_side{direction_deg};
constexpr std::array vibrating{RecipeParameter{"hz", "Hz", 50, 10, 200, "Frequency."}, direction_deg};

constexpr std::array entries{
    RecipeEntry{
        {.name = "noise",
         .title = "background noise",
         .unit = "kev/s",
         .least = 0,
         .most = 1e5,
         .usual = kev_s,
         .text = "Every pixel fires by itself, all pixels together at this rate.",
         .model =
             "A gamma renewal process per pixel at a rate of its own, as measured; at most 500 events/s per pixel in the mean.",
         .takes_sensor = true},
        make_noise},
    RecipeEntry{
        {.name = "hot-pixels",
         .title = "hot pixels",
         .unit = "pixels",
         .least = 0,
         .most = 1e6,
         .whole = true,
         .usual = hot_counts,
         .text = "This many pixels fire by themselves, each at a rate of its own.",
         .model = "Rates and shares of ON are drawn from measured quantiles; intervals are partly fixed, the rest exponential.",
         .takes_sensor = true},
        make_hot_pixels},
    RecipeEntry{{.name = "dead-rows",
                 .title = "dead rows",
                 .unit = "rows",
                 .least = 0,
                 .most = events::most_side,
                 .whole = true,
                 .usual = line_counts,
                 .text = "This many rows of pixels give no events.",
                 .model = "The rows are drawn once; more dead rows contain fewer ones."},
                make_dead_rows},
    RecipeEntry{{.name = "dead-columns",
                 .title = "dead columns",
                 .unit = "columns",
                 .least = 0,
                 .most = events::most_side,
                 .whole = true,
                 .usual = line_counts,
                 .text = "This many columns of pixels give no events.",
                 .model = "The columns are drawn once; more dead columns contain fewer ones."},
                make_dead_columns},
    RecipeEntry{{.name = "loss",
                 .title = "events lost at random",
                 .unit = "% of the events",
                 .least = 0,
                 .most = 100,
                 .usual = lost_shares,
                 .text = "Each event is lost with this chance.",
                 .model = "Independent draws."},
                make_loss},
    RecipeEntry{{.name = "burst-loss",
                 .title = "events lost in bursts",
                 .unit = "% of the time",
                 .least = 0,
                 .most = 100,
                 .usual = lost_shares,
                 .text = "All events in random stretches of time are lost; together these are this share of the recording.",
                 .model = "Lost and kept times alternate, each of exponential length.",
                 .parameters = in_bursts},
                make_burst_loss},
    RecipeEntry{{.name = "packet-loss",
                 .title = "packets lost",
                 .unit = "% of the packets",
                 .least = 0,
                 .most = 100,
                 .usual = lost_shares,
                 .text = "Each packet of events is lost with this chance.",
                 .model = "Packets have equal durations from the first event; those of the file do not count.",
                 .parameters = in_packets},
                make_packet_loss},
    RecipeEntry{{.name = "readout-limit",
                 .title = "saturated read-out",
                 .unit = "ns/event",
                 .least = 0,
                 .most = 1e5,
                 .usual = ns_per_event,
                 .text = "The read-out spends this time on each event, so its largest rate is 1000 Mev/s divided by it.",
                 .model = "A queue with a constant rate. An event that comes when it is full is lost, so a burst loses its last "
                          "events. Stamps do not change.",
                 .parameters = with_queue},
                make_readout_limit},
    RecipeEntry{{
                    .name = "flicker-100",
                    .title = "flicker of 100 Hz",
                    .unit = "% of the pixels",
                    .least = 0,
                    .most = 100,
                    .usual = flicker_shares,
                    .text = "This share of the pixels answers the flicker of a lamp at mains of 50 Hz.",
                    .model = "Always the same pixels: one ON event in the upper half of each rise of a sine, one OFF event in "
                             "the lower half of "
                             "each fall.",
                },
                make_flicker_100},
    RecipeEntry{{.name = "flicker-120",
                 .title = "flicker of 120 Hz",
                 .unit = "% of the pixels",
                 .least = 0,
                 .most = 100,
                 .usual = flicker_shares,
                 .text = "This share of the pixels answers the flicker of a lamp at mains of 60 Hz.",
                 .model = "As flicker-100."},
                make_flicker_120},
    RecipeEntry{{.name = "jitter",
                 .title = "time jitter",
                 .unit = "us",
                 .least = 0,
                 .most = 1e5,
                 .usual = jitters_us,
                 .text = "The time of each event scatters with this standard deviation.",
                 .model = "Normal, independent, limited to three standard deviations; then sorted again."},
                make_jitter},
    RecipeEntry{{.name = "rounding",
                 .title = "rounded stamps",
                 .unit = "us",
                 .least = 1,
                 .most = 1e6,
                 .whole = true,
                 .usual = units_us,
                 .text = "Times are rounded down to multiples of this.",
                 .model = "Exact; multiples count from 0 of the recording's clock."},
                make_rounding},
    RecipeEntry{{.name = "late",
                 .title = "late packets",
                 .unit = "ms",
                 .least = 0,
                 .most = 1e4,
                 .usual = delays_ms,
                 .text = "Some packets arrive later by this time.",
                 .model = "All events of a late packet get the time of its arrival, which is its end plus the delay. Earlier "
                          "ticks do not have them, and they count as new when they arrive.",
                 .parameters = late_packets},
                make_late},
    RecipeEntry{{.name = "shift",
                 .title = "picture shifted",
                 .unit = "px",
                 .least = -events::most_side,
                 .most = events::most_side,
                 .usual = shifts_px,
                 .text = "The picture moves by this distance.",
                 .model = "Whole pixels; what leaves the sensor is lost, and nothing comes in.",
                 .parameters = to_a_side},
                make_shift},
    RecipeEntry{{.name = "rotate",
                 .title = "picture rotated",
                 .unit = "degrees",
                 .least = -180,
                 .most = 180,
                 .usual = angles_deg,
                 .text = "The picture turns clockwise around its centre.",
                 .model = "To the nearest pixel, so a few pixels get the events of two and a few get none."},
                make_rotate},
    RecipeEntry{{.name = "scale",
                 .title = "picture scaled",
                 .unit = "%",
                 .least = -90,
                 .most = 300,
                 .usual = growths,
                 .text = "The picture grows around its centre by this share; below 0 it shrinks.",
                 .model = "The number of events per pixel stays the same: events are copied to each pixel that their own pixel "
                          "now covers, or left out at random."},
                make_scale},
    RecipeEntry{{.name = "mirror-x",
                 .title = "picture mirrored, left and right",
                 .unit = "",
                 .least = 0,
                 .most = 1,
                 .whole = true,
                 .usual = once,
                 .text = "Left and right are exchanged.",
                 .model = "Exact."},
                make_mirror_x},
    RecipeEntry{{.name = "mirror-y",
                 .title = "picture mirrored, top and bottom",
                 .unit = "",
                 .least = 0,
                 .most = 1,
                 .whole = true,
                 .usual = once,
                 .text = "Top and bottom are exchanged.",
                 .model = "Exact."},
                make_mirror_y},
    RecipeEntry{{.name = "polarity",
                 .title = "polarity swapped",
                 .unit = "% of the events",
                 .least = 0,
                 .most = 100,
                 .usual = swapped_shares,
                 .text = "Each event changes its polarity with this chance.",
                 .model = "Independent draws; at 100 % all are swapped."},
                make_polarity},
    RecipeEntry{{.name = "threshold",
                 .title = "contrast threshold scaled",
                 .unit = "%",
                 .least = -90,
                 .most = 1000,
                 .usual = higher_thresholds,
                 .text = "The pixels' contrast threshold is higher by this share; below 0 it is lower.",
                 .model = "Successive events of one polarity at a pixel are one change of its brightness, which is divided by "
                          "the new threshold. Changes below the old threshold stay unseen. Copied events have the same stamp."},
                make_threshold},
    RecipeEntry{
        {.name = "vibration",
         .title = "whole picture vibrates",
         .unit = "px",
         .least = 0,
         .most = 1000,
         .usual = amplitudes_px,
         .text = "The picture swings along a line with this amplitude.",
         .model =
             "Events are displaced by a sine, to the nearest pixel. Events of still edges that the vibration moves are not made.",
         .parameters = vibrating},
        make_vibration},
};

}  // namespace

std::span<const RecipeEntry> recipe_entries() { return entries; }

std::span<const RecipeInfo> recipe_list() {
  static const std::vector<RecipeInfo> infos = [] {
    std::vector<RecipeInfo> found;
    for (const RecipeEntry& entry : entries) found.push_back(entry.info);
    return found;
  }();
  return infos;
}

}  // namespace tactile::recipes
