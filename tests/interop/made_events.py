"""Events and IMU samples with known values, as dv-processing takes them."""

import numpy as np

import contents as c

CAMERA, SIZE = "DVXplorer_DXA00007", (640, 480)


def made_events(count, step_us=7, first_us=1_700_000_000_000_000, seed=5):
    random = np.random.default_rng(seed)
    t = first_us + np.cumsum(random.integers(0, 2 * step_us, count))
    return c.events_from(t, random.integers(0, SIZE[0], count), random.integers(0, SIZE[1], count), random.integers(0, 2, count))


def made_packets(count, events_each, span_us):
    """Events, and the same events divided into packets of about span_us each."""
    events = made_events(count * events_each, step_us=max(1, span_us // events_each))
    return events, [events[i:i + events_each] for i in range(0, len(events), events_each)]


def dv_events(events):
    import dv_processing as dv
    store = dv.EventStore()
    for t, x, y, on in events.tolist():
        store.push_back(t, x, y, bool(on))
    return store


def dv_imu_sample(t):
    """A sample whose values follow from its time."""
    import dv_processing as dv
    value = float(t % 1000) / 8
    return dv.IMU(t, *(value + i for i in range(10)))
