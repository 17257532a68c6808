#!/usr/bin/env python3
"""Writes small ROS 1 bags, and truth.json with sums over their contents.

    make_bags.py [FOLDER]     default: the folder of this script

It needs the Python package rosbags; the tests only read the bags. The same version of rosbags writes the same bytes.
"""

import hashlib
import json
import math
import os
import random
import struct
import sys

import numpy as np
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

EVENT = "uint16 x\nuint16 y\ntime ts\nbool polarity\n"
EVENT_ARRAY = "std_msgs/Header header\nuint32 height\nuint32 width\ndvs_msgs/Event[] events\n"
EVENT_PACKET = ("std_msgs/Header header\nuint32 height\nuint32 width\nuint64 seq\nuint64 time_base\nstring encoding\n"
                "bool is_bigendian\nuint8[] events\n")
TRANSFORMS = "geometry_msgs/TransformStamped[] transforms\n"

START_US = 1_700_000_000_000_000
WIDTH, HEIGHT = 160, 120
JOINTS = ["elbow_joint", "shoulder_lift_joint", "shoulder_pan_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]  # in the order of ROS

store = get_typestore(Stores.ROS1_NOETIC)
store.register(get_types_from_msg(EVENT, "dvs_msgs/msg/Event"))
store.register(get_types_from_msg(EVENT_ARRAY, "dvs_msgs/msg/EventArray"))
store.register(get_types_from_msg(EVENT_PACKET, "event_camera_msgs/msg/EventPacket"))
store.register(get_types_from_msg(TRANSFORMS, "tf2_msgs/msg/TFMessage"))
types = store.types


def header(us, frame=""):
    stamp = types["builtin_interfaces/msg/Time"](sec=us // 1_000_000, nanosec=us % 1_000_000 * 1_000)
    return types["std_msgs/msg/Header"](seq=0, stamp=stamp, frame_id=frame)


def made_events(count, seed):
    """(t_us, x, y, on) within one second. Some events have the same time."""
    rng = random.Random(seed)
    times = sorted(START_US + 200 * rng.randrange(5_000) for _ in range(count))
    return [(t, rng.randrange(WIDTH), rng.randrange(HEIGHT), rng.randrange(2)) for t in times]


def sums(events):
    digest = hashlib.sha256()
    for event in events:
        digest.update(struct.pack("<qhhB", *event))
    return {"events": len(events), "on": sum(e[3] for e in events), "sum_x": sum(e[1] for e in events),
            "sum_y": sum(e[2] for e in events), "first_us": events[0][0], "last_us": events[-1][0], "digest": digest.hexdigest()}


def messages_of(events, span_us=10_000):
    """The events in packets of equal duration, as a driver sends them."""
    packets = {}
    for event in events:
        packets.setdefault((event[0] - START_US) // span_us, []).append(event)
    return [packets[k] for k in sorted(packets)]


def event_array(packet):
    time, event = types["builtin_interfaces/msg/Time"], types["dvs_msgs/msg/Event"]
    return types["dvs_msgs/msg/EventArray"](header=header(packet[0][0]), height=HEIGHT, width=WIDTH, events=[
        event(x=x, y=y, ts=time(sec=t // 1_000_000, nanosec=t % 1_000_000 * 1_000), polarity=bool(on)) for t, x, y, on in packet])


def libcaer(packet, base_us):
    return b"".join(struct.pack("<II", 1 | on << 1 | y << 2 | x << 17, (t - base_us) & 0x7FFFFFFF) for t, x, y, on in packet)


def libcaer_cmp(packet, base_us):
    """Masks for neighbours in one column with the same time and polarity, else single events."""
    words, high, low, column = [], 0, 0, None
    i = 0
    while i < len(packet):
        t, x, y, on = packet[i]
        if (t - base_us) >> 12 != high:
            high = (t - base_us) >> 12
            words.append(0x0000 | high)
        if (t - base_us) & 0xFFF != low:
            low = (t - base_us) & 0xFFF
            words.append(0x1000 | low)
        if x != column:
            column = x
            words.append(0x2000 | x)
        mask, end = 1, i + 1
        while end < len(packet) and packet[end][:2] == (t, x) and packet[end][3] == on and packet[end][2] - packet[end - 1][2] == 1 \
                and packet[end][2] - y < 8:
            mask |= 1 << (packet[end][2] - y)
            end += 1
        if mask == 1:
            words.append(0x3000 | y | on << 11)
        else:
            words += [0x4000 | y | on << 11, 0x5000 | mask]
        i = end
    return struct.pack(f"<{len(words)}H", *words)


def mono(packet, base_us):
    return b"".join(struct.pack("<Q", (t - base_us) * 1_000 | x << 32 | y << 48 | on << 63) for t, x, y, on in packet)


def event_packet(packet, sequence, encoding):
    # With this base the 31-bit time of libcaer overflows half-way through the recording, within a packet.
    base_us = START_US + 505_000 - 2**31 if encoding == "libcaer" else packet[0][0]
    wraps = encoding == "libcaer" and packet[0][0] - base_us >= 2**31
    data = {"libcaer": libcaer, "libcaer_cmp": libcaer_cmp, "mono": mono}[encoding](packet, base_us)
    return types["event_camera_msgs/msg/EventPacket"](
        header=header(packet[-1][0] + 300), height=HEIGHT, width=WIDTH, seq=sequence,
        time_base=(base_us + (2**31 if wraps else 0)) * 1_000, encoding=encoding, is_bigendian=False,
        events=np.frombuffer(data, dtype=np.uint8))


def pose_at(s):
    """Position and rotation (quaternion) of a tool in front of the robot. It rises, and rotates about z by 0.3 rad/s."""
    return (0.5, 0.1, 0.2 + 0.05 * s), (0.0, 0.0, math.sin(0.15 * s), math.cos(0.15 * s))


def transforms(us):
    s = (us - START_US) / 1e6
    place, turn = pose_at(s)
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    transform, stamped = types["geometry_msgs/msg/Transform"], types["geometry_msgs/msg/TransformStamped"]
    link = stamped(header=header(us, "base_link"), child_frame_id="shoulder_link",
                   transform=transform(vector(9.0, 9.0, 9.0), quaternion(0.0, 0.0, 0.0, 1.0)))
    tool = stamped(header=header(us, "base"), child_frame_id="tool0_controller", transform=transform(vector(*place), quaternion(*turn)))
    return types["tf2_msgs/msg/TFMessage"](transforms=[link, tool])


def joint_state(us):
    s = (us - START_US) / 1e6
    empty = np.array([], dtype=np.float64)
    return types["sensor_msgs/msg/JointState"](header=header(us), name=JOINTS, velocity=empty, effort=empty,
                                               position=np.array([0.1 * (i + 1) + s for i in range(6)]))


def image(us, index, encoding):
    channels = {"mono8": 1, "bgr8": 3, "rgb8": 3}[encoding]
    pixels = np.zeros((49, 65, channels), dtype=np.uint8)  # odd sizes, which H.264 does not have
    pixels[:, 5 * index:5 * index + 5] = 200
    if channels == 3:
        pixels[..., 2 if encoding == "bgr8" else 0] = 255  # red
    return types["sensor_msgs/msg/Image"](header=header(us), height=49, width=65, encoding=encoding, is_bigendian=0,
                                          step=65 * channels, data=pixels.reshape(-1))


def imu(us, index):
    vector, none = types["geometry_msgs/msg/Vector3"], np.zeros(9)
    return types["sensor_msgs/msg/Imu"](header=header(us), orientation=types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
                                        orientation_covariance=none, angular_velocity_covariance=none,
                                        linear_acceleration_covariance=none, angular_velocity=vector(0.0, 0.0, math.radians(index)),
                                        linear_acceleration=vector(0.0, 0.0, 9.80665))


def write(path, messages, compression=None):
    """messages: (topic, type, received_us, message)"""
    if os.path.exists(path):
        os.remove(path)
    writer = Writer(path)
    if compression:
        writer.set_compression(getattr(Writer.CompressionFormat, compression))
    with writer:
        connections = {}
        for topic, name, received_us, message in sorted(messages, key=lambda m: m[2]):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            writer.write(connections[topic], received_us * 1_000, store.serialize_ros1(message, name))


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    os.makedirs(folder, exist_ok=True)
    truth = {}

    def bag(name, messages, events, compression=None, **more):
        write(os.path.join(folder, name + ".bag"), messages, compression)
        truth[name + ".bag"] = {**sums(events), **more}

    # A whole run: events, robot, video, IMU.
    events = made_events(3_000, 1)
    run = [("/dvs/events", "dvs_msgs/msg/EventArray", p[-1][0] + 500, event_array(p)) for p in messages_of(events)]
    robot_times = [START_US + 8_000 * i for i in range(126)]
    run += [("/tf", "tf2_msgs/msg/TFMessage", t + 400, transforms(t)) for t in robot_times]
    run += [("/joint_states", "sensor_msgs/msg/JointState", t + 8_350, joint_state(t + 8_000)) for t in robot_times]
    frame_times = [START_US + t for t in (0, 33_333, 66_667, 133_333, 166_667, 200_000)]  # one is missing
    run += [("/camera/image_raw", "sensor_msgs/msg/Image", t + 9_000, image(t, i, "rgb8")) for i, t in enumerate(frame_times)]
    run += [("/dvs/imu", "sensor_msgs/msg/Imu", START_US + 5_000 * i + 100, imu(START_US + 5_000 * i, i)) for i in range(20)]
    run += [("/chatter", "std_msgs/msg/String", START_US + 1, types["std_msgs/msg/String"]("hello"))]
    for name, compression in (("run", None), ("run-lz4", "LZ4"), ("run-bz2", "BZ2")):
        bag(name, run, events, compression, poses=len(robot_times), frames=len(frame_times), imu=20,
            first_frame_us=frame_times[0], last_frame_us=frame_times[-1])

    # Each encoding of EventPackets. One sequence number is skipped, as if a packet were lost.
    for encoding in ("libcaer", "libcaer_cmp", "mono"):
        events = made_events(2_000, 2)
        if encoding == "libcaer_cmp":  # neighbours that fire together
            events = sorted(events + [(START_US + 300_000, 40, y, 1) for y in range(50, 70)], key=lambda e: e[0])
        packets = messages_of(events)
        bag(encoding, [("/event_camera/events", "event_camera_msgs/msg/EventPacket", p[-1][0] + 400,
                        event_packet(p, i + (i > 40), encoding)) for i, p in enumerate(packets)], events, lost=1)

    # Messages that overlap in time, as if two threads sent them.
    events = made_events(1_000, 3)
    halves = [(i, p[0::2], p[1::2]) for i, p in enumerate(messages_of(events))]
    overlapping = [("/dvs/events", "dvs_msgs/msg/EventArray", START_US + 20_000 * i + 10_000 * k, event_array(part))
                   for i, even, odd in halves for k, part in enumerate((odd, even)) if part]
    bag("overlapping", overlapping, sorted((e for _, even, odd in halves for e in odd + even), key=lambda e: e[0]))

    # Bags that are converted only with a further option, or not at all.
    events = made_events(50, 4)
    packet = event_array(events)
    write(os.path.join(folder, "two-cameras.bag"),
          [(f"/{side}/events", "dvs_msgs/msg/EventArray", START_US, packet) for side in ("left", "right")])
    write(os.path.join(folder, "no-events.bag"), [("/joint_states", "sensor_msgs/msg/JointState", START_US, joint_state(START_US))])
    prophesee = event_packet(events, 0, "mono")
    prophesee.encoding = "evt2"
    write(os.path.join(folder, "evt2.bag"), [("/event_camera/events", "event_camera_msgs/msg/EventPacket", START_US, prophesee)])

    with open(os.path.join(folder, "truth.json"), "w", encoding="utf-8") as file:
        json.dump(truth, file, indent=2, sort_keys=True)
        file.write("\n")


main()
