"""Receives the ultrasound images that a live session sends out over OpenIGTLink, and compares them
with those of its replay.

    received_images.py PORT FOLDER              one file for each image, until the session ends
    received_images.py --compare FOLDER MHA     all but the first few are frames of the sequence
"""
import pathlib
import socket
import struct
import sys
import time

HEADER = struct.Struct(">H12s20sQQQ")


def receive(sock, count):
    data = bytearray()
    while len(data) < count:
        part = sock.recv(count - len(data))
        if not part:
            return None
        data += part
    return bytes(data)


def connect(port):
    for _ in range(400):
        try:
            return socket.create_connection(("127.0.0.1", port))
        except OSError:
            time.sleep(0.05)
    sys.exit(f"nobody listens on port {port}")


def store_images(port, folder):
    folder.mkdir()
    sock = connect(port)
    number = 0
    while (head := receive(sock, HEADER.size)) is not None:
        _, kind, name, _, size, _ = HEADER.unpack(head)
        body = receive(sock, size)
        if body is None:
            return
        if kind.rstrip(b"\0") == b"IMAGE" and name.rstrip(b"\0") == b"Ultrasound":
            (folder / f"{number:05}").write_bytes(body[72:])
            number += 1


def compare(folder, sequence):
    data = sequence.read_bytes()
    mark = b"ElementDataFile = LOCAL\n"
    pixels = data[data.index(mark) + len(mark):]
    seen = [file.read_bytes() for file in sorted(folder.iterdir())]
    size = len(seen[0])
    frames = [pixels[at:at + size] for at in range(0, len(pixels), size)]
    places = {frame: number for number, frame in enumerate(frames)}
    found = [places.get(image) for image in seen]
    # The first ones were made by the session itself, at moments of its own.
    first = next((i for i, place in enumerate(found) if place is not None), len(found))
    rest = found[first:]
    wrong = sum(place is None for place in rest)
    print(f"{len(set(rest) - {None})} different images are frames of the replay, {wrong} are not, "
          f"{first} came before")


if __name__ == "__main__":
    if sys.argv[1] == "--compare":
        compare(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
    else:
        store_images(int(sys.argv[1]), pathlib.Path(sys.argv[2]))
