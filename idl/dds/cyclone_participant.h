// A Cyclone DDS participant, configured from BusOptions. Private to what talks to Cyclone itself: the bus and the
// recorder.
#pragma once

#include <dds/dds.h>

#include <string>

#include "idl/vendor.h"

namespace palp {

class CycloneParticipant : public Participant {
 public:
  // Throws std::runtime_error with one sentence.
  explicit CycloneParticipant(const BusOptions& options);
  ~CycloneParticipant() override;
  CycloneParticipant(const CycloneParticipant&) = delete;
  CycloneParticipant& operator=(const CycloneParticipant&) = delete;

  dds_entity_t entity() const { return participant_; }

 private:
  dds_entity_t domain_ = 0;
  dds_entity_t participant_ = 0;
};

// The configuration that is used when CYCLONEDDS_URI is not set.
std::string cyclone_config(const BusOptions& options);

// The QoS of a topic's writers (reader == false) or readers. The caller deletes it (dds_delete_qos).
dds_qos_t* cyclone_qos(const TopicRow& topic, bool reader);

// Samples on that topic whose bytes Cyclone could not decode, in this process so far. Cyclone tells this only in its
// log, which opening a CycloneParticipant therefore takes over: the rest of it goes to stderr as before.
std::uint64_t cyclone_undecodable(const TopicRow& topic);

// Throws "what: reason" if result is an error; else gives it back.
dds_entity_t cyclone_check(dds_entity_t result, const std::string& what);

}  // namespace palp
