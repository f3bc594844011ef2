// Turns the records of an MCAP file into bytes and back. A record's content is what follows its opcode and length.
#pragma once

#include "idl/mcap/byte_cursor.h"
#include "idl/mcap/mcap_format.h"

namespace palp {

// Continues the CRC-32 that `before` is of the bytes in front; 0 begins one.
std::uint32_t crc32_of(std::uint32_t before, ByteView bytes);

// Return the content of the record.
Bytes encode(const McapSchema& schema);
Bytes encode(const McapChannel& channel);
Bytes encode(const McapMetadata& metadata);
Bytes encode(const McapChunkIndex& chunk);
Bytes encode(const McapStatistics& statistics);

// Read the content of a record. Throw McapError when it ends too early.
McapSchema decode_schema(ByteCursor in);
McapChannel decode_channel(ByteCursor in);
// The data of the message points into the bytes that `in` reads.
McapMessage decode_message(ByteCursor in);
McapMetadata decode_metadata(ByteCursor in);
McapChunkIndex decode_chunk_index(ByteCursor in);
McapStatistics decode_statistics(ByteCursor in);

}  // namespace palp
