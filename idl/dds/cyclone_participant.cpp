#include "idl/dds/cyclone_participant.h"

#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsi/ddsi_serdata_default.h>
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>

// Stands in front of Cyclone's function of this name, which checks received bytes and puts them in the host's byte
// order. The one in Cyclone 0.10.2 writes past the end of a sample that says it is XCDR2, whoever sent it. palp's types
// travel as XCDR1 only, so other encodings of them are refused here, and counted and dropped as undecodable.
extern "C" bool dds_stream_normalize(void* data, std::uint32_t size, bool bswap, std::uint32_t xcdr_version,
                                     const ddsi_sertype_default* type, bool just_key, std::uint32_t* actual_size) {
  static const auto original =
      reinterpret_cast<decltype(&dds_stream_normalize)>(dlsym(RTLD_NEXT, "dds_stream_normalize"));
  const bool ours = std::string_view(type->c.type_name).substr(0, 12) == "palp::wire::";
  if (!original || (ours && xcdr_version != CDR_ENC_VERSION_1)) return false;
  return original(data, size, bswap, xcdr_version, type, just_key, actual_size);
}

namespace palp {
namespace {

// A name or address of the user goes into the XML as it is; bus.cpp has refused whatever could break out of it.
std::string interfaces(const BusOptions& options) {
  if (!options.network) return R"(<Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>)";
  if (options.interface.empty()) return "";
  const bool is_address = options.interface.find_first_not_of("0123456789.") == std::string::npos;
  return std::string("<Interfaces><NetworkInterface ") + (is_address ? "address" : "name") + "=\"" + options.interface +
         "\"/></Interfaces>";
}

// Cyclone knows a domain once per process. A second bus on the same domain gets a domain of its own under another
// number, which takes the intended one towards the outside; so the two meet on the wire like any other peers.
dds_entity_t create_domain(int domain, const std::string& config) {
  static std::atomic<dds_domainid_t> next{1000};
  const std::string outside = "<CycloneDDS><Domain Id=\"any\"><Discovery><ExternalDomainId>" + std::to_string(domain) +
                              "</ExternalDomainId></Discovery></Domain></CycloneDDS>";
  const std::string whole = config + "," + outside;
  dds_entity_t result = dds_create_domain(static_cast<dds_domainid_t>(domain), whole.c_str());
  while (result == DDS_RETCODE_PRECONDITION_NOT_MET) result = dds_create_domain(next++, whole.c_str());
  return result;
}

// How often Cyclone could not decode a sample, by topic; and what it said of packets that it did not understand.
std::array<std::atomic<std::uint64_t>, kTopics.size()> undecodable{};
std::atomic<std::uint64_t> bad_packets = 0;

// Looks for "deserialization TOPIC/TYPE failed" (0.10; tests/idl/fuzz_test.cpp would notice another wording). A
// hostile peer must not fill the log either: of each kind the first is shown. Called by any of Cyclone's threads.
void log_sink(void*, const dds_log_data_t* data) {
  const std::string_view message(data->message, data->size);
  std::atomic<std::uint64_t>* counter = message.find("malformed packet") != message.npos ? &bad_packets : nullptr;
  for (std::size_t i = 0; i < kTopics.size() && !counter; ++i) {
    const std::string text = std::string("deserialization ") + kTopics[i].name + "/";
    if (message.find(text) != message.npos) counter = &undecodable[i];
  }
  if (counter && (*counter)++ > 0) return;
  // time, domain and thread stand before the message
  std::fprintf(stderr, "%s%s", data->message - data->hdrsize,
               counter ? "  (more of this kind is counted, not shown)\n" : "");
}

// Cyclone refuses files that it cannot open or understand, but takes one with nothing in it for its defaults, which
// reach every interface. CYCLONEDDS_URI is a list of files and configuration text; text stands last.
bool says_something(const std::string& uri) {
  std::size_t begin = 0;
  while (begin < uri.size() && uri[begin] != '<') {
    const std::size_t end = std::min(uri.find(',', begin), uri.size());
    std::string name = uri.substr(begin, end - begin);
    if (name.rfind("file://", 0) == 0) name.erase(0, 7);
    std::ifstream file(name);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.find("<CycloneDDS") == std::string::npos) return false;
    begin = end + 1;
  }
  return !uri.empty();
}

}  // namespace

