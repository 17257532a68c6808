#!/usr/bin/env python3
"""Makes seeds for network_reader_fuzz: the first packets of each stream of a recording, as a server sends them.

    network_reader_seeds.py OUT FILE.aedat4…
"""

import os
import re
import struct
import sys


def header_of_one_stream(header, stream):
    """The header of the recording with blanks instead of the nodes of other streams. No offset changes."""
    xml_at = header.index(b"<dv")
    xml = header[xml_at:].split(b"\0")[0]
    kept = xml
    for node in re.finditer(rb'<node name="(\d+)" path="[^"]*outInfo/\d+/">.*?</node>\s*</node>', xml, re.DOTALL):
        if int(node.group(1)) != stream:
            kept = kept.replace(node.group(0), b" " * len(node.group(0)))
    return header[:xml_at] + kept + header[xml_at + len(xml):]


def main():
    out, *files = sys.argv[1:]
    os.makedirs(out, exist_ok=True)
    for file in files:
        data = open(file, "rb").read()
        end = 18 + struct.unpack_from("<I", data, 14)[0]
        header = data[14:end]
        table = struct.unpack_from("<q", data, 54)[0]
        packets = {}
        at = end
        while at + 8 <= (table if table > 0 else len(data)):
            stream, size = struct.unpack_from("<iI", data, at)
            packets.setdefault(stream, []).append(data[at:at + 8 + size])
            at += 8 + size
        for stream, parts in packets.items():
            body = b""
            for part in sorted(parts[:20], key=len)[:3]:
                body += part
            name = f"{os.path.splitext(os.path.basename(file))[0]}-{stream}"
            for cut in (0, 7):
                with open(os.path.join(out, f"{name}-{cut}"), "wb") as seed:
                    seed.write(bytes([cut]) + header_of_one_stream(header, stream) + body)


main()
