"""The event camera: thresholds, photoreceptor, refractory time, noise, hot pixels and the read-out by columns."""
import numpy as np

from ranges import COLUMN_US, HEIGHT, WIDTH
from skin import light

PIXELS = WIDTH * HEIGHT


def frame_times(motion, numbers):
    """Times to render at: no step moves the picture by more than about 0.4 px. Starts of motion are met exactly and followed at 1 kHz."""
    t = motion.t
    step = t[1] - t[0]
    rate = lambda x: np.abs(np.gradient(x, step))
    skin = rate(motion.depth) + rate(motion.shear) + rate(motion.turn) * numbers["patch_mm"] + rate(motion.sway)
    moving = skin * numbers["px_per_mm"] + rate(motion.slid) / numbers["relief_length_mm"]
    density = moving / 0.4 + np.where(moving > 0.2, 100.0, 20.0) + 7 * motion.hum_hz
    begins = [x["start"] for x in motion.truths if 0 <= x["start"] < t[-1]]
    for begin in begins:
        density[(t > begin - 0.002) & (t < begin + 0.08)] += 1000
    path = np.concatenate([[0], np.cumsum(density[1:] * step)])
    times = np.interp(np.arange(0, path[-1]), path, t)
    return np.unique(np.concatenate([times, begins, [t[-1]]]))


class Pixels:
    """Turns pictures into events, as (time, pixel, on)."""

    def __init__(self, numbers, rng, background=None):
        """`background`: noise as (time, pixel, ...). Such an event resets its pixel as any other does."""
        spread = lambda: np.maximum(0.05, 1 + numbers["threshold_spread"] / 0.25 * rng.standard_normal(PIXELS)).astype(np.float32)
        self.on = numbers["threshold_on"] * spread()
        self.off = numbers["threshold_off"] * spread()
        self.low = -self.off
        self.slow, self.last, self.t = numbers["photoreceptor_s"], None, 0.0
        self.dither = (0.999 * rng.random(PIXELS)).astype(np.float32)  # never at a threshold: no event before something moves
        self.found = []
        order = np.argsort(background[0]) if background else np.zeros(0, int)
        self.noise_times, self.noise_pixels = (x[order] for x in background[:2]) if background else (np.zeros(0), order)

    def see(self, t, picture):
        picture = picture.ravel()
        if self.last is None:
            self.level = picture.copy()
            self.last = self.dither * (self.on + self.off) - self.off  # distance from the level of the last event
            self.t = t
            return
        step = picture - self.level
        step *= np.float32(1 - np.exp(-(t - self.t) / self.slow))
        self.level += step
        noisy = self.noise_pixels[slice(*np.searchsorted(self.noise_times, (self.t, t)))]
        self.last[noisy] = 0
        before, now = self.last, self.last + step
        places = np.flatnonzero((now >= self.on) | (now <= self.low))
        if len(places):
            self.cross(t, places, before[places], now)
        self.last, self.t = now, t

    def cross(self, t, places, before, now):
        on = now[places] > 0
        size = np.where(on, self.on[places], -self.off[places])
        count = np.minimum((now[places] / size).astype(np.int64), 50)
        each = np.repeat(np.arange(len(places)), count)
        number = np.arange(len(each)) - np.repeat(np.cumsum(count) - count, count) + 1
        part = (number * size[each] - before[each]) / (now[places][each] - before[each])
        self.found.append((self.t + np.clip(part, 0, 1) * (t - self.t), places[each], on[each]))
        now[places] -= count * size

    def events(self):
        if not self.found:
            return np.zeros(0), np.zeros(0, np.int64), np.zeros(0, bool)
        return tuple(np.concatenate(x) for x in zip(*self.found))


def noise(numbers, rng, seconds):
    """Background of all pixels, and pixels that fire at a rate of their own. Returns events and the hot pixels."""
    weights = np.exp(numbers["noise_spread"] * rng.standard_normal(PIXELS) - numbers["noise_dark"] * light(numbers).ravel())
    count = rng.poisson(numbers["noise_hz_per_px"] * PIXELS * seconds)
    pixel = np.searchsorted(np.cumsum(weights), rng.random(count) * weights.sum()).clip(0, PIXELS - 1)
    hot = rng.choice(PIXELS, int(numbers["hot_pixels"]), replace=False)
    hz = np.minimum(1e6 / numbers["readout_us"], np.exp(np.log(80) + 1.4 * rng.standard_normal(len(hot))))
    counts = rng.poisson(hz * seconds)
    pixel = np.concatenate([pixel, np.repeat(hot, counts)])
    t = rng.random(len(pixel)) * seconds
    return (t, pixel, rng.random(len(pixel)) < rng.uniform(0.3, 0.7)), list(zip(hot.tolist(), hz.tolist()))


def rest_between(pixel, t, seconds):
    """Which events remain if a pixel is blind for `seconds` after each. Sorted by pixel, then time."""
    keep = np.arange(len(t))
    while True:
        soon = np.concatenate([[False], (pixel[keep][1:] == pixel[keep][:-1]) & (t[keep][1:] - t[keep][:-1] < seconds)])
        first = soon & ~np.concatenate([[False], soon[:-1]])
        if not first.any():
            return keep
        keep = keep[~first]


def read_out(numbers, rng, signal, background, epoch_us):
    """Stamps of all events [us of camera time], ascending. Also which of them come from the skin."""
    t = np.concatenate([signal[0], background[0]])
    pixel = np.concatenate([signal[1], background[1]])
    on = np.concatenate([signal[2], background[2]])
    skin = np.arange(len(t)) < len(signal[0])
    order = np.lexsort((t, pixel))
    order = order[rest_between(pixel[order], t[order], numbers["refractory_s"])]
    period, phase = numbers["readout_us"], rng.uniform(0, numbers["readout_us"])
    scan = np.ceil((t[order] * 1e6 - phase) / period).astype(np.int64)
    once = np.concatenate([[True], (pixel[order][1:] != pixel[order][:-1]) | (scan[1:] != scan[:-1])])
    order, scan = order[once], scan[once]
    x = pixel[order] % WIDTH
    stamp = epoch_us + np.floor(phase + scan * period + (WIDTH - 1 - x) * COLUMN_US).astype(np.int64)
    sort = np.argsort(stamp, kind="stable")
    order = order[sort]
    return {"t_us": stamp[sort], "x": (pixel[order] % WIDTH).astype(np.uint16), "y": (pixel[order] // WIDTH).astype(np.uint16),
            "on": on[order].astype(np.uint8), "skin": skin[order]}
