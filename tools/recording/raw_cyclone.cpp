// Raw samples with Cyclone DDS: a type of our own ("blob") whose samples are the serialised bytes. The headers dds/ddsi
// are public in Debian's package but internal to Cyclone, and their layout changes between versions: this file is for
// 0.10.
#include <dds/dds.h>
#include <dds/ddsi/ddsi_keyhash.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>
#include <dds/version.h>

#include <array>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "idl/dds/cyclone_participant.h"
#include "tools/recording/raw_bus.h"

static_assert(DDS_VERSION_MAJOR == 0 && DDS_VERSION_MINOR == 10, "raw_cyclone.cpp is written for Cyclone DDS 0.10");

namespace palp {
namespace {

constexpr std::uint32_t kPadding = 3;  // Cyclone reads payloads in multiples of 4 bytes

struct BlobType : ddsi_sertype {
  std::size_t key_size = 0;
};

// The bytes of one sample, or, of kind SDK_KEY, of a key alone.
struct Blob : ddsi_serdata {
  std::vector<std::uint8_t> bytes;  // with the encapsulation header; padded with zeros to a multiple of 4
  std::uint32_t size = 0;           // without the padding
  std::array<std::uint8_t, 16> key{};
};

const Blob& blob(const ddsi_serdata* d) { return *static_cast<const Blob*>(d); }

Blob* new_blob(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t size) {
  auto* b = new Blob();
  ddsi_serdata_init(b, type, kind);
  b->size = static_cast<std::uint32_t>(size);
  b->bytes.resize((size + kPadding) & ~std::size_t{kPadding});
  return b;
}

std::uint32_t key_hash(const std::array<std::uint8_t, 16>& key) {
  std::uint32_t hash = 2166136261u;
  for (const std::uint8_t byte : key) hash = (hash ^ byte) * 16777619u;
  return hash;
}

// Finds the key of the bytes that were filled in; a payload that has none is refused.
ddsi_serdata* finish(Blob* b, const ddsi_sertype* type) {
  const std::size_t key_size = static_cast<const BlobType*>(type)->key_size;
  if (!raw_key(Payload(b->bytes).first(b->size), key_size, b->key)) {
    delete b;
    return nullptr;
  }
  b->hash = key_hash(b->key) ^ type->serdata_basehash;
  return b;
}

bool equal_keys(const ddsi_serdata* a, const ddsi_serdata* b) { return blob(a).key == blob(b).key; }
std::uint32_t size_of_blob(const ddsi_serdata* d) { return blob(d).size; }

ddsi_serdata* from_network(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment, size_t size) {
  Blob* b = new_blob(type, kind, size);
  std::uint32_t done = 0;
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    if (fragment->maxp1 <= done) continue;  // fragments may overlap
    const unsigned char* payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    if (fragment->min > done || fragment->maxp1 > size) break;
    std::memcpy(b->bytes.data() + done, payload + (done - fragment->min), fragment->maxp1 - done);
    done = fragment->maxp1;
  }
  if (done != size) {
    delete b;
    return nullptr;
  }
  return finish(b, type);
}

ddsi_serdata* from_memory(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                          const ddsrt_iovec_t* parts, size_t size) {
  Blob* b = new_blob(type, kind, size);
  std::size_t done = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < count && done < size; ++i) {
    const std::size_t n = std::min<std::size_t>(parts[i].iov_len, size - done);
    std::memcpy(b->bytes.data() + done, parts[i].iov_base, n);
    done += n;
  }
  return finish(b, type);
}

ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash* hash) {
  const std::size_t key_size = static_cast<const BlobType*>(type)->key_size;
  Blob* b = new_blob(type, SDK_KEY, 4 + key_size);  // header 0 0: big-endian, as the hash is
  std::memcpy(b->bytes.data() + 4, hash->value, key_size);
  return finish(b, type);
}

ddsi_serdata* no_sample(const ddsi_sertype*, ddsi_serdata_kind, const void*) { return nullptr; }

void to_bytes(const ddsi_serdata* d, size_t offset, size_t size, void* out) {
  std::memcpy(out, blob(d).bytes.data() + offset, size);
}
ddsi_serdata* to_bytes_in_place(const ddsi_serdata* d, size_t offset, size_t size, ddsrt_iovec_t* out) {
  out->iov_base = const_cast<std::uint8_t*>(blob(d).bytes.data()) + offset;
  out->iov_len = size;
  return ddsi_serdata_ref(d);
}
void release_bytes(ddsi_serdata* d, const ddsrt_iovec_t*) { ddsi_serdata_unref(d); }