std::uint64_t cyclone_undecodable(const TopicRow& topic) {
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    if (std::string_view(kTopics[i].name) == topic.name) return undecodable[i];
  }
  return 0;
}

dds_entity_t cyclone_check(dds_entity_t result, const std::string& what) {
  if (result < 0) throw std::runtime_error("Cyclone DDS: " + what + ": " + dds_strretcode(result));
  return result;
}

std::string cyclone_config(const BusOptions& options) {
  std::string peers = R"(<Peer Address="127.0.0.1"/>)";
  for (const std::string& peer : options.peers) peers += "<Peer Address=\"" + peer + "\"/>";
  const std::string buffer =
      options.socket_buffer_bytes > 0 ? std::to_string(options.socket_buffer_bytes) + "B" : std::string("64MB");
  // Fragments of 65000 B: a particle chunk stays one datagram. Unicast discovery probes the ports of participants 0..60
  // of each peer, four times a second: that finds a peer of the other vendor in a third of a second.
  return R"(<CycloneDDS><Domain Id="any"><General>)" + interfaces(options) + "<AllowMulticast>" +
         (options.network ? "spdp" : "false") +
         "</AllowMulticast><MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize></General>"
         "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>"
         "<SPDPInterval>250ms</SPDPInterval><Peers>" +
         peers + "</Peers></Discovery><Internal><SocketReceiveBufferSize min=\"default\" max=\"" + buffer +
         "\"/></Internal></Domain></CycloneDDS>";
}

CycloneParticipant::CycloneParticipant(const BusOptions& options) {
  dds_set_log_sink(log_sink, nullptr);
  const char* uri = std::getenv("CYCLONEDDS_URI");
  const bool from_user = uri && *uri;
  const bool usable = !from_user || says_something(uri);
  domain_ = usable ? create_domain(options.domain, from_user ? std::string(uri) : cyclone_config(options))
                   : DDS_RETCODE_ERROR;
  dds_domainid_t id = 0;
  if (domain_ >= 0 && dds_get_domainid(domain_, &id) == DDS_RETCODE_OK) {
    participant_ = dds_create_participant(id, nullptr, nullptr);
  }
  if (domain_ >= 0 && participant_ >= 0) return;
  const dds_return_t reason = domain_ < 0 ? domain_ : participant_;
  if (domain_ >= 0) dds_delete(domain_);
  if (from_user) {
    throw std::runtime_error("Cyclone DDS cannot use the configuration in CYCLONEDDS_URI=" + std::string(uri) + " (" +
                             dds_strretcode(reason) +
                             "): expected a readable, well-formed file or text; correct or unset it");
  }
  throw std::runtime_error("Cyclone DDS cannot open domain " + std::to_string(options.domain) + " on " +
                           (options.network ? "the network" : "the loopback interface") + " (" +
                           dds_strretcode(reason) +
                           "): check --interface and --peer, and that fewer than 60 participants run on this host");
}

CycloneParticipant::~CycloneParticipant() { dds_delete(domain_); }

dds_qos_t* cyclone_qos(const TopicRow& topic, bool reader) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(
      qos, topic.reliability == Reliability::reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
      DDS_MSECS(100));
  dds_qset_durability(
      qos, topic.durability == Durability::transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  const int depth = reader ? topic.reader_depth : topic.writer_depth;
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, topic.writer_depth, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  if (topic.key_bytes > 0 && reader)
    dds_qset_resource_limits(qos, DDS_LENGTH_UNLIMITED, kMaxKeys, DDS_LENGTH_UNLIMITED);
  return qos;
}

std::shared_ptr<Participant> open_cyclone(const BusOptions& options) {
  return std::make_shared<CycloneParticipant>(options);
}

}  // namespace palp
