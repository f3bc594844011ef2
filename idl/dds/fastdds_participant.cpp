#include "idl/dds/fastdds_participant.h"

#include <arpa/inet.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <ifaddrs.h>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <stdexcept>

namespace palp {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

constexpr std::uint32_t kMaxParticipantsPerHost = 60;

// Returns the address of an interface: Fast DDS wants an address where a person may give a name.
std::string address_of(const std::string& interface) {
  in_addr ignored;
  if (inet_pton(AF_INET, interface.c_str(), &ignored) == 1) return interface;
  std::string address;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) == 0) {
    for (const ifaddrs* i = list; i; i = i->ifa_next) {
      if (interface != i->ifa_name || !i->ifa_addr || i->ifa_addr->sa_family != AF_INET) continue;
      char text[INET_ADDRSTRLEN];
      const auto* in = reinterpret_cast<const sockaddr_in*>(i->ifa_addr);
      if (inet_ntop(AF_INET, &in->sin_addr, text, sizeof text)) address = text;
    }
    freeifaddrs(list);
  }
  if (address.empty()) {
    throw std::runtime_error(
        "network interface \"" + interface +
        "\" has no IPv4 address on this host: expected a name that `ip address` lists, or an address");
  }
  return address;
}

rtps::Locator_t locator(const std::string& address) {
  rtps::Locator_t result;
  if (!rtps::IPLocator::setIPv4(result, address)) {
    throw std::runtime_error("peer \"" + address +
                             "\" is not an IPv4 address: Fast DDS needs one, as in --peer 192.168.1.2");
  }
  return result;
}

dds::DomainParticipantQos participant_qos(const BusOptions& options) {
  dds::DomainParticipantQos qos;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  const int buffer = options.socket_buffer_bytes > 0 ? options.socket_buffer_bytes : 64 << 20;
  udp->receiveBufferSize = static_cast<std::uint32_t>(buffer);
  udp->sendBufferSize = 4 << 20;
  udp->maxInitialPeersRange = kMaxParticipantsPerHost;
  if (!options.network) udp->interfaceWhiteList.emplace_back("127.0.0.1");
  if (options.network && !options.interface.empty()) {
    udp->interfaceWhiteList.emplace_back(address_of(options.interface));
  }
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);

  auto& builtin = qos.wire_protocol().builtin;
  builtin.discovery_config.leaseDuration_announcementperiod = {0, 250'000'000};
  builtin.discovery_config.leaseDuration = {10, 0};
  if (!options.network) {
    builtin.avoid_builtin_multicast = true;
    builtin.metatrafficUnicastLocatorList.push_back(rtps::Locator_t());
    builtin.initialPeersList.push_back(locator("127.0.0.1"));
  } else if (!options.peers.empty()) {
    // a list of peers replaces the default one, which is the multicast group: name that too
    rtps::Locator_t group = locator("239.255.0.1");
    group.port = 7400 + 250 * static_cast<std::uint32_t>(options.domain);
    builtin.initialPeersList.push_back(group);
    for (const std::string& peer : options.peers) builtin.initialPeersList.push_back(locator(peer));
  }
  qos.name("palp");
  return qos;
}

// Fast DDS itself would only log a bad file and go on with its defaults, which reach every interface.
void load_profiles(const char* path) {
  if (dds::DomainParticipantFactory::get_instance()->load_XML_profiles_file(path) != ReturnCode_t::RETCODE_OK) {
    throw std::runtime_error(
        "Fast DDS cannot use the configuration in FASTRTPS_DEFAULT_PROFILES_FILE=" + std::string(path) +
        ": expected a readable, well-formed profiles file; correct or unset it");
  }
}

}  // namespace

FastddsParticipant::FastddsParticipant(const BusOptions& options) {
  // Peers in one process meet on the wire like any others: one path to trust.
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);

  auto* factory = dds::DomainParticipantFactory::get_instance();
  const char* profiles = std::getenv("FASTRTPS_DEFAULT_PROFILES_FILE");
  const auto domain = static_cast<std::uint32_t>(options.domain);
  if (profiles && *profiles) {
    load_profiles(profiles);
    participant_ = factory->create_participant(domain, dds::PARTICIPANT_QOS_DEFAULT);
  } else {
    participant_ = factory->create_participant(domain, participant_qos(options));
  }
  if (!participant_) {
    throw std::runtime_error("Fast DDS cannot open domain " + std::to_string(options.domain) + " on " +
                             (options.network ? "the network" : "the loopback interface") +
                             ": check --interface and --peer, and that fewer than 60 participants run on this host");
  }
}

FastddsParticipant::~FastddsParticipant() {
  if (!participant_) return;
  participant_->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

dds::Topic* FastddsParticipant::topic(const TopicRow& row, const dds::TypeSupport& type) {
  const std::lock_guard lock(topics_mutex_);
  if (auto* known = dynamic_cast<dds::Topic*>(participant_->lookup_topicdescription(row.name))) return known;
  type.register_type(participant_);
  dds::Topic* created = participant_->create_topic(row.name, row.type_name, dds::TOPIC_QOS_DEFAULT);
  if (!created) throw std::runtime_error(std::string("Fast DDS: cannot create the topic ") + row.name);
  return created;
}

namespace {

// Returns the settings that writers and readers have in common. Memory for samples is taken when they come and used
// again: the types have unbounded sequences and a deep history must not cost anything while it is empty.
template <class Qos>
Qos endpoint_qos(const TopicRow& topic, int depth) {
  Qos qos;
  const bool reliable = topic.reliability == Reliability::reliable;
  const bool kept = topic.durability == Durability::transient_local;
  qos.reliability().kind = reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = {0, 100'000'000};
  qos.durability().kind = kept ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  const int keys = topic.key_bytes > 0 ? kMaxKeys : 1;
  qos.resource_limits().max_instances = keys;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().max_samples = depth * keys;
  qos.resource_limits().allocated_samples = 0;
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  qos.data_sharing().off();
  return qos;
}

}  // namespace

dds::DataWriterQos fastdds_writer_qos(const TopicRow& topic) {
  auto qos = endpoint_qos<dds::DataWriterQos>(topic, topic.writer_depth);
  qos.reliable_writer_qos().times.heartbeatPeriod = {0, 100'000'000};
  return qos;
}

dds::DataReaderQos fastdds_reader_qos(const TopicRow& topic) {
  return endpoint_qos<dds::DataReaderQos>(topic, topic.reader_depth);
}

std::shared_ptr<Participant> open_fastdds(const BusOptions& options) {
  return std::make_shared<FastddsParticipant>(options);
}

}  // namespace palp