bool to_sample(const ddsi_serdata*, void*, void**, void*) { return false; }
bool key_to_sample(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) { return false; }

ddsi_serdata* key_alone(const ddsi_serdata* d) {
  Blob* b = new_blob(d->type, SDK_KEY, 20);
  b->type = nullptr;  // what Cyclone asks of an untyped sample
  b->key = blob(d).key;
  std::memcpy(b->bytes.data() + 4, b->key.data(), b->key.size());
  b->hash = d->hash;
  return b;
}

void free_blob(ddsi_serdata* d) { delete static_cast<Blob*>(d); }
size_t print(const ddsi_sertype*, const ddsi_serdata*, char* text, size_t size) {
  return static_cast<size_t>(std::snprintf(text, size, "(bytes)"));
}
void keyhash_of(const ddsi_serdata* d, ddsi_keyhash* out, bool) {
  std::memcpy(out->value, blob(d).key.data(), sizeof out->value);
}

const ddsi_serdata_ops* serdata_ops() {
  static const ddsi_serdata_ops ops = [] {
    ddsi_serdata_ops o{};
    o.eqkey = equal_keys;
    o.get_size = size_of_blob;
    o.from_ser = from_network;
    o.from_ser_iov = from_memory;
    o.from_keyhash = from_keyhash;
    o.from_sample = no_sample;
    o.to_ser = to_bytes;
    o.to_ser_ref = to_bytes_in_place;
    o.to_ser_unref = release_bytes;
    o.to_sample = to_sample;
    o.to_untyped = key_alone;
    o.untyped_to_sample = key_to_sample;
    o.free = free_blob;
    o.print = print;
    o.get_keyhash = keyhash_of;
    return o;
  }();
  return &ops;
}

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete static_cast<BlobType*>(type);
}
bool equal_types(const ddsi_sertype* a, const ddsi_sertype* b) {
  return static_cast<const BlobType*>(a)->key_size == static_cast<const BlobType*>(b)->key_size;
}
std::uint32_t hash_type(const ddsi_sertype* type) {
  return static_cast<std::uint32_t>(static_cast<const BlobType*>(type)->key_size);
}
void zero_samples(const ddsi_sertype*, void*, size_t) {}
void realloc_samples(void** samples, const ddsi_sertype*, void*, size_t, size_t count) {
  for (size_t i = 0; i < count; ++i) samples[i] = nullptr;
}
void free_samples(const ddsi_sertype*, void**, size_t, dds_free_op_t) {}

const ddsi_sertype_ops* sertype_ops() {
  static const ddsi_sertype_ops ops = [] {
    ddsi_sertype_ops o{};
    o.version = ddsi_sertype_v0;
    o.free = free_type;
    o.zero_samples = zero_samples;
    o.realloc_samples = realloc_samples;
    o.free_samples = free_samples;
    o.equal = equal_types;
    o.hash = hash_type;
    return o;
  }();
  return &ops;
}

class Entity {
 public:
  explicit Entity(dds_entity_t entity = 0) : entity_(entity) {}
  ~Entity() {
    if (entity_ > 0) dds_delete(entity_);
  }
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  operator dds_entity_t() const { return entity_; }

 private:
  dds_entity_t entity_;
};

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

// The bus's QoS with another depth.
Qos reader_qos(TopicRow row, int depth) {
  row.reader_depth = depth;
  return {cyclone_qos(row, true), dds_delete_qos};
}

// `type` is set to the type that the topic came to use.
dds_entity_t create_topic(dds_entity_t participant, const TopicRow& row, ddsi_sertype*& type) {
  auto* blob_type = new BlobType();
  ddsi_sertype_init(blob_type, row.type_name, sertype_ops(), serdata_ops(), row.key_bytes == 0);
  blob_type->key_size = row.key_bytes;
  blob_type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  type = blob_type;
  const dds_entity_t topic = dds_create_topic_sertype(participant, row.name, &type, nullptr, nullptr, nullptr);
  if (topic < 0) ddsi_sertype_unref(blob_type);
  return cyclone_check(topic, std::string("cannot create the topic ") + row.name);
}

