#!/usr/bin/env python3
"""Reads a recording with software that is not ours and checks that it says what it should.

    python read_mcap.py RUN.mcap [--joint-states DUMP.json]

Uses the PyPI packages `mcap` (checksums on) with `mcap-ros2-support`, which decodes each message by the
definition that stands in the file, and `rosbags`, which does so with code of its own. Every problem is one line on standard error; the exit code is 0 only when
there is none. DUMP.json holds {"measured": {"names", "time_ns", "position", "velocity", "effort"}, "reference":
{…}} with one value a row and joint; values must be equal to the last bit.
"""

import argparse
import collections
import json
import math
import struct
import sys
import zlib
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Attachment, Header, Message, Metadata, Statistics
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

MESSAGE_TYPES = {
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/robot_description": "std_msgs/msg/String",
    "/scene/markers": "visualization_msgs/msg/MarkerArray",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/reference/joint_states": "sensor_msgs/msg/JointState",
    "/tcp/pose": "geometry_msgs/msg/PoseStamped",
    "/tcp/twist": "geometry_msgs/msg/TwistStamped",
    "/reference/tcp/pose": "geometry_msgs/msg/PoseStamped",
    "/reference/tcp/twist": "geometry_msgs/msg/TwistStamped",
    "/object/pose": "geometry_msgs/msg/PoseStamped",
    "/object/twist": "geometry_msgs/msg/TwistStamped",
    "/contacts": "graspcheck_msgs/msg/Contact",
    "/checks/monitor": "graspcheck_msgs/msg/Monitor",
    "/rosout": "rcl_interfaces/msg/Log",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/verdict": "std_msgs/msg/String",
}
QOS_KEYS = (
    "history depth reliability durability deadline lifespan liveliness liveliness_lease_duration"
    " avoid_ros_namespace_conventions"
).split()

problems = []


def problem(text):
    problems.append(text)


def numbers(value):
    """Every float in a decoded message."""
    if isinstance(value, float):
        yield value
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from numbers(item)
    elif hasattr(value, "__slots__"):
        for name in value.__slots__:
            yield from numbers(getattr(value, name))


def stamps(topic, message):
    """The stamps in a message, as nanoseconds."""
    if topic in ("/tf", "/tf_static"):
        headers = [transform.header.stamp for transform in message.transforms]
    elif topic == "/scene/markers":
        headers = [marker.header.stamp for marker in message.markers]
    elif topic == "/rosout":
        headers = [message.stamp]
    elif topic in ("/robot_description", "/verdict"):
        headers = []
    else:
        headers = [message.header.stamp]
    return [stamp.sec * 1_000_000_000 + stamp.nanosec for stamp in headers]


def quaternions(topic, message):
    if topic.endswith("/pose"):
        yield message.pose.orientation
    elif topic in ("/tf", "/tf_static"):
        yield from (transform.transform.rotation for transform in message.transforms)
    elif topic == "/scene/markers":
        yield from (marker.pose.orientation for marker in message.markers)


def read_records(path):
    """The whole file from front to end: every checksum, the order of records, what they promise."""
    counts = collections.Counter()
    order = []
    statistics = None
    with open(path, "rb") as file:
        for record in StreamReader(file, validate_crcs=True).records:
            order.append(type(record))
            if isinstance(record, Header):
                if record.profile != "ros2":
                    problem(f"profile is {record.profile!r}, expected 'ros2'")
                if not record.library.startswith("graspcheck "):
                    problem(f"library is {record.library!r}, expected graspcheck and its version")
            elif isinstance(record, Message):
                counts[record.channel_id] += 1
                if record.log_time != record.publish_time:
                    problem(f"log time {record.log_time} differs from publish time {record.publish_time}")
            elif isinstance(record, Statistics):
                statistics = record
    if order[1] is not Metadata:
        problem(f"the first record is {order[1].__name__}, expected Metadata")
    if statistics is None:
        problem("no statistics")
    else:
        if statistics.message_count != sum(counts.values()):
            problem(f"statistics promise {statistics.message_count} messages, found {sum(counts.values())}")
        if dict(statistics.channel_message_counts) != dict(counts):
            problem("statistics promise other counts for the channels than found")
        for kind, promised in ((Attachment, statistics.attachment_count), (Metadata, statistics.metadata_count)):
            if order.count(kind) != promised:
                problem(f"statistics promise {promised} {kind.__name__}, found {order.count(kind)}")
    return sum(counts.values())


def check_footer(path):
    """The checksum of the summary, which the Python reader does not look at."""
    with open(path, "rb") as file:
        data = file.read()
    summary_start, _, saved = struct.unpack("<QQI", data[-28:-8])
    calculated = zlib.crc32(data[summary_start : len(data) - 12])
    if saved == 0 or saved != calculated:
        problem(f"summary checksum is {saved:08x}, calculated {calculated:08x}")


