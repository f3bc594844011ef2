#!/usr/bin/python3
"""An MCAP reader of its own, written from the public specification (https://mcap.dev/spec) and from the CDR and IDL
rules, sharing no code with palp's recorder. It checks every checksum, index and count of a file and decodes all messages
with the IDL that stands in the file.

usage: independent_reader.py FILE [--print TOPIC]
Prints one JSON object that sums the file up, or with --print each message of a topic as one JSON line.
Exit status 1 and one sentence on the first thing that is wrong."""

import argparse
import hashlib
import json
import struct
import sys
import zlib

import lz4.frame
import zstandard

sys.dont_write_bytecode = True  # a test leaves nothing in the source tree
from cdr_reader import Idl, Wrong, check, decode

MAGIC = b"\x89MCAP0\r\n"


class Fields:
    """Reads the fields of an MCAP record."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, code):
        size = struct.calcsize("<" + code)
        check(self.at + size <= len(self.data), "a record is too short")
        (value,) = struct.unpack_from("<" + code, self.data, self.at)
        self.at += size
        return value

    def take(self, n):
        check(self.at + n <= len(self.data), "a record is too short")
        self.at += n
        return self.data[self.at - n : self.at]

    def text(self):
        return self.take(self.number("I")).decode()

    def mapping(self, key, value):
        entries, out = Fields(self.take(self.number("I"))), {}
        while entries.at < len(entries.data):
            k = key(entries)
            check(k not in out, "a map has a key twice")
            out[k] = value(entries)
        return out


def records(data, start, end):
    """Yields (opcode, content, offset, length with head)."""
    at = start
    while at < end:
        check(at + 9 <= end, f"half a record at byte {at}")
        op, size = struct.unpack_from("<BQ", data, at)
        check(at + 9 + size <= end, f"the record at byte {at} is longer than the file")
        yield op, data[at + 9 : at + 9 + size], at, 9 + size
        at += 9 + size


def unpack(packed, compression, size):
    if compression == "zstd":
        data = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    elif compression == "lz4":
        data = lz4.frame.decompress(packed)
    else:
        check(compression == "", f"unknown compression {compression}")
        data = packed
    check(len(data) == size, "a chunk unpacks to another size")
    return data


def read_schema(content):
    f = Fields(content)
    return f.number("H"), {"name": f.text(), "encoding": f.text(), "data": f.take(f.number("I")).decode()}


def read_channel(content):
    f = Fields(content)
    channel_id = f.number("H")
    return channel_id, {"schema": f.number("H"), "topic": f.text(), "encoding": f.text(),
                        "metadata": f.mapping(Fields.text, Fields.text)}


def read_chunk(content):
    f = Fields(content)
    start, end, size, crc = f.number("Q"), f.number("Q"), f.number("Q"), f.number("I")
    compression = f.text()
    packed = f.take(f.number("Q"))
    data = unpack(packed, compression, size)
    check(zlib.crc32(data) == crc, "the checksum of a chunk is wrong")
    return {"start": start, "end": end, "data": data, "compression": compression, "packed": len(packed)}


class File:
    """All of a file, checked: schemas, channels, messages (channel, sequence, log time, publish time, data), metadata."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self.data = file.read()
        data = self.data
        check(data[:8] == MAGIC and data[-8:] == MAGIC, "the magic bytes are missing")
        op, size = struct.unpack_from("<BQ", data, len(data) - 37)
        check((op, size) == (2, 20), "the footer is missing")
        self.summary_start, self.offset_start, crc = struct.unpack_from("<QQI", data, len(data) - 28)
        check(zlib.crc32(data[self.summary_start : len(data) - 12]) == crc, "the checksum of the summary is wrong")
        self.schemas, self.channels, self.messages, self.metadata = {}, {}, [], []
        self.chunks, self.metadata_at = {}, {}
        self.read_data()
        self.read_summary()

    def read_data(self):
        last_chunk = None
        for op, content, at, length in records(self.data, 8, self.summary_start):
            check(at != 8 or op == 1, "the first record is no header")
            if op == 3:
                key, schema = read_schema(content)
                check(self.schemas.setdefault(key, schema) == schema, "a schema changes")
            elif op == 4:
                key, channel = read_channel(content)
                check(channel["schema"] in self.schemas, "a channel comes before its schema")
                check(self.channels.setdefault(key, channel) == channel, "a channel changes")
            elif op == 6:
                last_chunk = read_chunk(content)
                last_chunk.update(length=length, offset=at, index={}, index_length=0)
                last_chunk["at"] = self.read_messages(last_chunk)
                self.chunks[at] = last_chunk
            elif op == 7:
                self.read_message_index(content, at, length, last_chunk)
            elif op == 12:
                f = Fields(content)
                self.metadata_at[at] = (length, f.text())
                self.metadata.append((self.metadata_at[at][1], f.mapping(Fields.text, Fields.text)))
            elif op == 15:
                check(at + length == self.summary_start, "the data section does not end before the summary")
                crc = Fields(content).number("I")
                check(zlib.crc32(self.data[:at]) == crc, "the checksum of the data section is wrong")
                return
        raise Wrong("the data section has no end")

    def read_messages(self, chunk):
        """Where each message of the chunk stands: {(channel, offset): log time}."""
        found = {}
        for op, content, at, _ in records(chunk["data"], 0, len(chunk["data"])):
            check(op == 5, "something else than messages in a chunk")
            f = Fields(content)
            message = (f.number("H"), f.number("I"), f.number("Q"), f.number("Q"), f.take(len(content) - 22))
            check(message[0] in self.channels, "a message comes before its channel")
            check(chunk["start"] <= message[2] <= chunk["end"], "a message lies outside of the times of its chunk")
            found[(message[0], at)] = message[2]
            self.messages.append(message)
        check(found and min(found.values()) == chunk["start"] and max(found.values()) == chunk["end"],
              "the times of a chunk are not those of its messages")
        return found

    def read_message_index(self, content, at, length, chunk):
        f = Fields(content)
        channel = f.number("H")
        entries = Fields(f.take(f.number("I")))
        chunk["index"][channel] = at
        chunk["index_length"] += length
        while entries.at < len(entries.data):
            time, offset = entries.number("Q"), entries.number("Q")
            check(chunk["at"].pop((channel, offset), None) == time, "a message index points beside its message")

    def read_summary(self):
        groups, schemas, channels, statistics = {}, {}, {}, None
        for op, content, at, length in records(self.data, self.summary_start, self.offset_start):
            group = groups.setdefault(op, [at, 0])
            check(group[0] + group[1] == at, "the summary is not grouped")
            group[1] += length
            f = Fields(content)
            if op == 3:
                schemas.update([read_schema(content)])
            elif op == 4:
                channels.update([read_channel(content)])
            elif op == 8:
                self.check_chunk_index(f)
            elif op == 11:
                statistics = [f.number(c) for c in "QHIIIIQQ"] + [f.mapping(lambda g: g.number("H"), lambda g: g.number("Q"))]
            elif op == 13:
                offset, size = f.number("Q"), f.number("Q")
                check(self.metadata_at.pop(offset, None) == (size, f.text()), "the metadata index is wrong")
        check(schemas == self.schemas and channels == self.channels, "the summary repeats other schemas or channels")
        check(not self.metadata_at, "metadata is not indexed")
        for chunk in self.chunks.values():
            check(not chunk["at"], "a message is not indexed")
            check(chunk.get("indexed"), "a chunk is not indexed")
        counts = {}
        for message in self.messages:
            counts[message[0]] = counts.get(message[0], 0) + 1
        times = [m[2] for m in self.messages] or [0]
        check(statistics == [len(self.messages), len(schemas), len(channels), 0, len(self.metadata), len(self.chunks),
                             min(times), max(times), counts], "the statistics are wrong")
        for op, content, _, _ in records(self.data, self.offset_start, len(self.data) - 37):
            f = Fields(content)
            check(op == 14 and groups.pop(f.number("B"), None) == [f.number("Q"), f.number("Q")], "a summary offset is wrong")
        check(not groups, "a group of the summary has no offset")

    def check_chunk_index(self, f):
        start, end, offset, length = (f.number("Q") for _ in range(4))
        index = f.mapping(lambda g: g.number("H"), lambda g: g.number("Q"))
        index_length, compression, packed, size = f.number("Q"), f.text(), f.number("Q"), f.number("Q")
        chunk = self.chunks.get(offset)
        check(chunk is not None, "a chunk index points beside its chunk")
        check((start, end, length, index, index_length, compression, packed, size) ==
              (chunk["start"], chunk["end"], chunk["length"], chunk["index"], chunk["index_length"],
               chunk["compression"], chunk["packed"], len(chunk["data"])), "a chunk index is wrong")
        chunk["indexed"] = True


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("file")
    arguments.add_argument("--print", metavar="TOPIC", dest="topic")
    options = arguments.parse_args()
    file = File(options.file)
    parsed, topics = {}, {}
    for channel, sequence, log_time, publish_time, data in sorted(file.messages, key=lambda m: m[2]):
        info = file.channels[channel]
        schema = file.schemas[info["schema"]]
        check((info["encoding"], schema["encoding"]) == ("cdr", "omgidl"), "a channel is not cdr with omgidl")
        if schema["data"] not in parsed:
            parsed[schema["data"]] = Idl(schema["data"])
        idl = parsed[schema["data"]]
        check(schema["name"] in idl.types, f"the IDL has no type {schema['name']}")
        value = decode(data, idl, schema["name"])
        if info["topic"] == options.topic:
            print(json.dumps({"log_time": log_time, "publish_time": publish_time, "sequence": sequence, "message": value}))
        topic = topics.setdefault(info["topic"], {"type": schema["name"], "count": 0, "bytes": 0, "hash": hashlib.sha256()})
        topic["count"] += 1
        topic["bytes"] += len(data)
        topic["hash"].update(data)
    if not options.topic:
        for topic in topics.values():
            topic["hash"] = topic["hash"].hexdigest()
        print(json.dumps({"messages": len(file.messages), "chunks": len(file.chunks), "topics": topics,
                          "metadata": file.metadata}, indent=2))


if __name__ == "__main__":
    try:
        main()
    except (Wrong, OSError, ValueError, KeyError, RuntimeError, zstandard.ZstdError) as error:
        sys.exit(f"independent_reader: {sys.argv[1] if len(sys.argv) > 1 else ''}: {error}")