class CycloneReader : public RawReader {
 public:
  CycloneReader(dds_entity_t participant, dds_entity_t waitset, const TopicRow& row, int depth)
      : topic_(create_topic(participant, row, type_)),
        reader_(cyclone_check(dds_create_reader(participant, topic_, reader_qos(row, depth).get(), nullptr),
                              std::string("cannot read from ") + row.name)),
        waitset_(waitset),
        condition_(cyclone_check(dds_create_readcondition(reader_, DDS_ANY_STATE), "cannot wait")) {
    cyclone_check(dds_waitset_attach(waitset_, condition_, 0), "cannot wait");
  }
  ~CycloneReader() override { dds_waitset_detach(waitset_, condition_); }

  std::size_t take(const std::function<void(Payload, std::int64_t)>& on_sample) override {
    constexpr std::uint32_t kBatch = 64;
    std::array<ddsi_serdata*, kBatch> samples{};
    std::array<dds_sample_info_t, kBatch> infos{};
    std::size_t count = 0;
    while (true) {
      const dds_return_t n = dds_takecdr(reader_, samples.data(), kBatch, infos.data(), DDS_ANY_STATE);
      for (dds_return_t i = 0; i < n; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (infos[at].valid_data && samples[at]->kind == SDK_DATA) {
          const Blob& b = blob(samples[at]);
          on_sample(Payload(b.bytes).first(b.size), infos[at].source_timestamp);
          ++count;
        }
        ddsi_serdata_unref(samples[at]);
      }
      if (n < static_cast<dds_return_t>(kBatch)) return count;
    }
  }
  std::uint64_t lost() const override {
    dds_sample_lost_status_t status{};
    if (dds_get_sample_lost_status(reader_, &status) == DDS_RETCODE_OK) lost_ += status.total_count_change;
    return lost_;
  }
  int matched_writers() const override {
    dds_subscription_matched_status_t status{};
    dds_get_subscription_matched_status(reader_, &status);
    return static_cast<int>(status.current_count);
  }

 private:
  ddsi_sertype* type_ = nullptr;
  Entity topic_;
  Entity reader_;
  dds_entity_t waitset_;
  Entity condition_;
  mutable std::uint64_t lost_ = 0;
};

class CycloneWriter : public RawWriter {
 public:
  CycloneWriter(dds_entity_t participant, const TopicRow& row)
      : topic_(create_topic(participant, row, type_)),
        writer_(cyclone_check(
            dds_create_writer(participant, topic_, Qos(cyclone_qos(row, false), dds_delete_qos).get(), nullptr),
            std::string("cannot write to ") + row.name)) {}

  bool write(Payload payload) override {
    ddsrt_iovec_t part{};
    part.iov_base = const_cast<std::uint8_t*>(payload.data());
    part.iov_len = payload.size();
    ddsi_serdata* sample = ddsi_serdata_from_ser_iov(type_, SDK_DATA, 1, &part, payload.size());
    if (sample == nullptr) return false;
    return dds_writecdr(writer_, sample) == DDS_RETCODE_OK;  // takes the sample
  }
  int matched_readers() const override {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_, &status);
    return static_cast<int>(status.current_count);
  }
  bool wait_acknowledged(std::chrono::milliseconds timeout) override {
    return dds_wait_for_acks(writer_, DDS_MSECS(timeout.count())) == DDS_RETCODE_OK;
  }

 private:
  ddsi_sertype* type_ = nullptr;
  Entity topic_;
  Entity writer_;
};

class CycloneRawBus : public RawBus {
 public:
  explicit CycloneRawBus(const BusOptions& options)
      : participant_(options),
        entity_(participant_.entity()),
        waitset_(cyclone_check(dds_create_waitset(entity_), "cannot create a wait set")) {}

  std::unique_ptr<RawReader> reader(const TopicRow& topic, int depth) override {
    return std::make_unique<CycloneReader>(entity_, waitset_, topic, depth);
  }
  std::unique_ptr<RawWriter> writer(const TopicRow& topic) override {
    return std::make_unique<CycloneWriter>(entity_, topic);
  }
  bool wait(std::chrono::milliseconds timeout) override {
    return dds_waitset_wait(waitset_, nullptr, 0, DDS_MSECS(timeout.count())) > 0;
  }

 private:
  CycloneParticipant participant_;
  dds_entity_t entity_;
  Entity waitset_;
};

}  // namespace

std::unique_ptr<RawBus> open_raw_cyclone(const BusOptions& options) { return std::make_unique<CycloneRawBus>(options); }

}  // namespace palp