def read_messages(path):
    """Every message through the index, decoded."""
    joint_states = {"/joint_states": [], "/reference/joint_states": []}
    counts = collections.Counter()
    verdict = None
    previous = 0
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, record, message in reader.iter_decoded_messages():
            topic, time = channel.topic, record.log_time
            place = f"{topic} at {time} ns"
            if counts[topic] == 0:
                check_channel(schema, channel)
            counts[topic] += 1
            if record.sequence != counts[topic] - 1:
                problem(f"{place}: sequence is {record.sequence}, expected {counts[topic] - 1}")
            if time < previous:
                problem(f"{place}: a message before it is later")
            previous = time
            for value in numbers(message):
                if not math.isfinite(value):
                    problem(f"{place}: {value} is not finite")
            for stamp in stamps(topic, message):
                if stamp != time:
                    problem(f"{place}: its stamp is {stamp} ns")
            for q in quaternions(topic, message):
                norm = math.hypot(q.x, q.y, q.z, q.w)
                if abs(norm - 1.0) > 1e-6:
                    problem(f"{place}: a quaternion has length {norm}")
            if topic in joint_states:
                joint_states[topic].append(
                    (time, list(message.name), list(message.position), list(message.velocity), list(message.effort))
                )
                for column in (message.position, message.velocity, message.effort):
                    if len(column) != len(message.name):
                        problem(f"{place}: {len(column)} values for {len(message.name)} joints")
            elif topic == "/scene/markers":
                for marker in message.markers:
                    check_marker(marker)
            elif topic == "/verdict":
                verdict = message.data
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        attachments = {record.name: record.data for record in reader.iter_attachments()}
    for topic, rows in joint_states.items():
        if any(row[1] != rows[0][1] for row in rows):
            problem(f"{topic}: names or order of the joints change")
    check_documents(metadata, attachments, verdict)
    return joint_states, counts, attachments


def read_with_rosbags(path):
    """The number of messages that the second reader decodes; it also parses the qualities of service."""
    count = 0
    with AnyReader([Path(path)]) as reader:
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
            count += 1
    return count


def check_channel(schema, channel):
    expected = MESSAGE_TYPES.get(channel.topic)
    if expected is None:
        problem(f"{channel.topic} is not a topic of a recording")
    elif schema.name != expected:
        problem(f"{channel.topic}: its type is {schema.name}, expected {expected}")
    if (schema.encoding, channel.message_encoding) != ("ros2msg", "cdr"):
        problem(f"{channel.topic}: {schema.encoding} and {channel.message_encoding}, expected ros2msg and cdr")
    quality = channel.metadata.get("offered_qos_profiles", "")
    for key in QOS_KEYS:
        if f"{key}:" not in quality:
            problem(f"{channel.topic}: offered_qos_profiles lacks {key}")


def check_marker(marker):
    name = f"marker {marker.ns}/{marker.text}"
    if marker.type not in (1, 2, 3, 4, 11):
        problem(f"{name}: type {marker.type}")
    if marker.type == 4 and len(marker.points) < 2:
        problem(f"{name}: a line of {len(marker.points)} points")
    if marker.type == 11 and len(marker.points) % 3:
        problem(f"{name}: triangles of {len(marker.points)} points")
    if not marker.header.frame_id:
        problem(f"{name}: no frame")


def check_documents(metadata, attachments, verdict):
    for name in ("run", "layout"):
        if name not in metadata:
            problem(f"metadata record {name} is missing")
    for name, data in attachments.items():
        if name.endswith(".json"):
            try:
                json.loads(data)
            except ValueError as error:
                problem(f"attachment {name} is not JSON: {error}")
    if verdict is not None and attachments.get("verdict.json") != verdict.encode():
        problem("attachment verdict.json is not what /verdict says")


def compare_joint_states(path, joint_states):
    with open(path, encoding="utf-8") as file:
        dump = json.load(file)
    for series, topic in (("measured", "/joint_states"), ("reference", "/reference/joint_states")):
        expected = dump[series]
        width = len(expected["names"])
        rows = joint_states[topic]
        if len(rows) != len(expected["time_ns"]):
            problem(f"{topic}: {len(rows)} messages, expected {len(expected['time_ns'])}")
            continue
        for index, (time, names, *columns) in enumerate(rows):
            if time != expected["time_ns"][index] or names != expected["names"]:
                problem(f"{topic}: message {index}: time or names differ")
            for column, values in zip(("position", "velocity", "effort"), columns):
                if values != expected[column][index * width : (index + 1) * width]:
                    problem(f"{topic}: message {index}: {column} differs")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("recording")
    arguments.add_argument("--joint-states", metavar="DUMP.json")
    arguments = arguments.parse_args()
    messages = topics = documents = 0
    try:
        check_footer(arguments.recording)
        messages = read_records(arguments.recording)
        joint_states, counts, attachments = read_messages(arguments.recording)
        topics, documents = len(counts), len(attachments)
        if messages == 0 or sum(counts.values()) != messages:
            problem(f"{sum(counts.values())} messages through the index, {messages} in the file; expected some, all")
        decoded = read_with_rosbags(arguments.recording)
        if decoded != messages:
            problem(f"rosbags decodes {decoded} messages of {messages}")
        if arguments.joint_states:
            compare_joint_states(arguments.joint_states, joint_states)
    except Exception as error:  # whatever the libraries raise is a file that cannot be read
        problem(f"{type(error).__name__}: {error}")
    for text in problems[:20]:
        print(f"{arguments.recording}: {text}", file=sys.stderr)
    if len(problems) > 20:
        print(f"{arguments.recording}: and {len(problems) - 20} more", file=sys.stderr)
    if problems:
        return 1
    print(f"{arguments.recording}: {messages} messages on {topics} topics and {documents} attachments are as they should be")
    return 0


if __name__ == "__main__":
    sys.exit(main())
