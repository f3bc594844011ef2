// The three compressions that MCAP chunks use: none, lz4 (frame format) and zstd.
#pragma once

#include <string>

#include "idl/mcap/mcap_format.h"

namespace palp {

enum class Compression { none, lz4, zstd };

// Returns the name in the file: "", "lz4", "zstd".
std::string mcap_name(Compression compression);
// Throws std::invalid_argument naming what is accepted.
Compression compression_from_mcap(const std::string& name);

// Throws std::runtime_error when the library refuses.
Bytes compress(ByteView data, Compression compression);
// Unpacks exactly `size` bytes (at most kMaxChunkBytes). Throws std::runtime_error when the packed bytes are damaged or
// unpack to another size. Never trusts a length that stands in the packed bytes.
Bytes decompress(ByteView packed, Compression compression, std::size_t size);

}  // namespace palp
