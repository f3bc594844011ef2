#include "idl/mcap/compression.h"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

namespace palp {
namespace {

constexpr int kZstdLevel = 1;  // higher levels cost much and gain little on samples of this size

Bytes compress_lz4(ByteView data) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentSize = data.size();
  Bytes out(LZ4F_compressFrameBound(data.size(), &preferences));
  const std::size_t n = LZ4F_compressFrame(out.data(), out.size(), data.data(), data.size(), &preferences);
  if (LZ4F_isError(n)) throw std::runtime_error(std::string("lz4 cannot compress: ") + LZ4F_getErrorName(n));
  out.resize(n);
  return out;
}

Bytes compress_zstd(ByteView data) {
  Bytes out(ZSTD_compressBound(data.size()));
  const std::size_t n = ZSTD_compress(out.data(), out.size(), data.data(), data.size(), kZstdLevel);
  if (ZSTD_isError(n)) throw std::runtime_error(std::string("zstd cannot compress: ") + ZSTD_getErrorName(n));
  out.resize(n);
  return out;
}

void decompress_lz4(ByteView packed, Bytes& out) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)))
    throw std::runtime_error("lz4 has no memory left");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                     LZ4F_freeDecompressionContext);
  std::size_t in = 0;
  std::size_t done = 0;
  std::size_t hint = 1;
  while (hint != 0) {
    std::size_t read = packed.size() - in;
    std::size_t wrote = out.size() - done;
    hint = LZ4F_decompress(context.get(), out.data() + done, &wrote, packed.data() + in, &read, nullptr);
    if (LZ4F_isError(hint)) throw std::runtime_error(std::string("damaged lz4 data: ") + LZ4F_getErrorName(hint));
    in += read;
    done += wrote;
    if (read == 0 && wrote == 0) break;
  }
  if (hint != 0 || done != out.size()) throw std::runtime_error("damaged lz4 data: it unpacks to another size");
}

}  // namespace

std::string mcap_name(Compression compression) {
  switch (compression) {
    case Compression::lz4:
      return "lz4";
    case Compression::zstd:
      return "zstd";
    case Compression::none:
      break;
  }
  return "";
}

Compression compression_from_mcap(const std::string& name) {
  if (name.empty()) return Compression::none;
  if (name == "lz4") return Compression::lz4;
  if (name == "zstd") return Compression::zstd;
  throw std::invalid_argument("unknown compression '" + name + "', expected lz4, zstd or none");
}

Bytes compress(ByteView data, Compression compression) {
  if (compression == Compression::lz4) return compress_lz4(data);
  if (compression == Compression::zstd) return compress_zstd(data);
  return Bytes(data.begin(), data.end());
}

Bytes decompress(ByteView packed, Compression compression, std::size_t size) {
  if (size > kMaxChunkBytes) throw std::runtime_error("unpacked size " + std::to_string(size) + " is too large");
  Bytes out(size);
  if (compression == Compression::lz4) {
    decompress_lz4(packed, out);
  } else if (compression == Compression::zstd) {
    const std::size_t n = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
    if (ZSTD_isError(n)) throw std::runtime_error(std::string("damaged zstd data: ") + ZSTD_getErrorName(n));
    if (n != size) throw std::runtime_error("damaged zstd data: it unpacks to another size");
  } else {
    if (packed.size() != size) throw std::runtime_error("an uncompressed chunk says two sizes");
    std::copy(packed.begin(), packed.end(), out.begin());
  }
  return out;
}

}  // namespace palp
