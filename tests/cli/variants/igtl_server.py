"""A sender of OpenIGTLink messages on the loopback, written from the protocol's description; ends by itself.

Usage: igtl_server.py MODE SECONDS DEVICES. Writes the devices file of acus-live for it, then waits for one client.
"""
import json
import math
import pathlib
import socket
import struct
import sys
import time

NAME = "ProbeToReference"
TABLE = []
for n in range(256):
    remainder = n << 56
    for _ in range(8):
        remainder = ((remainder << 1) ^ 0x42F0E1EBA9EA3693 if remainder >> 63 else remainder << 1) & (2**64 - 1)
    TABLE.append(remainder)


def crc(data):
    value = 0
    for byte in data:
        value = TABLE[((value >> 56) ^ byte) & 255] ^ (value << 8) & (2**64 - 1)
    return value


def message(kind, name, body, stamp, version=1, check=None, size=None):
    return struct.pack(">H12s20sQQQ", version, kind, name.encode()[:20], int(stamp * 2**32),
                       len(body) if size is None else size, crc(body) if check is None else check) + body


def extended(content, metadata=()):
    sizes = b"".join(struct.pack(">HHI", len(k), 3, len(v)) for k, v in metadata)
    head = struct.pack(">H", len(metadata)) + sizes if metadata else b""
    text = b"".join(k + v for k, v in metadata)
    return struct.pack(">HHII", 12, len(head), len(text), 7) + content + head + text


def pose(t, columns=None):
    a = 0.2 * math.sin(t)
    turn = columns or ((math.cos(a), 0, -math.sin(a)), (0, 1, 0), (math.sin(a), 0, math.cos(a)))
    return struct.pack(">12f", *(v for column in turn for v in column), 10 * math.sin(t), 5, 20)


def scaled(factor, t):
    return pose(t, tuple(tuple(factor * (i == j) for i in range(3)) for j in range(3)))


def quaternion(t):
    return struct.pack(">20sBB7f", NAME.encode(), 1, 0, 10 * math.sin(t), 5, 20, 0, 0, 0, 1)


TRANSFORM, STATUS = b"TRANSFORM", b"STATUS"
OTHER = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
MODES = {
    "plain": lambda t: message(TRANSFORM, NAME, pose(t), t),
    "version_2": lambda t: message(TRANSFORM, NAME, extended(pose(t)), t, 2),
    "version_2_metadata": lambda t: message(
        TRANSFORM, NAME, extended(pose(t), [(b"TransformStatus", b"OK"), (b"Tool", b"8700339")]), t, 2),
    "version_3": lambda t: message(TRANSFORM, NAME, extended(pose(t)), t, 3),
    "version_4": lambda t: message(TRANSFORM, NAME, extended(pose(t)), t, 4),
    "metadata_not_seen": lambda t: message(
        TRANSFORM, NAME, extended(pose(t), [(b"TransformStatus", b"OUT_OF_VIEW")]), t, 2),
    "others_between": lambda t: message(STATUS, "PLUS", struct.pack(">Hq20s", 1, 0, b"OK") + b"\0", t) +
    message(TRANSFORM, "StylusToTracker", pose(t), t) + message(TRANSFORM, NAME, pose(t), t),
    "two_at_once": lambda t: 2 * message(TRANSFORM, NAME, pose(t), t),
    "time_zero": lambda t: message(TRANSFORM, NAME, pose(t), 0),
    "clock_ahead": lambda t: message(TRANSFORM, NAME, pose(t), t + 7200),
    "scaled_by_float": lambda t: message(TRANSFORM, NAME, scaled(1.0001, t), t),
    "qtdata": lambda t: message(b"QTDATA", "Tools", quaternion(t), t),
    "tdata": lambda t: message(b"TDATA", "Tools", struct.pack(">20sBB", NAME.encode(), 1, 0) + pose(t), t),
    "position": lambda t: message(b"POSITION", NAME, struct.pack(">7f", 10 * math.sin(t), 5, 20, 0, 0, 0, 1), t),
    "junk_before": lambda t: b"\0\1junk" + message(TRANSFORM, NAME, pose(t), t),
    "crc_zero": lambda t: message(TRANSFORM, NAME, pose(t), t, check=0),
    "crc_wrong": lambda t: message(TRANSFORM, NAME, pose(t), t, check=crc(pose(t)) ^ 1),
    "lower_case": lambda t: message(TRANSFORM, NAME.lower(), pose(t), t),
    "upper_case": lambda t: message(TRANSFORM, NAME.upper(), pose(t), t),
    "other_name": lambda t: message(TRANSFORM, "ProbeToTracker", pose(t), t),
    "blank_behind": lambda t: message(TRANSFORM, NAME + " ", pose(t), t),
    "scaled_5_percent": lambda t: message(TRANSFORM, NAME, scaled(1.05, t), t),
    "scaled_metres": lambda t: message(TRANSFORM, NAME, scaled(0.001, t), t),
    "mirrored": lambda t: message(TRANSFORM, NAME, pose(t, ((-1, 0, 0), (0, 1, 0), (0, 0, 1))), t),
    "sheared": lambda t: message(TRANSFORM, NAME, pose(t, ((1, 0, 0), (0.1, 1, 0), (0, 0, 1))), t),
    "all_zero": lambda t: message(TRANSFORM, NAME, bytes(48), t),
    "not_a_number": lambda t: message(TRANSFORM, NAME, struct.pack(">12f", *([math.nan] * 12)), t),
    "status_only": lambda t: message(STATUS, NAME, struct.pack(">Hq20s", 1, 0, b"OK") + b"\0", t),
    "text_only": lambda t: message(b"STRING", NAME, struct.pack(">HH", 3, 2) + b"hi", t),
    "size_wrong": lambda t: message(TRANSFORM, NAME, pose(t)[:40], t),
    "size_huge": lambda t: message(TRANSFORM, NAME, pose(t), t, size=2**40),
    "text_of_http": lambda t: b"HTTP/1.1 400 Bad Request\r\n\r\n",
    "silent": lambda t: b"",
}


def main():
    mode, seconds, devices = sys.argv[1], float(sys.argv[2]), pathlib.Path(sys.argv[3])
    server = socket.socket()
    server.bind(("127.0.0.1", 0))
    server.listen(1)
    server.settimeout(20)
    text = json.dumps({
        "format": "acus-devices/1", "name": mode, "needle": {"device": "right"},
        "devices": [{"name": "right", "driver": "virtual_hand", "safety": {"max_force_n": 10, "max_torque_nmm": 500}}],
        "trackers": [{"name": "PLUS", "host": "localhost", "port": server.getsockname()[1],
                      "tools": [{"tool": "probe", "device": NAME}]}]})
    devices.with_suffix(".part").write_text(text)
    devices.with_suffix(".part").rename(devices)
    client, _ = server.accept()
    end = time.time() + seconds
    try:
        while time.time() < end:
            client.sendall(MODES[mode](time.time()))
            time.sleep(0.02)
    except (BrokenPipeError, ConnectionResetError):
        pass


if __name__ == "__main__":
    main()
