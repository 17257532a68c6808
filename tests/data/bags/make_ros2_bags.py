#!/usr/bin/env python3
"""Writes ROS 2 bags with the messages of the ROS 1 bags run.bag and mono.bag, which make_bags.py wrote.

    make_ros2_bags.py [FOLDER]     default: the folder of this script

It needs the Python packages rosbags, mcap, lz4 and zstandard; the tests only read the bags.
"""

import os
import shutil
import sys

from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Reader
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

EVENT = "uint16 x\nuint16 y\nbuiltin_interfaces/Time ts\nbool polarity\n"
EVENT_ARRAY = "std_msgs/Header header\nuint32 height\nuint32 width\ndvs_msgs/Event[] events\n"
EVENT_PACKET = ("std_msgs/Header header\nuint32 height\nuint32 width\nuint64 seq\nuint64 time_base\nstring encoding\n"
                "bool is_bigendian\nuint8[] events\n")

store = get_typestore(Stores.ROS2_HUMBLE)
store.register(get_types_from_msg(EVENT, "dvs_msgs/msg/Event"))
store.register(get_types_from_msg(EVENT_ARRAY, "dvs_msgs/msg/EventArray"))
store.register(get_types_from_msg(EVENT_PACKET, "event_camera_msgs/msg/EventPacket"))


def messages_of(bag):
    """(topic, type, received_ns, message in CDR)"""
    with Reader(bag) as reader:
        return [(c.topic, c.msgtype, t, bytes(store.ros1_to_cdr(raw, c.msgtype))) for c, t, raw in reader.messages()]


def write(folder, name, messages, storage, mode=None):
    """One bag by rosbags; its file becomes FOLDER/NAME with the extension that rosbags chose."""
    place = os.path.join(folder, name)
    shutil.rmtree(place, ignore_errors=True)
    writer = Writer(place, version=9, storage_plugin=storage)
    if mode:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, kind, received, data in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], received, data)
    for file in os.listdir(place):
        if file != "metadata.yaml":
            os.replace(os.path.join(place, file), os.path.join(folder, file))
    shutil.rmtree(place)


def write_mcap(path, messages, compression, chunk_size):
    """By the reference library of MCAP, with several chunks."""
    with open(path, "wb") as file:
        writer = McapWriter(file, compression=compression, chunk_size=chunk_size)
        writer.start("ros2", "make_ros2_bags")
        channels = {}
        for topic, kind, received, data in messages:
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "cdr", writer.register_schema(kind, "ros2msg", b""))
            writer.add_message(channels[topic], received, data, received)
        writer.finish()


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    run = messages_of(os.path.join(folder, "run.bag"))
    write(folder, "run-file", run, StoragePlugin.SQLITE3, CompressionMode.FILE)
    write(folder, "run-message", run, StoragePlugin.SQLITE3, CompressionMode.MESSAGE)
    write_mcap(os.path.join(folder, "run-lz4.mcap"), run, CompressionType.LZ4, 50_000)
    write_mcap(os.path.join(folder, "run-zstd.mcap"), run, CompressionType.ZSTD, 50_000)
    mono = messages_of(os.path.join(folder, "mono.bag"))
    write(folder, "mono", mono, StoragePlugin.SQLITE3)
    write_mcap(os.path.join(folder, "mono.mcap"), mono, CompressionType.NONE, 10_000)


main()
