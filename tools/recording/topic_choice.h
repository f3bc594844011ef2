// The things that the recorder and the replayer agree on beside the file format: names of topics on the command line,
// and how a topic is described in a recording.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "idl/topics.h"
#include "tools/recording/compression.h"

namespace palp {

// Returns the rows of the topics that the user named, with or without "palp/", in the order of kTopics; all when none
// is named. Throws std::invalid_argument listing the topics that there are.
std::vector<const TopicRow*> choose_topics(const std::vector<std::string>& names);
// Returns the topic of that name; null when there is none.
const TopicRow* find_topic(const std::string& name);

// Reads "particles=4" and the like: keep every 4th. Throws std::invalid_argument with one sentence.
std::map<const TopicRow*, unsigned> parse_decimation(const std::vector<std::string>& texts);

// Returns the channel's metadata: the QoS in the form that eProsima's DDS recorder writes, too.
std::map<std::string, std::string> channel_metadata(const TopicRow& topic);
// Positions do not get smaller by compression, everything else does.
Compression compression_for(const TopicRow& topic);

}  // namespace palp
