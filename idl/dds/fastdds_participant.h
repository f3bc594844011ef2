// A Fast DDS participant, configured from BusOptions. Private to what talks to Fast DDS itself: the bus and the
// recorder.
#pragma once

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include <mutex>

#include "idl/vendor.h"

namespace palp {

class FastddsParticipant : public Participant {
 public:
  // Throws std::runtime_error with one sentence.
  explicit FastddsParticipant(const BusOptions& options);
  ~FastddsParticipant() override;
  FastddsParticipant(const FastddsParticipant&) = delete;
  FastddsParticipant& operator=(const FastddsParticipant&) = delete;

  eprosima::fastdds::dds::DomainParticipant& get() const { return *participant_; }

  // The topic of that row with the given type, made on first use. Thread-safe. Throws std::runtime_error.
  eprosima::fastdds::dds::Topic* topic(const TopicRow& row, const eprosima::fastdds::dds::TypeSupport& type);

 private:
  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  std::mutex topics_mutex_;
};

eprosima::fastdds::dds::DataWriterQos fastdds_writer_qos(const TopicRow& topic);
eprosima::fastdds::dds::DataReaderQos fastdds_reader_qos(const TopicRow& topic);

}  // namespace palp
